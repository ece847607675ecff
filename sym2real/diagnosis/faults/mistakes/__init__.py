"""Mistakes of a user: what was done to a log without wishing to, as transformations that one test judges alike."""
