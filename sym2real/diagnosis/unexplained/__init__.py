"""What is left when effects are found: pushes without a name, what they depend on, a term for them."""
