"""Commands in another unit than a model's, which says what they do."""
