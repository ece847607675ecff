"""Cart-pole: a cart that a motor pushes along a rail, and a pole on it that is held upright."""

from pathlib import Path

from sym2real.robots.from_mjcf import from_mjcf

CART_POLE = from_mjcf(Path(__file__).with_suffix(".xml"), title="Cart-pole")
