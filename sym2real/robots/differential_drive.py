"""Differential-drive robot: two wheels whose rates are commanded, and a caster."""

from pathlib import Path

from sym2real.robots import planar
from sym2real.robots.from_mjcf import from_mjcf

DIFFERENTIAL_DRIVE = from_mjcf(Path(__file__).with_suffix(".xml"), state=planar.STATE, title="Differential drive")
