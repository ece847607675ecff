"""Units that logs are written in, and their factor to the SI unit that the package works in."""

from collections.abc import Sequence
from math import log, pi

from sym2real.errors import UnknownNameError
from sym2real.vocabulary import VOCABULARY

GRAVITY = 9.80665  # m/s², standard acceleration of free fall (CGPM 1901), which defines units

# SI unit → units of a log that become it, with their factors. "uint16" is a command of 0 … 65535 that stands for 0 … 1.
FACTORS: dict[str, dict[str, float]] = {
    "1": {"1": 1.0, "%": 0.01, "uint16": 1.0 / 65535.0},
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "rad": {"rad": 1.0, "mrad": 1e-3, "deg": pi / 180.0},
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "m/s": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "km/h": 1.0 / 3.6},
    "rad/s": {"rad/s": 1.0, "mrad/s": 1e-3, "deg/s": pi / 180.0, "rpm": 2.0 * pi / 60.0},
    "m/s^2": {"m/s^2": 1.0, "mm/s^2": 1e-3, "g": GRAVITY},
    "N": {"N": 1.0, "mN": 1e-3, "gf": 1e-3 * GRAVITY},
    "N m": {"N m": 1.0, "mN m": 1e-3},
    "V": {"V": 1.0, "mV": 1e-3},
}
# Unit in a log → (unit inside, factor).
UNITS = {unit: (inside, factor) for inside, units in FACTORS.items() for unit, factor in units.items()}
# A log's yaw becomes sine and cosine, a wheel's speed the velocity along the heading.
OF_LOGS = {"yaw": "rad", "wheel_speed": "m/s"}
UNIT_OF_COLUMN = {column: field.unit for _, field in VOCABULARY for column in field.columns} | OF_LOGS


def standard_unit(column: str) -> str | None:
    """SI unit of a standard column or of a reference to one (``ref_x``); None outside the vocabulary."""
    return UNIT_OF_COLUMN.get(column.removeprefix("ref_"))


def unit_by_ratio(ratio: float, units: Sequence[str]) -> str:
    """Of these the unit of numbers that are so many times as large as they would be in the SI unit."""
    return min(units, key=lambda unit: abs(log(max(ratio, 1e-12) * UNITS[unit][1])))


def factor(unit: str, column: str, mass: float = 1.0) -> float:
    """What values in ``unit`` are multiplied by to be in the SI unit of a standard column.

    Args:
        unit: key of :data:`UNITS`; empty for the column's own SI unit.
        column: standard column name; a name outside the vocabulary takes any unit.
        mass: kg; a thrust that is logged per unit mass (m/s^2 or g) is multiplied by it.

    Raises:
        UnknownNameError: when there is no such unit, or it measures something else than the column holds.
    """
    wanted = standard_unit(column)
    if not unit or unit == wanted:
        return 1.0
    inside, value = UNITS.get(unit, ("", 0.0))
    if wanted == "N" and inside == "m/s^2":
        return value * mass
    # A motor command has no dimension here, but a motor's speed may stand in its place.
    speeds_fit = column.startswith("motor") and inside == "rad/s"
    if not inside or (wanted is not None and inside != wanted and not speeds_fit):
        options = [name for name, (base, _) in UNITS.items() if wanted in {None, base}]
        raise UnknownNameError(f"unit of column {column!r}", unit, options)
    return value
