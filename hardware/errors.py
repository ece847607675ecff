"""Errors of robots and of the links to them."""

from sym2real.errors import Sym2RealError


class LinkError(Sym2RealError):
    """A robot or a motion capture system that does not answer, or answers what cannot be flown with."""


class UnreachableError(LinkError):
    """A start that the safe controller cannot bring the robot to, with the reason."""
