"""Commands in another unit, with the wrong sign, or late against a model that says what they do."""
