"""The project's own real log: one flight of a Crazyflie 2.1; see ``flights/NOTICE`` for its source and licence."""

from pathlib import Path


def example_flight() -> Path:
    """Path of a recorded figure-eight flight (CSV, log specification ``crazyflie_battery_drag``).

    Examples:
        >>> example_flight().suffix
        '.csv'
    """
    return Path(__file__).parent / "flights" / "B3_figure8_fast_rep1.csv"
