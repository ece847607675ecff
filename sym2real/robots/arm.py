"""Arm of six joints that motors turn, on a fixed base; no short equation holds its motion."""

from pathlib import Path

from sym2real.robots.from_mjcf import from_mjcf

ARM = from_mjcf(Path(__file__).with_suffix(".xml"), title="Six-joint arm")
