"""A quadrotor of four MuJoCo actuators whose speeds are logged at 100 Hz: what turns it, brakes it, reacts on it."""

from __future__ import annotations

import pytest
from motor_flights import equations, motor_flights, with_speeds

from sym2real.diagnosis import diagnose, try_effect

HIDDEN = {
    "torque_scale": {"kx": 1.5, "ky": 0.7, "kz": 0.1},
    "rotor_reaction": {"value": 2e-8},
    "rate_damping": {"dx": 5e-5, "dy": 5e-5, "dz": 5e-5},
    "flapping_moment": {"a": 2e-5, "b": -2e-5},
}


@pytest.mark.slow
@pytest.mark.parametrize("key", HIDDEN)
def test_what_acts_on_the_rotation_of_a_robot_of_motors_is_named_and_nothing_beside_it(key: str) -> None:
    data = with_speeds(motor_flights(hidden={key: HIDDEN[key]}, every=1, seconds=6.0))
    found = diagnose(equations(unit="rad/s", every=1), data)
    assert found.verdict == "EFFECT"
    assert [one.effect for one in found.findings] == [key]
    assert found.findings[0].values == pytest.approx(HIDDEN[key], rel=0.05)


@pytest.mark.slow
def test_a_limit_that_all_motors_share_is_one_effect() -> None:
    names, hidden = ("circle", "circle", "lemniscate"), {"limit": {"upper": 0.5}}
    found = diagnose(equations(every=1), motor_flights(hidden=hidden, every=1, seconds=6.0, dither=0.03, names=names))
    assert [one.effect for one in found.findings] == ["limit"]
    assert found.findings[0].values == pytest.approx({"upper": 0.5}, rel=0.02)


@pytest.mark.slow
def test_rotors_that_react_a_little_are_named_although_they_move_one_direction_of_nine_alone() -> None:
    hidden = {"torque_scale": HIDDEN["torque_scale"], "rotor_reaction": {"value": 3e-9}}
    flights = motor_flights(hidden=hidden, every=1, seconds=6.0, names=("hover", "circle", "lemniscate") * 2)
    found = diagnose(equations(unit="rad/s", every=1), with_speeds(flights))
    assert [one.effect for one in found.findings] == list(hidden)
    assert found.findings[1].group == ("rotor_reaction",)


@pytest.mark.slow
@pytest.mark.parametrize("wrong", [1 / 25, 25.0])
def test_what_a_wrong_inertia_hides_is_named_beside_it(wrong: float) -> None:
    """Torques that are 25 times as strong, or as weak, as they should be turn the model over in half a second.

    With less dither the yaw hardly turns, and nothing tells its torque to a tenth.
    """
    hidden = {
        "linear_drag": {"cx": 0.01, "cy": 0.01, "cz": 0.01},
        "flapping_moment": {"a": 6e-5, "b": 6e-5},
        "rate_damping": {"dx": 4e-5, "dy": 4e-5, "dz": 4e-5},
    }
    names = ("hover", "circle", "lemniscate") * 2
    flights = motor_flights(hidden=hidden, every=1, seconds=6.0, dither=0.03, names=names)
    found = diagnose(equations(unit="rad/s", every=1, inertia=wrong), with_speeds(flights))
    named = {one.effect: one.values for one in found.findings}
    assert named.keys() == {"torque_scale", *hidden}
    assert named["torque_scale"] == pytest.approx(dict.fromkeys(("kx", "ky", "kz"), wrong), rel=0.1)
    factors = next(one.parameters for one in found.findings if one.effect == "torque_scale")
    for factor in factors.values():
        assert wrong / 1.5 < factor.low < wrong < factor.high < 1.5 * wrong
    moments = {name: value / wrong for key in ("flapping_moment", "rate_damping") for name, value in named[key].items()}
    assert moments == pytest.approx({**hidden["flapping_moment"], **hidden["rate_damping"]}, rel=0.2)


@pytest.mark.slow
def test_commands_that_are_sent_more_often_than_they_are_logged_are_no_effect() -> None:
    """Held over a row of five they turn the model by more than they turned the robot, which misses nothing."""
    model, data = equations(every=1), motor_flights(every=5, period=0.002, seconds=6.0)
    found = diagnose(model, data)
    assert [(one.effect, one.doubtful) for one in found.findings] == [("torque_scale", True)]
    assert found.verdict == "CANNOT_TELL"
    assert "commands that change between the rows" in found.summary
    assert found.apply(model).effects == ()
    assert "commands that change between the rows" in try_effect(model, "torque_scale", data).summary


@pytest.mark.slow
def test_a_robot_of_motors_that_misses_nothing_is_told_so() -> None:
    data = with_speeds(motor_flights(every=1, seconds=6.0))
    assert diagnose(equations(unit="rad/s", every=1), data).findings == ()
