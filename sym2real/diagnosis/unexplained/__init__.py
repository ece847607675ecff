"""What is left when effects are found: disturbances without a name, what they depend on, a term for them."""
