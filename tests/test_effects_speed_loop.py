"""A speed loop that is slower or faster than nominal: in MuJoCo, as equations of that loop, in integrated drives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from effects_cases import Run, change, predicted, simulated

from sym2real.diagnosis import add, diagnose
from sym2real.effects import effect
from sym2real.errors import ModelError
from sym2real.robots import MUSHR, car
from sym2real.symbolic import compile_model
from sym2real.trajectory import Trajectory

WHEELBASE, NOMINAL, FINE = 0.32, 0.14, 1e-3
BASE = car(WHEELBASE, time_constant=NOMINAL, mass=3.0)


def driven(time: float, seed: int, rows: int = 400) -> Trajectory:
    """Speeds and steering angles drawn anew every second; the distance to the speed that is told falls by 1/τ."""
    rng, every = np.random.default_rng(seed), round(BASE.dt / FINE)
    x = y = yaw = speed = 0.0
    states, told = [], []
    for row in range(rows):
        if row % 20 == 0:
            wanted, steer = rng.uniform(0.3, 2.2), rng.uniform(-0.3, 0.3)
        states.append([x, y, yaw, speed * np.cos(yaw), speed * np.sin(yaw), speed * np.tan(steer) / WHEELBASE])
        told.append([steer, wanted])
        for _ in range(every):
            speed += FINE / time * (wanted - speed)
            yaw += FINE * speed * np.tan(steer) / WHEELBASE
            x, y = x + FINE * speed * np.cos(yaw), y + FINE * speed * np.sin(yaw)
    noisy = np.array(states) + rng.normal(size=(rows, 6)) * [0.002, 0.002, 0.005, 0.02, 0.02, 0.02]
    turned = [np.sin(noisy[:, 2]), np.cos(noisy[:, 2])]
    state = np.column_stack([noisy[:, :2], *turned, noisy[:, 3:]])
    return Trajectory.from_arrays(state, np.array(told), BASE.layouts, dt=BASE.dt)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_the_loop_is_that_of_softer_or_stiffer_servos(factor: float) -> None:
    """Straight ahead, in steps of the speed that spin no wheel; MuJoCo's own steps are fine beside the stiffer loop."""
    robot = replace(MUSHR, description=replace(MUSHR.description, physics_dt=FINE))
    speeds = np.repeat([[0.4, 0.8], [-0.3, 0.1], [0.5, 0.2]], 8, axis=1)
    actions = np.stack([np.zeros_like(speeds), speeds], axis=-1)
    given = Run(robot, np.repeat(robot.start[None], len(speeds), axis=0), actions)
    loop, base = effect("speed_loop", robot), robot.nominal()
    truth = change(robot, simulated(given, [loop.inject(value=factor)]), simulated(given, []))
    hypothesis = change(robot, *(predicted(model, given) for model in (loop.substitute(base, {"value": factor}), base)))
    size = np.linalg.norm(truth)
    assert size > 1.0
    assert (truth * hypothesis).sum() / (size * np.linalg.norm(hypothesis)) > 0.998
    assert np.linalg.norm(hypothesis) / size == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("factor", [0.5, 1.0, 2.0])
def test_the_speed_is_that_of_equations_of_the_other_time_constant(factor: float) -> None:
    other = car(WHEELBASE, time_constant=factor * NOMINAL, mass=3.0)
    log = driven(NOMINAL, 1, 60)
    given = [torch.as_tensor(values) for values in (log.state, log.action)]
    slower = add(BASE, "speed_loop", {"value": factor})
    found, wanted = (compile_model(model, dtype=torch.float64)(*given) for model in (slower, other))
    norms = [model[:, 4:6].norm(dim=1) for model in (found, wanted)]
    torch.testing.assert_close(norms[0], norms[1], rtol=1e-9, atol=1e-9)
    torch.testing.assert_close(found, wanted, rtol=0.0, atol=0.01 if factor != 1.0 else 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("time", [0.10, 0.20])
def test_another_time_constant_is_named(time: float) -> None:
    found = diagnose(BASE, [driven(time, seed) for seed in range(4)])
    (finding,) = found.findings
    assert finding.effect == "speed_loop", found.summary
    value = finding.parameters["value"]
    assert value.value * NOMINAL == pytest.approx(time, rel=0.03)
    assert value.low * NOMINAL <= time <= value.high * NOMINAL
    assert finding.fix.startswith(f"speed_time = {NOMINAL * value.value:.4g} (95 % ")
    assert f"in place of {NOMINAL:g}" in finding.fix


def test_what_has_no_speed_loop_has_none() -> None:
    for model in (car(WHEELBASE), car(WHEELBASE, command="acceleration")):
        with pytest.raises(ModelError, match="speed_loop"):
            add(model, "speed_loop", {"value": 2.0})
