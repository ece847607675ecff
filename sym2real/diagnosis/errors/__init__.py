"""How large prediction errors are, where they are large, and what remains of them however good a model is."""
