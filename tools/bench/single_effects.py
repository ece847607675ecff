"""Single effects in several sizes, of which the standard set has all."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from standard_set import Case

Values = Mapping[str, float]
Draw = Callable[[float, np.random.Generator], Values]

SEEDS = 5
FIRST_SEED = 10_000


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

    def drawn(self, size: float, seed: int) -> tuple[str, Values]:
        """The effect in a size, its direction by the seed."""
        return self.key, self.values(size, np.random.default_rng([seed, FIRST_SEED]))


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


FLIGHT_SERIES = (
    Series("added_mass", (0.0025, 0.005)),
    Series("gain:thrust", (0.9,)),
    Series("com_offset", (0.001, 0.002, 0.003), _along_an_axis("rx", "ry")),
    Series("wind", (0, 1), _wind, (False, True)),
    Series("linear_drag", (0.010, 0.020), lambda size, rng: dict.fromkeys(("cx", "cy", "cz"), size)),
    Series("quadratic_drag", (0.008, 0.016)),
    Series("ground_effect", (0.175, 0.35)),
    Series("motor_lag", (0.03, 0.05, 0.07)),
    Series("delay", (0.02, 0.04, 0.06)),
    Series("battery_sag", (0.005, 0.01)),
    Series("mounting_tilt", (np.deg2rad(1.0), np.deg2rad(2.0)), _along_an_axis("roll", "pitch"), (False, True)),
    Series("torque_bias", (2e-5,), lambda size, rng: {"tz": size}),
    Series("mounting_yaw", (np.deg2rad(5.0),)),
    Series("yaw_bias", (np.deg2rad(5.0),)),
)


def singles(robot: str, series: Sequence[Series], seeds: int = SEEDS, *, middle: bool = False) -> list[Case]:
    """Every effect in every size, or in its middle one alone, with so many seeds each."""
    cases: list[Case] = []
    for one in series:
        for size in (one.middle,) if middle else one.sizes:
            for yaw in one.yaws:
                for _ in range(seeds):
                    seed = FIRST_SEED + len(cases)
                    cases.append(Case(robot, (one.drawn(size, seed),), seed, yaw))
    return cases


def hidden_case(robot: str, series: Sequence[Series], seed: int) -> Case:
    """One of the effects in one of its sizes; the flights' own noise and trim go with the seed."""
    cases = singles(robot, series)
    return replace(cases[int(np.random.default_rng(seed).integers(len(cases)))], seed=seed)
