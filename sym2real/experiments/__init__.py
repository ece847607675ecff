"""Learned and cached bases, test flights and drives."""
