"""What hypotheses predict: every candidate effect in one set of equations, rolled out with its derivatives."""
