"""A car whose two sides, or two ways, answer differently: servos are set end by end, drivers way by way."""

from __future__ import annotations

import numpy as np
import pytest

from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.robots import car
from sym2real.trajectory import Trajectory

WHEELBASE, DT, FINE = 0.32, 0.05, 10
BASE = car(WHEELBASE, dt=DT)


def driven(seed: int, left: float = 1.0, back: float = 1.0) -> Trajectory:
    """Commands drawn anew every 0.8 s; those to the left, or back, are answered by this part. It slips nowhere."""
    rng = np.random.default_rng(seed)
    x = y = yaw = speed = rate = 0.0
    states, sent = [], []
    for row in range(400):
        states.append([x, y, yaw, speed, rate])
        if row % 16 == 0:
            steer, wanted = rng.uniform(-0.45, 0.45), rng.choice([-1.0, 1.0], p=[0.3, 0.7]) * rng.uniform(0.4, 1.5)
            speed = wanted * (back if wanted < 0 else 1.0)
            rate = speed * np.tan(steer * (left if steer > 0 else 1.0)) / WHEELBASE
        sent.append([steer, wanted])
        for _ in range(FINE):
            yaw += 0.5 * rate * DT / FINE
            x, y = x + speed * np.cos(yaw) * DT / FINE, y + speed * np.sin(yaw) * DT / FINE
            yaw += 0.5 * rate * DT / FINE
    x, y, yaw, speed, rate = np.array(states).T
    x, y = (values + 0.001 * rng.standard_normal(len(values)) for values in (x, y))
    yaw, rate = yaw + 0.003 * rng.standard_normal(len(yaw)), rate + 0.02 * rng.standard_normal(len(rate))
    columns = {"x": x, "y": y, "sin_yaw": np.sin(yaw), "cos_yaw": np.cos(yaw), "wz": rate}
    columns |= {"vx": np.gradient(x, DT), "vy": np.gradient(y, DT)}
    state = np.stack([columns[name] for name in BASE.layouts.state], axis=1)
    return Trajectory.from_arrays(state, np.array(sent), BASE.layouts, dt=DT, name=f"drive {seed}")


@pytest.mark.parametrize(
    ("key", "sides"), [("steering_asymmetry", {"left": 0.88}), ("speed_asymmetry", {"back": 0.85})]
)
def test_two_gains_of_two_sides_are_named(key: str, sides: dict[str, float]) -> None:
    found = diagnose(BASE, Dataset([driven(seed, **sides) for seed in range(4)]))
    (weak,), column = sides.values(), key.partition("_")[0].replace("steering", "steer")
    values = {finding.effect: finding.values["value"] for finding in found.findings}
    assert values.keys() == {key, f"gain:{column}"}, found.summary
    # To the left, and ahead, commands are more than none.
    sign = -1.0 if "left" in sides else 1.0
    assert values[key] == pytest.approx(sign * (1.0 - weak) / 2, abs=0.01)


def test_alike_sides_have_no_asymmetry() -> None:
    assert not diagnose(BASE, Dataset([driven(seed) for seed in range(4)])).findings
