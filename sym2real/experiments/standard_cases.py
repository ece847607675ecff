"""Which effects, of which size, the standard set has: single effects, pairs, and cases with nothing to find."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from sym2real.errors import UnknownNameError
from sym2real.experiments.standard_set import Case
from sym2real.robots import CRAZYFLIE, MUSHR

Values = Mapping[str, float]
Draw = Callable[[float, np.random.Generator], Values]

SEEDS, QUICK_SEEDS = 5, 2
NULLS, QUICK_NULLS = 300, 20
PAIR_SEEDS, QUICK_PAIR_SEEDS = 4, 1
# Cases get seeds of their own, so that no two share their noise.
FIRST_SEED = {"single": 10_000, "null": 20_000, "pair": 30_000}


@dataclass(frozen=True)
class Series:
    """An effect in several sizes.

    Args:
        key: of the effect.
        sizes: from the table, in rising order of what is missing.
        values: parameters for a size, directions drawn.
        yaws: with a heading that turns, or without, or both.
    """

    key: str
    sizes: tuple[float, ...]
    values: Draw = lambda size, rng: {"value": size}
    yaws: tuple[bool, ...] = (False,)

    @property
    def middle(self) -> float:
        """The size of the quick set: the larger of two."""
        return self.sizes[len(self.sizes) // 2]


def _along_an_axis(x: str, y: str) -> Draw:
    """± one of two parameters, the other at zero."""

    def draw(size: float, rng: np.random.Generator) -> Values:
        chosen, sign = rng.integers(2), rng.choice([-1.0, 1.0])
        return {x: float(sign * size * (chosen == 0)), y: float(sign * size * (chosen == 1))}

    return draw


def _wind(size: float, rng: np.random.Generator) -> Values:
    """The table's two winds by number."""
    fx, fy = ((0.6, -0.3), (2.0, 1.0))[int(size)]
    return {"fx": 0.01 * fx, "fy": 0.01 * fy}


def _same_along_axes(size: float, rng: np.random.Generator) -> Values:
    return {"cx": size, "cy": size, "cz": size}


FLIGHT_SERIES = (
    Series("added_mass", (0.0025, 0.005)),
    Series("gain:thrust", (0.9,)),
    Series("com_offset", (0.001, 0.002, 0.003), _along_an_axis("rx", "ry")),
    Series("wind", (0, 1), _wind, (False, True)),
    Series("linear_drag", (0.010, 0.020), _same_along_axes),
    Series("quadratic_drag", (0.008, 0.016)),
    Series("ground_effect", (0.175, 0.35)),
    Series("motor_lag", (0.03, 0.05, 0.07)),
    Series("delay", (0.02, 0.04, 0.06)),
    Series("battery_sag", (0.005, 0.01)),
    Series("mounting_tilt", (np.deg2rad(1.0), np.deg2rad(2.0)), _along_an_axis("roll", "pitch"), (False, True)),
    Series("torque_bias", (2e-5,), lambda size, rng: {"tz": size}),
)
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
    return (*_singles(robot, quick), *_pairs(robot, quick), *_nulls(robot, quick))


def hidden_case(robot: str, seed: int) -> Case:
    """A single effect of the standard set in one of its sizes; the flights' own noise and trim go with the seed."""
    singles = [case for case in standard_cases(robot) if len(case.effects) == 1]
    drawn = singles[int(np.random.default_rng(seed).integers(len(singles)))]
    return replace(drawn, seed=seed)


def _singles(robot: str, quick: bool) -> list[Case]:
    cases: list[Case] = []
    for series in SERIES[robot]:
        for size in (series.middle,) if quick else series.sizes:
            for yaw in series.yaws:
                for _ in range(QUICK_SEEDS if quick else SEEDS):
                    seed = FIRST_SEED["single"] + len(cases)
                    cases.append(Case(robot, (_drawn(series, size, seed),), seed, yaw))
    return cases


def _pairs(robot: str, quick: bool) -> list[Case]:
    of_key = {series.key: series for series in SERIES[robot]}
    cases: list[Case] = []
    for keys in PAIRS[robot]:
        for _ in range(QUICK_PAIR_SEEDS if quick else PAIR_SEEDS):
            seed = FIRST_SEED["pair"] + len(cases)
            effects = tuple(_drawn(of_key[key], of_key[key].middle, seed) for key in keys)
            cases.append(Case(robot, effects, seed, yaw=any(True in of_key[key].yaws for key in keys)))
    return cases


def _nulls(robot: str, quick: bool) -> list[Case]:
    return [Case(robot, (), FIRST_SEED["null"] + index) for index in range(QUICK_NULLS if quick else NULLS)]


def _drawn(series: Series, size: float, seed: int) -> tuple[str, Values]:
    return series.key, series.values(size, np.random.default_rng([seed, FIRST_SEED["single"]]))
