"""Which effects, of which size, the standard set has: single effects, pairs, and cases with nothing to find."""

import numpy as np
from single_effects import FLIGHT_SERIES, SEEDS, Series, singles
from standard_set import Case

from sym2real.errors import UnknownNameError
from sym2real.robots import CRAZYFLIE, MUSHR

QUICK_SEEDS = 2
NULLS, QUICK_NULLS = 300, 20
PAIR_SEEDS, QUICK_PAIR_SEEDS = 4, 1
# Cases get seeds of their own, so that no two share their noise.
FIRST_NULL, FIRST_PAIR = 20_000, 30_000

DRIVE_SERIES = (
    Series("offset:steer", (0.02, 0.05, 0.1)),
    Series("gain:steer", (0.95, 0.85)),
    Series("gain:speed", (0.97, 0.9)),
    Series("tyre_friction", (0.4, 0.3)),
    Series("lag:steer", (0.05, 0.1)),
    Series("delay", (0.05, 0.1, 0.2)),
    Series("rolling_resistance", (0.5,)),
    Series("lag:speed", (0.3,)),
    Series("lateral_slip", (5.0,)),
    Series("yaw_drag", (4.0,)),
    Series("yaw_bias", (np.deg2rad(2.0),)),
)
PAIRS = {
    CRAZYFLIE.name: (
        ("added_mass", "com_offset"),
        ("added_mass", "delay"),
        ("gain:thrust", "linear_drag"),
        ("motor_lag", "wind"),
        ("ground_effect", "mounting_tilt"),
    ),
    MUSHR.name: (
        ("offset:steer", "gain:speed"),
        ("offset:steer", "delay"),
        ("gain:speed", "yaw_bias"),
        ("lag:steer", "rolling_resistance"),
    ),
}
SERIES = {CRAZYFLIE.name: FLIGHT_SERIES, MUSHR.name: DRIVE_SERIES}


def standard_cases(robot: str, quick: bool = False) -> tuple[Case, ...]:
    """Every case of the standard set of a robot: single effects, pairs, then null cases.

    Args:
        robot: name.
        quick: every effect at its middle size with 2 seeds, one pair of each kind, 20 null cases.

    Raises:
        UnknownNameError: for a robot that has no standard set.
    """
    if robot not in SERIES:
        raise UnknownNameError("robot of the standard set", robot, SERIES)
    alone = singles(robot, SERIES[robot], QUICK_SEEDS if quick else SEEDS, middle=quick)
    return (*alone, *_pairs(robot, quick), *_nulls(robot, quick))


def _pairs(robot: str, quick: bool) -> list[Case]:
    of_key = {series.key: series for series in SERIES[robot]}
    cases: list[Case] = []
    for keys in PAIRS[robot]:
        for _ in range(QUICK_PAIR_SEEDS if quick else PAIR_SEEDS):
            seed = FIRST_PAIR + len(cases)
            effects = tuple(of_key[key].drawn(of_key[key].middle, seed) for key in keys)
            cases.append(Case(robot, effects, seed, yaw=any(True in of_key[key].yaws for key in keys)))
    return cases


def _nulls(robot: str, quick: bool) -> list[Case]:
    return [Case(robot, (), FIRST_NULL + index) for index in range(QUICK_NULLS if quick else NULLS)]
