"""From a robot description to symbolic equations, control, and the physical effect that a model misses."""
