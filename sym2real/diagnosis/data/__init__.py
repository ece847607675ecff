"""Logs cut into what a model is held against: rows to start from, segments, windows, what a person says of them."""
