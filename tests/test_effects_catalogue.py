"""The registry: every name of the design, described; keys; groups; corrections."""

from __future__ import annotations

import math

import numpy as np
import pytest
from answers import same_group
from effects_cases import CASES, nominal, one_key_per_kind
from paper_robots import PAPER_ROBOTS

from sym2real.diagnosis import add
from sym2real.effects import EFFECTS, GROUPS, applicable, effect, equivalents
from sym2real.effects.catalogue import always_alike, known, require_patterns
from sym2real.errors import ModelError, UnknownNameError
from sym2real.robots import CRAZYFLIE, MUSHR, Motors, Robot, car, quadrotor
from sym2real.symbolic import Equations

COMMAND = {"gain", "offset", "limit", "rate_limit", "delay", "lag", "dead_band", "dead_zone"}
QUADROTOR = {
    *("added_mass", "payload", "thrust_curve", "battery_sag", "com_offset", "rotor_loss", "ground_effect"),
    *("torque_bias", "motor_lag", "rate_loop_gain", "rate_damping", "flapping_moment", "translational_lift"),
    *("rotor_reaction", "mounting_tilt", "marker_tilt", "mounting_yaw", "inertia_axes"),
}
CAR = {
    *("tyre_friction", "lateral_slip", "rolling_resistance", "slope", "wheelbase", "yaw_drag"),
    *("tyre_slip", "understeer", "relaxation_length", "yaw_inertia", "steering_curve", "speed_curve"),
    *("steering_asymmetry", "speed_asymmetry"),
    "speed_loop",
}
BOTH = {"wind", "linear_drag", "quadratic_drag", "periodic_force", "yaw_bias", "lever_arm"}
MOTORS_ONLY, ATTITUDE_ONLY = {"torque_scale"}, {"attitude_loop", "attitude_trim", "attitude_gain"}
WHEELS_ONLY = {"turning_friction", "wheel_radius", "track_width", "wheel_grip", "carried_mass"}
JOINTS = {
    *("joint_damping", "joint_friction", "joint_stiffness", "armature", "link_mass"),
    *("servo_gain", "gravity_tilt", "load", "link_centre", "link_inertia", "link_length"),
    *("joint_drag", "joint_bias", "torque_ripple", "stribeck", "servo_limit"),
}
OWN = {"parameter"}  # of equations with named parameters, which the package's robots do not have
SENSOR = {"sensor_sign", "sensor_bias", "sensor_scale", "sensor_lag", "time_shift"}
UNITS = {
    *("1", "N", "rad", "rad/s", "rad/s²", "m/s", "m/s²", "m", "s", "kg", "kg m²", "N m", "N m s", "N s", "N/s"),
    *(
        "N m/rad",
        "N/m",
        "s/m",
        "N s/m",
        "N s²/m²",
        "1/s",
        "1/V",
        "1/rad²",
        "s²/m²",
        "s²/m",
        "rad s²/m",
        "N m s²",
        "rad/m",
    ),
}


def test_the_registry_has_the_names_of_the_design() -> None:
    everywhere, some = COMMAND | BOTH | SENSOR, MOTORS_ONLY | ATTITUDE_ONLY | WHEELS_ONLY | JOINTS | OWN
    assert set(EFFECTS) == everywhere | some | QUADROTOR | CAR
    for name, kind in EFFECTS.items():
        assert kind.name == name


@pytest.mark.parametrize("kind", ["offset", "limit", "dead_band", "rate_limit"])
def test_bounds_of_motors_go_by_their_unit(kind: str) -> None:
    """Motors that hover at half command, and the same ones in rad/s: as wide, beside what carries the robot."""
    share = 0.027 * 9.81 / 4
    commands, speeds = Motors(share / 0.5), Motors(2.2e-8, "rad/s")
    widths = []
    for motors, hover in ((commands, 0.5), (speeds, (share / 2.2e-8) ** 0.5)):
        one = effect(f"{kind}:motor1", quadrotor(0.027, interface="motors", motors=motors))
        widths.append([(parameter.high / hover, parameter.scale / hover) for parameter in one.parameters])
        assert one.parameters[0].unit.startswith("rad/s") == (motors is speeds)
    np.testing.assert_allclose(widths[1], widths[0], rtol=1e-6)


@pytest.mark.parametrize("robot", PAPER_ROBOTS.values(), ids=PAPER_ROBOTS)
def test_robots_have_their_effects(robot: Robot) -> None:
    own = QUADROTOR if robot is CRAZYFLIE else CAR
    assert {found.kind for found in applicable(nominal(robot))} == COMMAND | own | BOTH | SENSOR


@pytest.mark.parametrize("name", EFFECTS)
def test_an_effect_is_described(name: str) -> None:
    kind = EFFECTS[name]
    texts = (kind.summary, kind.confused_with, kind.shown_by, kind.fix, kind.formula)
    assert all(len(text) > 5 and not text.endswith(" ") for text in texts)
    assert kind.summary.endswith(".")
    equations = kind.substitute or (kind.parts and not kind.shared)  # what is shared stands beside a filter
    assert bool(kind.memory) != bool(equations)


@pytest.mark.parametrize("robot", PAPER_ROBOTS.values(), ids=PAPER_ROBOTS)
def test_parameters_have_units_bounds_and_scale(robot: Robot) -> None:
    for key in one_key_per_kind(robot):
        for parameter in effect(key, robot).parameters:
            assert parameter.unit in UNITS, (key, parameter)
            assert parameter.scale > 0, (key, parameter)
            assert parameter.low < parameter.high, (key, parameter)
            unlimited = abs(parameter.null) >= 1e15
            assert unlimited or parameter.low <= parameter.null <= parameter.high, (key, parameter)
    names = [parameter.name for parameter in effect("wind", robot).parameters]
    assert names == (["fx", "fy", "fz"] if robot is CRAZYFLIE else ["fx", "fy"])


def test_only_motors_have_a_torque_of_their_own() -> None:
    kinds = {one.kind for one in applicable(quadrotor(0.027, interface="motors"))}
    assert kinds - {one.kind for one in applicable(nominal(CRAZYFLIE))} == MOTORS_ONLY


def test_bounds_scale_with_the_robot() -> None:
    """A robot of eight times the mass and twice the size: inertia by 32, weight by 8, wheelbase by 2."""
    speeds = {size: Motors(2.2e-8 * size**4, "rad/s") for size in (1, 2)}
    small, large = (
        quadrotor(0.027 * size**3, [1.6e-5 * size**5] * 3, interface="motors", motors=motors)
        for size, motors in speeds.items()
    )
    for key, power in (("rotor_reaction", 5), ("rate_damping", 3), ("flapping_moment", 3), ("torque_scale", 0)):
        bounds = [[(p.high, p.scale) for p in effect(key, base).parameters] for base in (small, large)]
        np.testing.assert_allclose(bounds[1], 2.0**power * np.array(bounds[0]), err_msg=key)
    (near, _), (far, _) = (effect("relaxation_length", car(length)).parameters for length in (0.3, 0.6))
    assert (far.high, far.scale) == pytest.approx((2 * near.high, 2 * near.scale))


def test_keys_bind_columns_and_faults_name_the_nearest() -> None:
    assert effect("gain:thrust", CRAZYFLIE).parameters[0].unit == "1"
    assert effect("offset:thrust", CRAZYFLIE).parameters[0].unit == "N"
    assert effect("rate_limit:wx_cmd", CRAZYFLIE).parameters[0].unit == "rad/s²"
    assert effect("delay", MUSHR).filtered_columns == [0, 1]
    assert effect("delay:speed", MUSHR).filtered_columns == [1]
    for key, hint in (
        ("widn", "'wind'"),
        ("gain:trust", "'gain:thrust'"),
        ("gain", "gain:thrust"),
        ("wind:x", "wind"),
        ("sensor_bias:thrust", "sensor_bias:x"),
    ):
        with pytest.raises(UnknownNameError, match=hint):
            effect(key, CRAZYFLIE)


def test_groups_are_symmetric_and_name_real_effects() -> None:
    for group in GROUPS:
        assert len(group.while_) > 3
        for member in group.members:
            assert member.partition(":")[0] in EFFECTS
            assert set(group.members) - {member} <= {*equivalents(member), member}
    assert effect("added_mass", CRAZYFLIE).group == ("gain:thrust", "offset:thrust")
    assert effect("wind", CRAZYFLIE).group == ("mounting_tilt",)
    assert effect("wind", MUSHR).group == ("slope",)
    assert same_group("wind", "mounting_tilt")
    assert same_group("offset:wy_cmd", "com_offset")
    assert not same_group("wind", "added_mass")
    assert set(equivalents("payload")) == {"added_mass", "com_offset"}


def test_what_stands_for_an_effect_stands_for_itself() -> None:
    """And for equal effects: both always move the robot alike, so that no flight parts them."""
    for equations in (nominal(CRAZYFLIE), nominal(MUSHR), quadrotor(0.027, interface="motors")):
        effects = {one.key: one for one in known(equations)}
        for key, one in effects.items():
            if one.stood_for_by in effects:
                assert effects[one.stood_for_by].stood_for_by == "", key
                assert key in always_alike(one.stood_for_by, equations)


@pytest.mark.parametrize("robot", PAPER_ROBOTS.values(), ids=PAPER_ROBOTS)
def test_searches_start_within_bounds_and_plans_try_what_there_can_be(robot: Robot) -> None:
    values = np.linspace(robot.low, robot.high, 50)
    for one in applicable(nominal(robot)):
        searching, first = one.searching, one.parameters[0]
        if searching.why_not(one.body) or one.column not in robot.layouts.action:
            continue
        sent = values[:, robot.layouts.action.index(one.column)]
        free = [each for each in one.parameters if each.name not in searching.fixed(one.body, sent, ())]
        assert free, one.key
        starts = searching.starts(one.body, sent)
        assert searching.from_null or starts, one.key
        assert all(free[0].low <= value <= free[0].high for value in starts), one.key
        assert all(value in first.domain for value in (*starts, *searching.sizes(one.body, sent))), one.key


def test_impossible_truths_are_refused() -> None:
    with pytest.raises(ModelError, match="future"):
        effect("time_shift:x", CRAZYFLIE).inject(value=-0.1)
    with pytest.raises(ModelError, match="rotor must be"):
        effect("rotor_loss", CRAZYFLIE).inject(rotor=5, value=0.1)
    with pytest.raises(UnknownNameError, match="value"):
        effect("added_mass", CRAZYFLIE).inject(mass=0.1)


@pytest.mark.parametrize(
    ("robot", "key", "values", "message"),
    [
        (CRAZYFLIE, "added_mass", {"value": -1.0}, r"more than -0\.027 kg for value, found -1"),
        (CRAZYFLIE, "added_mass", {"value": -0.027}, "more than"),
        (CRAZYFLIE, "payload", {"mass": -0.001}, "at least 0 kg for mass"),
        (CRAZYFLIE, "delay", {"value": -0.05}, "at least 0 and at most 60 s for value, found -0.05"),
        (CRAZYFLIE, "lag:wx_cmd", {"value": -1.0}, "lag:wx_cmd: expected at least 0 s"),
        (CRAZYFLIE, "motor_lag", {"value": -0.1}, "at least 0 s"),
        (CRAZYFLIE, "sensor_lag:x", {"value": -0.1}, "at least 0 s"),
        (CRAZYFLIE, "dead_band:wx_cmd", {"value": -0.1}, "at least 0 rad/s"),
        (CRAZYFLIE, "rate_limit:wx_cmd", {"value": -1.0}, "at least 0 rad/s²"),
        (CRAZYFLIE, "limit:wx_cmd", {"lower": 1.0, "upper": -1.0}, "below the upper one, found 1 and -1"),
        (CRAZYFLIE, "limit:wx_cmd", {"lower": 1.0, "magnitude": 0.5}, "found 1 and 0.5"),
        (CRAZYFLIE, "limit:wx_cmd", {"magnitude": -0.5}, "found 0.5 and -0.5"),
        (CRAZYFLIE, "com_offset", {"rx": 1e9}, "at least -1 and at most 1 m for rx"),
        (CRAZYFLIE, "rotor_loss", {"rotor": 1, "value": 1.5}, "at most 1 for value"),
        (CRAZYFLIE, "wind", {"fx": math.inf}, "wind: expected a finite number for fx, found inf"),
        (CRAZYFLIE, "wind", {"fx": math.nan}, "found nan"),
        (CRAZYFLIE, "wind", {"fx": "strong"}, "found strong"),
        (MUSHR, "wheelbase", {"value": 0.0}, "more than 0 for value, found 0"),
        (MUSHR, "tyre_friction", {"value": -0.5}, "at least 0"),
    ],
)
def test_values_that_nothing_has_are_refused(robot: Robot, key: str, values: dict[str, float], message: str) -> None:
    chosen = effect(key, robot)
    for attempt in (lambda: chosen.inject(**values), lambda: chosen.substitute(nominal(robot), values)):
        with pytest.raises(ModelError, match=message):
            attempt()


@pytest.mark.parametrize("robot", PAPER_ROBOTS.values(), ids=PAPER_ROBOTS)
def test_what_is_likely_is_possible(robot: Robot) -> None:
    for key in one_key_per_kind(robot):
        for parameter in effect(key, robot).parameters:
            for value in (parameter.low, parameter.null, parameter.high):
                assert value in parameter.domain, (key, parameter)


@pytest.mark.parametrize("pattern", ["wind", "gain:*", "gain*", "delay", "lag:w?_cmd", "slope", "*"])
def test_patterns_that_may_match_are_taken(pattern: str) -> None:
    require_patterns([pattern])


@pytest.mark.parametrize(
    ("pattern", "message"), [("wnd", "did you mean 'wind'"), ("gain", r"gain:\*"), ("x:y", "'x:y'")]
)
def test_patterns_that_nothing_matches_are_refused(pattern: str, message: str) -> None:
    with pytest.raises(UnknownNameError, match=message):
        require_patterns([pattern])


@pytest.mark.parametrize(
    ("robot", "key", "near"),
    [
        (MUSHR, "steer_offset", "did you mean 'offset:steer'?"),
        (MUSHR, "steer", "'gain:steer' or 'offset:steer'"),
        (CRAZYFLIE, "drag", "did you mean 'linear_drag' or 'quadratic_drag'?"),
        (CRAZYFLIE, "rate_dampng", "did you mean 'rate_damping'?"),
    ],
)
def test_a_key_that_is_none_names_what_shares_its_words(robot: Robot, key: str, near: str) -> None:
    with pytest.raises(UnknownNameError) as error:
        effect(key, robot)
    assert near in str(error.value)
    assert "known:" not in str(error.value)


def test_effects_of_another_robot_say_so() -> None:
    for robot, key, *_ in CASES:
        assert effect(key, robot).why_not(robot) == ""
    assert effect("slope", CRAZYFLIE).why_not(CRAZYFLIE) == "slope is an effect of a car"


@pytest.mark.parametrize(
    ("equations", "said"),
    [
        (CRAZYFLIE.nominal(), "rate commands above 0.15 rad/s"),
        (quadrotor(0.03, interface="motors"), "dither of the motors"),
        (quadrotor(0.03, interface="thrust_attitude"), "dither of the attitude command"),
        (MUSHR.nominal(), "steps of steering and speed"),
    ],
)
def test_advice_names_the_commands_that_the_model_has(equations: Equations, said: str) -> None:
    assert said in effect("delay", equations).shown_by
    for one in applicable(equations):
        assert "rate command" not in one.shown_by or "wx_cmd" in equations.layouts.action, one.key
        assert "(rates:" not in one.shown_by, one.key


def test_a_mass_reaches_as_far_as_the_thrust_gains_that_it_stands_for() -> None:
    """Gains at their ends were missing, and nothing in the catalogue explained it."""
    (gain,), (mass,) = effect("gain:thrust", CRAZYFLIE).parameters, effect("added_mass", CRAZYFLIE).parameters
    needed = [CRAZYFLIE.mass * (1.0 / value - 1.0) for value in (gain.high, gain.low)]
    assert mass.low <= needed[0] + 1e-9
    assert mass.high >= needed[1] - 1e-9


@pytest.mark.parametrize("mass", [0.027, 0.9])
def test_ground_effect_reaches_as_high_as_a_robot_is_large(mass: float) -> None:
    """At h the thrust is 1/e of the gain larger; h goes by the robot's length, the cube root of its mass."""
    lifted = add(quadrotor(mass), "ground_effect", {"value": 0.5})
    height = 0.07 * (mass / 0.027) ** (1 / 3)
    state = dict.fromkeys(lifted.layouts.state, 0.0) | {"qw": 1.0, "z": height}
    after = lifted.predict([*state.values()], [mass * 9.81, 0.0, 0.0, 0.0])
    gained = float(after[lifted.layouts.state.index("vz")]) / lifted.dt
    assert gained == pytest.approx(9.81 * 0.5 / np.e, rel=1e-6)


def test_below_the_height_zero_the_ground_is_no_nearer() -> None:
    """Heights may count from a take-off: six metres down thrust was 1e11 times as large."""
    lifted = add(CRAZYFLIE.nominal(), "ground_effect", {"value": 0.5})
    state = dict.fromkeys(lifted.layouts.state, 0.0) | {"qw": 1.0}
    climbs = [lifted.predict([*(state | {"z": z}).values()], [0.26, 0.0, 0.0, 0.0]) for z in (0.0, -0.1, -6.0)]
    vertical = [float(after[lifted.layouts.state.index("vz")]) for after in climbs]
    assert vertical == pytest.approx([vertical[0]] * 3)
