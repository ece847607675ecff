"""Fits: the covariance of errors, joint Gauss-Newton steps, the base's own errors, tests beyond chance."""
