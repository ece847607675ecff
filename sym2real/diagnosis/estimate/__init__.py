"""Fits: the covariance that weighs errors, joint Gauss-Newton steps, the base's own errors, tests beyond chance."""
