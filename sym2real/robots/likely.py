"""Numbers that no robot of a kind has: told as a slip of units, with the number that is likely meant.

Only what is too large is told: SI units are the largest that people measure small robots in.
"""

from collections.abc import Mapping
from dataclasses import dataclass

# What a number in another unit is worth in SI.
SMALLER = {
    "m": {"cm": 1e-2, "mm": 1e-3},
    "kg": {"g": 1e-3},
    "kg m²": {"kg cm²": 1e-4, "g cm²": 1e-7},
}


@dataclass(frozen=True)
class Likely:
    """The largest value of a number, and whose it is."""

    most: float
    unit: str
    of: str

    def sentences(self, name: str, value: float) -> list[str]:
        """A sentence where a value is beyond it."""
        if value <= self.most:
            return []
        meant = [f"{value * worth:.3g} {self.unit} if it is in {unit}" for unit, worth in SMALLER[self.unit].items()]
        excess = f"{name} {value:.4g} {self.unit}: more than {self.most:.3g} {self.unit}, {self.of}"
        return [f"{excess}; is the unit right? ({', '.join(meant)})"]


# Class C3 of Regulation (EU) 2019/945: below 25 kg and 3 m across.
HEAVIEST, ACROSS = 25.0, 3.0
WEIGHT = Likely(HEAVIEST, "kg", "the heaviest drone of the EU's open category")
ARM = Likely(ACROSS / 2, "m", "half of the widest drone of the EU's open category")
WHEELBASE = Likely(4.0, "m", "the wheelbase of the longest passenger cars")
# A MuSHR weighs 140 kg per m³ of its wheelbase cubed, a road car of 1500 kg and 2.7 m 76.
DENSEST = 1000.0


def unlikely_in_quadrotor(mass: float, numbers: Mapping[str, float]) -> list[str]:
    """A sentence for each SI number that no quadrotor has; most inertia is all of its mass at its arms' ends."""
    moment = Likely(mass * ARM.most**2, "kg m²", "that of all its mass at the ends of the longest arms")
    known = {"arm": ARM, **dict.fromkeys(("jx", "jy", "jz"), moment)}
    beyond = [line for name, limit in known.items() if name in numbers for line in limit.sentences(name, numbers[name])]
    return [*WEIGHT.sentences("mass", mass), *beyond]


def unlikely_in_car(wheelbase: float, mass: float) -> list[str]:
    """The same of a car, in m and kg."""
    weight = Likely(DENSEST * wheelbase**3, "kg", "that of water in a cube of its wheelbase")
    return [*WHEELBASE.sentences("wheelbase", wheelbase), *weight.sentences("mass", mass)]
