"""Small effects in logs whose velocities are so noisy that they fill the loss."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose, try_effect
from sym2real.logs.derive import counted_heading, slope
from sym2real.plants import MujocoPlant
from sym2real.robots import MUSHR


def located(seed: int, gain: float | None = None) -> Dataset:
    """Drives as a poor localisation logs them: a centimetre and a degree of noise, rates from these alone."""
    rng, logs = np.random.default_rng(seed), []
    effects = () if gain is None else (("gain:steer", {"value": gain}),)
    for log in simulate_case(Case("mushr", effects, seed=seed), trajectories=6):
        x, y = (log.column(name) + 0.01 * rng.standard_normal(len(log)) for name in "xy")
        heading = counted_heading(log.column("sin_yaw"), log.column("cos_yaw"))
        heading = heading + np.deg2rad(1.1) * rng.standard_normal(len(log))
        rates = [np.diff(place, prepend=place[0]) / log.dt for place in (x, y)]
        turning = slope(log.time, heading, 3)
        state = np.column_stack([x, y, np.sin(heading), np.cos(heading), *rates, turning])
        logs.append(replace(log, state=state))
    return Dataset(logs)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [72, 75])
def test_an_effect_of_less_than_a_hundredth_of_the_loss_is_named_where_it_is_alone(seed: int) -> None:
    logs, plant = located(seed, gain=0.981), MujocoPlant(MUSHR)
    tried = try_effect(MUSHR.nominal(), "gain:steer", logs, plant=plant)
    assert 0.005 < tried.gain < 0.01
    assert tried.supported
    (finding,) = diagnose(MUSHR.nominal(), logs, plant=plant).findings
    assert {"gain:steer", "wheelbase"} <= {*finding.group}  # of a fiftieth nobody knows which
    shorter = 0.981 if finding.effect == "gain:steer" else 1 / 0.981
    assert finding.parameters["value"].low < shorter < finding.parameters["value"].high


@pytest.mark.slow
@pytest.mark.parametrize("seed", [72, 75])
def test_without_it_nothing_is_missing(seed: int) -> None:
    assert diagnose(MUSHR.nominal(), located(seed), plant=MujocoPlant(MUSHR)).verdict == "NOTHING_MISSING"
