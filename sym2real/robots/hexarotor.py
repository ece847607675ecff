"""Hexarotor of 1.5 kg whose six motors are commanded, each from 0 to 1; no loop flies it but the controller's."""

from pathlib import Path

from sym2real.robots.from_mjcf import WEIGHTS, from_mjcf
from sym2real.robots.recipe import Recipe

ROTORS = 6

HEXAROTOR = from_mjcf(
    Path(__file__).with_suffix(".xml"),
    title="Hexarotor",
    recipe=Recipe(
        tasks=(("hover", {}), ("circle", {})),
        base="nominal",
        dither=(0.01,) * ROTORS,
        dependencies=tuple(("vz", f"motor{number}") for number in range(1, ROTORS + 1)),
        cost_weights=WEIGHTS,
    ),
)
