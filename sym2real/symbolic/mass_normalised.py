"""Equations whose mass nobody gave: forces, torques and masses count per kilogram of the robot, and so do units."""

# The note of such equations.
PER_KILOGRAM = "no mass was given: forces, drag and masses are per kilogram of the robot"

UNIT_PER_KILOGRAM = {
    "N": "m/s²",
    "N/s": "m/s³",
    "N s": "m/s",
    "N s/m": "1/s",
    "N s²/m²": "1/m",
    "N m": "m²/s²",
    "N m s": "m²/s",
    "kg": "1",
    "kg m²": "m²",
}


def unit_for(described: object, unit: str) -> str:
    """The unit of a robot with a mass as it reads for equations, or a robot, that may have none."""
    return UNIT_PER_KILOGRAM.get(unit, unit) if PER_KILOGRAM in getattr(described, "notes", ()) else unit


def units_notes(described: object) -> tuple[str, ...]:
    """What a reader of forces and masses must know, where nobody gave the robot's mass."""
    return (PER_KILOGRAM,) if PER_KILOGRAM in getattr(described, "notes", ()) else ()
