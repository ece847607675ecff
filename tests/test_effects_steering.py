"""A car with a gyro whose steering is late: the heading goes by the wheels' mean angle, the gyro by that at the end.

The truth is a bicycle that is integrated a hundred times a control period, with a servo of its own.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import torch

from sym2real.dataset import Dataset
from sym2real.diagnosis import try_effect
from sym2real.effects import compose, effect
from sym2real.effects.along_logs import predicted_from, prepared
from sym2real.layout import Layout
from sym2real.robots import MUSHR, car
from sym2real.trajectory import Array, Trajectory

WHEELBASE, SPEED, ROWS, FINE = MUSHR.numbers["wheelbase"], 1.5, 300, 100
NOISE = np.array([0.002, 0.002, 0.005, 0.005, 0.02, 0.02, 0.02])
BASE = car(wheelbase=WHEELBASE, dt=MUSHR.dt, robot=MUSHR.name)


def wheels(commands: Array, *, late: float, lag: float, frequency: float, rate: float) -> Array:
    """Angles of the wheels ``# (ROWS * FINE,)``: a delay, then a lag, an oscillator damped by 0.7 or a rate limit."""
    step = MUSHR.dt / FINE
    sent = np.repeat(commands, FINE)
    shift = round(late / step)
    sent = np.concatenate([np.full(shift, sent[0]), sent[: len(sent) - shift]])
    angle, turning, angles = sent[0], 0.0, np.empty_like(sent)
    for place, wanted in enumerate(sent):
        angles[place] = angle
        if frequency:
            turning += step * (frequency**2 * (wanted - angle) - 1.4 * frequency * turning)
            angle += step * turning
        elif rate:
            angle += np.clip(wanted - angle, -rate * step, rate * step)
        else:
            angle = wanted + (angle - wanted) * np.exp(-step / lag) if lag else wanted
    return angles


def drive(seed: int, noise: float, **servo: float) -> Trajectory:
    rng, step = np.random.default_rng(seed), MUSHR.dt / FINE
    commands = 0.25 * np.sin(np.cumsum(rng.uniform(0.02, 0.3, ROWS))) + 0.05 * rng.standard_normal(ROWS)
    ideal = {"late": 0.0, "lag": 0.0, "frequency": 0.0, "rate": 0.0}
    rates = SPEED * np.tan(wheels(commands, **ideal | servo)) / WHEELBASE
    yaw = np.concatenate([[0.0], np.cumsum(rates * step)[:-1]])
    way = np.stack([np.cos(yaw), np.sin(yaw)], axis=1)
    place = np.concatenate([np.zeros((1, 2)), np.cumsum(SPEED * way * step, axis=0)[:-1]])
    rows = np.arange(ROWS) * FINE
    state = np.concatenate(
        [place[rows], way[rows][:, ::-1], SPEED * way[rows], rates[np.maximum(rows - 1, 0)][:, None]], axis=1
    )
    state += noise * NOISE * rng.standard_normal(state.shape)
    state = MUSHR.layouts.state.normalise(torch.as_tensor(state)).numpy()
    actions = np.stack([commands, np.full(ROWS, SPEED)], axis=1)
    return Trajectory(np.arange(ROWS) * MUSHR.dt, state, actions, np.zeros((ROWS, 3)), MUSHR.layouts, name=f"{seed}")


@cache
def drives(**servo: float) -> Dataset:
    return Dataset([drive(seed, 1.0, **servo) for seed in range(4)])


@pytest.mark.parametrize(
    ("key", "servo", "value"),
    [
        ("lag:steer", {"lag": 0.02}, 0.02),
        ("lag:steer", {"lag": 0.1}, 0.1),
        ("delay:steer", {"late": 0.03}, 0.03),
        ("delay", {"late": 0.12}, 0.12),
        ("rate_limit:steer", {"rate": 0.9}, 0.9),
        ("lag:steer", {"frequency": 45.0}, 1.4 / 45.0),  # an oscillator is late by twice its damping over its frequency
    ],
)
def test_its_time_is_known_within_a_period(key: str, servo: dict[str, float], value: float) -> None:
    found = try_effect(BASE, key, drives(**servo)).finding
    time = found.parameters["value"]
    assert time.value == pytest.approx(value, abs=0.05 * MUSHR.dt, rel=0.01)
    assert time.low <= value <= time.high
    assert found.parameters["mean_share"].value < 0.1


@pytest.mark.parametrize(
    ("servo", "chosen"),
    [
        ({"lag": 0.03}, [("lag:steer", 0.03)]),
        ({"late": 0.07}, [("delay:steer", 0.07)]),
        ({"rate": 0.9}, [("rate_limit:steer", 0.9)]),
        ({"late": 0.1, "lag": 0.03}, [("delay", 0.1), ("lag:steer", 0.03)]),
    ],
)
def test_heading_and_gyro_are_both_those_of_the_wheels(
    servo: dict[str, float], chosen: list[tuple[str, float]]
) -> None:
    """Of every row but the first ones, before which nobody knows what was sent."""
    equations = compose(BASE, [(effect(key, BASE), {"value": value}) for key, value in chosen])
    log = drive(5, 0.0, **servo)
    model, (ready,) = prepared(equations, Dataset([log]))
    rows = np.arange(5, ROWS - 1)
    missed = predicted_from(model, ready, rows, 1)[:, 0].numpy() - log.state[rows + 1]
    assert np.abs(missed[:, 2:4]).max() < 2e-3  # 0.1 where the steering is not late
    assert np.abs(missed[:, 6]).max() < 0.01


def test_only_the_steering_of_a_car_with_a_gyro_has_a_hidden_state() -> None:
    state = Layout.of(("x", "y", "sin_yaw", "cos_yaw", "vx", "vy"))
    following = {name: value for name, value in BASE.next.items() if name != "wz"}
    blind = replace(BASE, layouts=replace(BASE.layouts, state=state), next=following)
    for base, key, names in (
        (BASE, "lag:steer", ["value", "mean_share"]),
        (BASE, "lag:speed", ["value"]),
        (blind, "lag:steer", ["value"]),
        (blind, "delay", ["value"]),
    ):
        late = effect(key, base).substitute(base, {"value": 0.1})
        assert [one.name for one in effect(key, base).parameters] == names
        assert bool(late.start) == (len(names) > 1)
        assert [filtered for filtered, _ in late.filters] == [key]
