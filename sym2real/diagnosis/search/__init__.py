"""Which effects are there, and which the data cannot tell from them."""
