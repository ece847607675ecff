"""Attitude loops that are slow, fast, trimmed or lean too little, against flights integrated every millisecond."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from sym2real.diagnosis import add, diagnose
from sym2real.effects import effect
from sym2real.errors import ModelError
from sym2real.robots import MUSHR, quadrotor
from sym2real.symbolic import compile_model
from sym2real.trajectory import Array, Trajectory

MASS, NOMINAL, FINE, GRAVITY = 1.2, 0.15, 1e-3, 9.81
LEVEL = Rotation.identity()
BASE = quadrotor(MASS, interface="thrust_attitude", attitude_time_constant=NOMINAL)


def flown(
    time: float,
    seed: int,
    rows: int = 400,
    *,
    trim: Rotation = LEVEL,
    board: Rotation = LEVEL,
    lean: tuple[float, float] = (1.0, 1.0),
    inner: float = 0.0,
) -> Trajectory:
    """Thrust and attitudes drawn anew every second; the angle to what is told falls by 1/τ.

    Args:
        trim: from the attitude that is told to the one that is held.
        board: from the robot's attitude to that of the sensor, which the loop sees and the log holds.
        lean: parts of the commanded roll and pitch, as Euler angles after a heading, that are held.
        inner: time in s in which the body follows the rates that the loop asks for; at once if 0.
    """
    rng, every = np.random.default_rng(seed), round(BASE.dt / FINE)
    place, velocity, attitude = np.array([0.0, 0.0, 2.0]), np.zeros(3), Rotation.identity()
    turning, follows = np.zeros(3), min(1.0, FINE / inner) if inner else 1.0
    states, told = [], list[Array]()
    for row in range(rows):
        if row % 50 == 0:
            angles = rng.uniform(-1.0, 1.0, 3) * (0.2, 0.15, 0.15)
            wanted = Rotation.from_euler("ZYX", angles)
            leaning = Rotation.from_euler("ZYX", angles * (1.0, lean[1], lean[0]))
            thrust = MASS * GRAVITY * rng.uniform(0.9, 1.15)
        held = leaning * trim * board.inv()
        states.append([*place, *np.roll((attitude * board).as_quat(), 1), *velocity])
        told.append(np.array([thrust, *np.roll(wanted.as_quat(), 1)]))
        for _ in range(every):
            turning = turning + follows * ((attitude.inv() * held).as_rotvec() / time - turning)
            halfway = attitude * Rotation.from_rotvec(turning * FINE / 2)  # at the end it would seem half a step faster
            attitude *= Rotation.from_rotvec(turning * FINE)
            velocity = velocity + FINE * (halfway.as_matrix()[:, 2] * thrust / MASS - (0.0, 0.0, GRAVITY))
            place = place + FINE * velocity
    noisy = np.array(states)
    noisy = noisy + rng.normal(0.0, 0.003, noisy.shape)
    state = BASE.layouts.state.normalise(torch.as_tensor(noisy)).numpy()
    return Trajectory.from_arrays(state, np.array(told), BASE.layouts, dt=BASE.dt)


@pytest.mark.parametrize("factor", [0.5, 1.0, 2.0])
def test_the_loop_is_that_of_the_other_time_constant(factor: float) -> None:
    """A step of the effect is one of the equations that were made with k τ, wherever the attitude is on the way."""
    other = quadrotor(MASS, interface="thrust_attitude", attitude_time_constant=factor * NOMINAL)
    log = flown(NOMINAL, 1, 60)
    given = [torch.as_tensor(values) for values in (log.state, log.action)]
    slower = add(BASE, "attitude_loop", {"value": factor})
    found, wanted = (compile_model(model, dtype=torch.float64)(*given) for model in (slower, other))
    moved = (found - given[0])[:, 3:7]
    torch.testing.assert_close(moved, (wanted - given[0])[:, 3:7], rtol=1e-6, atol=1e-9)
    torch.testing.assert_close(found, wanted, rtol=0.0, atol=2e-4)


@pytest.mark.slow
@pytest.mark.parametrize("time", [0.25, 0.09])
def test_another_time_constant_is_named(time: float) -> None:
    found = diagnose(BASE, [flown(time, seed) for seed in range(4)])
    assert found.findings, found.summary
    assert found.findings[0].effect == "attitude_loop", found.summary
    value = found.findings[0].parameters["value"]
    assert value.value * NOMINAL == pytest.approx(time, rel=0.05)
    assert value.low * NOMINAL <= time <= value.high * NOMINAL


@pytest.mark.slow
def test_another_trim_is_named_and_no_tilted_board() -> None:
    """The attitude that is held lies beside the one that is told, and thrust acts along it, as it is measured."""
    trim = Rotation.from_euler("XY", [0.034, -0.02])
    found = diagnose(BASE, [flown(NOMINAL, seed, trim=trim) for seed in range(4)])
    (finding,) = found.findings
    assert finding.effect == "attitude_trim", found.summary
    for name, angle in (("roll", 0.034), ("pitch", -0.02)):
        value = finding.parameters[name]
        assert value.low <= angle <= value.high
        assert value.value == pytest.approx(angle, abs=0.003)


@pytest.mark.slow
def test_a_smaller_lean_is_named_with_both_factors() -> None:
    """Roll and pitch are angles of Euler here: the swing that the effect scales is another one in the second order."""
    found = diagnose(BASE, [flown(NOMINAL, seed, lean=(0.85, 1.0)) for seed in range(4)])
    (finding,) = found.findings
    assert finding.effect == "attitude_gain", found.summary
    for name, factor in (("roll", 0.85), ("pitch", 1.0)):
        value = finding.parameters[name]
        assert value.low <= factor <= value.high


@pytest.mark.slow
def test_a_loop_of_second_order_is_two_lags_of_which_neither_is_dropped() -> None:
    """Of two lags of one time each alone has a wide interval, which holds none; beside them a smaller lean is plain."""
    found = diagnose(BASE, [flown(0.16, seed, lean=(0.88, 0.88), inner=0.04) for seed in range(4)])
    by_name = {finding.effect: finding.parameters for finding in found.findings}
    assert found.verdict == "EFFECT", found.summary
    assert {*by_name} == {"attitude_gain", "attitude_loop", "lag:attitude_cmd"}
    for factor in by_name["attitude_gain"].values():
        assert factor.low <= 0.88 <= factor.high
    # 1 + 0.16 s (1 + 0.04 s) = (1 + 0.08 s)²
    loop, lag = (by_name[name]["value"].value for name in ("attitude_loop", "lag:attitude_cmd"))
    assert loop * NOMINAL + lag == pytest.approx(0.16, rel=0.1)


@pytest.mark.parametrize("heading", [0.0, 0.7, -2.5])
def test_the_lean_is_scaled_about_its_own_axis_whatever_the_heading(heading: float) -> None:
    """With equal factors the sine of half the lean is k times as large, about the same axis, after the same heading."""
    wanted = Rotation.from_euler("Z", heading) * Rotation.from_rotvec([0.2, -0.3, 0.0])
    half = np.arcsin(0.8 * np.sin(np.hypot(0.2, 0.3) / 2))
    held = Rotation.from_euler("Z", heading) * Rotation.from_rotvec(2 * half * np.array([0.2, -0.3, 0.0]) / 0.36056)
    state = torch.as_tensor(flown(NOMINAL, 1, 2).state[:1])
    given, commanded = (
        torch.as_tensor([[MASS * GRAVITY, *np.roll(attitude.as_quat(), 1)]]) for attitude in (wanted, held)
    )
    leaning = compile_model(add(BASE, "attitude_gain", {"roll": 0.8, "pitch": 0.8}), dtype=torch.float64)
    torch.testing.assert_close(
        leaning(state, given), compile_model(BASE, dtype=torch.float64)(state, commanded), rtol=0.0, atol=1e-6
    )


@pytest.mark.slow
def test_a_tilted_board_is_no_trim() -> None:
    """What the sensor says is what was told; thrust acts beside it."""
    board = Rotation.from_euler("XY", [0.034, -0.02])
    found = diagnose(BASE, [flown(NOMINAL, seed, board=board) for seed in range(4)])
    assert [finding.effect for finding in found.findings] == ["mounting_tilt"], found.summary


@pytest.mark.slow
def test_a_loop_as_nominal_misses_nothing() -> None:
    assert not diagnose(BASE, [flown(NOMINAL, seed) for seed in range(4)]).findings


def test_who_is_told_no_attitude_has_none() -> None:
    at_once = quadrotor(MASS, interface="thrust_attitude", attitude_time_constant=0.0)
    for model in (MUSHR.nominal(), quadrotor(MASS), at_once):
        with pytest.raises(ModelError, match="attitude_loop"):
            add(model, "attitude_loop", {"value": 2.0})
    with pytest.raises(ModelError, match="no simulated robot"):
        effect("attitude_loop", BASE).inject(value=2.0)
    for name in ("attitude_trim", "attitude_gain"):
        with pytest.raises(ModelError, match="no simulated robot"):
            effect(name, BASE).inject(roll=0.02)
