"""Substitution: null values, order, equations of every interface, with and without wrench inputs."""

from __future__ import annotations

import functools
import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy
import torch
from effects_cases import nominal, one_key_per_kind
from paper_robots import PAPER_ROBOTS
from scipy.integrate import trapezoid
from torch import Tensor

from sym2real.effects import Effect, applicable, compose, effect
from sym2real.effects.filters import filter_commands, with_hidden_start
from sym2real.errors import ModelError, UnknownNameError
from sym2real.layout import Layout, Layouts
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS, Robot, quadrotor
from sym2real.robots.motors import Motors
from sym2real.symbolic import Equations, build_module, compile_model, symbol

LEARNED = {
    "x": "x + 0.02*vx",
    "y": "y + 0.02*vy",
    "z": "z + 0.02*vz",
    "qw": "qw - 0.01*(qx*wx + qy*wy + qz*wz)",
    "qx": "qx + 0.01*(qw*wx + qy*wz - qz*wy)",
    "qy": "qy + 0.01*(qw*wy - qx*wz + qz*wx)",
    "qz": "qz + 0.01*(qw*wz + qx*wy - qy*wx)",
    "vx": "vx + 1.48*thrust*(qx*qz + qw*qy)",
    "vy": "vy + 1.48*thrust*(qy*qz - qw*qx)",
    "vz": "vz - 0.196 + 0.74*thrust*(1 - 2*qx*qx - 2*qy*qy)",
    "wx": "0.37*wx + 0.63*wx_cmd",
    "wy": "0.37*wy + 0.63*wy_cmd",
    "wz": "0.67*wz + 0.33*wz_cmd",
}
WRENCH = {"vx": "0.74*fx", "vy": "0.74*fy", "vz": "0.74*fz", "wx": "760*tx", "wy": "757*ty", "wz": "562*tz"}


COMPOSITE = ("payload", "quadratic_drag", "periodic_force", "translational_lift")  # made of what others show


def learned(wrench: bool) -> Equations:
    """Equations as regression writes them: flat polynomials."""
    terms = {name: f"{text} + {WRENCH[name]}" if wrench and name in WRENCH else text for name, text in LEARNED.items()}
    equations = Equations.parse(CRAZYFLIE.layouts, terms, CRAZYFLIE.dt, robot="crazyflie")
    return replace(equations, numbers=CRAZYFLIE.numbers)


INTERFACES = {
    "motors": quadrotor(0.03, interface="motors"),
    "motor speeds": quadrotor(0.03, interface="motors", motors=Motors(2.9e-8, unit="rad/s")),
    "attitude commands": quadrotor(0.03, interface="thrust_attitude"),
    "measured attitude": quadrotor(1.0, attitude="measured"),
    "motors, measured attitude": quadrotor(0.03, interface="motors", attitude="measured"),
    "learned": learned(wrench=True),
    "learned without wrench": learned(wrench=False),
}


def free_symbols(found: Effect) -> dict[str, Any]:
    """A symbol for every parameter, but for a rotor's number."""
    return {name: 1.0 if name == "rotor" else value for name, value in found.symbols().items()}


def rows(equations: Equations) -> tuple[Tensor, Tensor, Tensor]:
    rng, layouts = np.random.default_rng(5), equations.layouts
    state = torch.as_tensor(rng.standard_normal((20, len(layouts.state))))
    action = torch.as_tensor(rng.uniform(0.1, 0.4, (20, len(layouts.action))))
    inputs = torch.as_tensor(rng.standard_normal((20, len(layouts.inputs))) * 1e-3)
    return layouts.state.normalise(state), action, inputs


def stepped(equations: Equations, state: Tensor, action: Tensor, inputs: Tensor) -> Tensor:
    first = with_hidden_start(equations, state, action, padded(equations, inputs))
    result: Tensor = build_module(equations).double()(first, action, padded(equations, inputs))
    return result[..., : state.shape[-1]]


def padded(equations: Equations, inputs: Tensor) -> Tensor:
    """Inputs with a time of 1 s for equations that effects have given one."""
    return torch.cat([inputs, torch.ones(len(inputs), len(equations.layouts.inputs) - inputs.shape[-1])], dim=-1)


@functools.cache
def plain_step(equations: Equations) -> Tensor:
    return stepped(equations, *rows(equations))


def assert_null(equations: Equations, found: Effect) -> None:
    given = rows(equations)
    changed = found.substitute(equations, free_symbols(found))
    np.testing.assert_allclose(stepped(changed, *given), plain_step(equations), atol=1e-12, err_msg=found.key)
    columns = dict(zip(equations.layouts.state, given[0].T, strict=True))
    for name, expression in changed.output.items():
        value = sympy.lambdify([*map(symbol, columns), *map(symbol, changed.parameters)], expression)
        reported = value(*(column.numpy() for column in columns.values()), *changed.parameters.values())
        np.testing.assert_allclose(reported, columns[name], atol=1e-12, err_msg=found.key)


@pytest.mark.parametrize("name", PAPER_ROBOTS)
def test_null_parameters_are_the_identity(name: str) -> None:
    for key in one_key_per_kind(ROBOTS[name]):
        assert_null(nominal(ROBOTS[name]), effect(key, ROBOTS[name]))


@pytest.mark.parametrize("name", INTERFACES)
def test_null_parameters_are_the_identity_on_other_equations(name: str) -> None:
    equations = INTERFACES[name]
    for found in applicable(equations):
        static = found.stage in ("mass", "loop", "wrench", "thrust") and found.kind not in COMPOSITE
        if static or found.key in ("gain:thrust", "mounting_tilt"):
            assert_null(equations, found)


def test_every_named_effect_of_motors_changes_what_it_should() -> None:
    equations = INTERFACES["motors"]
    given = rows(equations)
    for found in applicable(equations):
        if found.stage in ("mass", "loop", "wrench", "thrust"):
            values = {p.name: 1.0 if p.name == "rotor" else p.null + 0.3 * p.scale for p in found.parameters}
            assert not torch.equal(stepped(found.substitute(equations, values), *given), stepped(equations, *given))


def test_the_order_given_does_not_matter_and_physics_decides_it() -> None:
    chosen = [
        (effect("gain:thrust", CRAZYFLIE), {"value": 0.8}),
        (effect("thrust_curve", CRAZYFLIE), {"value": 1.4}),
        (effect("com_offset", CRAZYFLIE), {"rx": 0.002}),
        (effect("added_mass", CRAZYFLIE), {"value": 0.005}),
        (effect("wind", CRAZYFLIE), {"fx": 0.02}),
    ]
    equations = learned(wrench=True)
    first = compose(equations, chosen)
    assert first.text() == compose(equations, chosen[::-1]).text()
    state, action, inputs = rows(first)
    hover = CRAZYFLIE.mass * 9.81
    given = hover * (0.8 * action[:, 0] / hover) ** 1.4  # the curve bends what the gain leaves
    share = 0.027 / 0.032
    bare = action.clone()
    bare[:, 0] = given * share  # mass divides thrust, and the wind with it
    pushed = inputs.clone()
    pushed[:, 0] = (inputs[:, 0] + 0.02) * share
    pushed[:, 1:3] *= share
    pushed[:, 4] += 0.002 * given  # a torque knows no mass
    torch.testing.assert_close(stepped(first, state, action, inputs), stepped(equations, state, bare, pushed))


def test_a_command_is_cut_off_then_late_then_mapped() -> None:
    """The heading turns by the wheels' mean angle over a period, and a gyro shows the one at its end."""
    keys: dict[str, dict[str, float]] = {
        "gain:steer": {"value": 2.0},
        "offset:steer": {"value": 0.1},
        "limit:steer": {"upper": 0.3},
        "delay:steer": {"value": MUSHR.dt},
        "lag:steer": {"value": 0.1},
    }
    commands = torch.tensor([0.0, 0.9, 0.9, 0.0, 0.0], dtype=torch.float64)
    late = torch.tensor([0.0, 0.0, 0.3, 0.3, 0.0], dtype=torch.float64)
    means, ends, lagged = [], [0.0], 0.0
    for command in late:  # the lag's mean over a period by quadrature
        times = np.linspace(0, MUSHR.dt, 2001)
        follows = float(command) + (lagged - float(command)) * np.exp(-times / 0.1)
        means.append(2.0 * trapezoid(follows, times) / MUSHR.dt + 0.1)
        ends.append(lagged := follows[-1])
    for order in itertools.islice(itertools.permutations(keys), 0, None, 17):
        equations = compose(nominal(MUSHR), [(effect(key, MUSHR), keys[key]) for key in order])
        state, action, inputs = (values[:5] for values in rows(nominal(MUSHR)))
        sent, by_mean, by_end = action.clone(), action.clone(), action.clone()
        sent[:, 0], by_mean[:, 0] = commands, torch.tensor(means, dtype=torch.float64)
        by_end[:, 0] = 2.0 * torch.tensor(ends[1:], dtype=torch.float64) + 0.1
        whole = torch.cat([state, torch.tensor(ends[:-1], dtype=torch.float64)[:, None]], dim=1)
        expected = stepped(nominal(MUSHR), state, by_mean, inputs)
        expected[:, 6] = stepped(nominal(MUSHR), state, by_end, inputs)[:, 6]
        after = stepped(equations, whole, filter_commands(equations, sent), inputs)[:, :7]
        torch.testing.assert_close(after, expected, rtol=1e-6, atol=1e-8)


def test_a_linkage_bends_the_angle_that_a_servo_reaches() -> None:
    """Half the travel and a trim, then the curve: the model turns as the plain one told that angle."""
    known = {"steering_curve": {"value": 0.8}, "gain:steer": {"value": 0.5}, "offset:steer": {"value": 0.1}}
    bent = compose(nominal(MUSHR), [(effect(key, MUSHR), values) for key, values in known.items()])
    state, action, inputs = (values[:5] for values in rows(nominal(MUSHR)))
    meant, reached = action.clone(), 0.5 * action[:, 0] + 0.1
    meant[:, 0] = reached * (1.0 - 0.8 * reached.square())
    torch.testing.assert_close(stepped(bent, state, action, inputs), stepped(nominal(MUSHR), state, meant, inputs))


def test_motor_lag_delays_the_thrust_that_turns_an_offset_centre_of_mass() -> None:
    lag, offset = effect("motor_lag", CRAZYFLIE), effect("com_offset", CRAZYFLIE)
    equations = compose(nominal(CRAZYFLIE), [(offset, {"rx": 0.002}), (lag, {"value": 0.05})])
    assert [field.hidden for field in equations.layouts.state.fields[-4:]] == [True] * 4
    assert set(equations.start) == set(equations.layouts.state.columns[-4:])
    assert any("rotor_thrust" in str(value) for value in equations.quantities.values())
    state = torch.as_tensor(CRAZYFLIE.start)
    rest, more = torch.as_tensor(CRAZYFLIE.rest), torch.as_tensor(CRAZYFLIE.rest) + torch.tensor([0.1, 0, 0, 0])
    first = with_hidden_start(equations, state, rest)
    model = build_module(equations).double()
    assert first[16] == pytest.approx(float(CRAZYFLIE.rest[0]))  # thrust in rest at its first command
    kept = np.exp(-0.02 / 0.05)
    assert float(model(first, more)[16]) == pytest.approx(CRAZYFLIE.rest[0] + 0.1 * (1 - kept))


def test_equations_without_wrench_take_the_approximate_form_and_say_so() -> None:
    with_wrench, without = learned(wrench=True), learned(wrench=False)
    for key, values in (("wind", {"fx": 0.02}), ("torque_bias", {"ty": 2e-5}), ("com_offset", {"rx": 0.001})):
        found = effect(key, CRAZYFLIE)
        approximate, exact = found.substitute(without, values), found.substitute(with_wrench, values)
        assert "approximate" in approximate.notes[0]
        assert not exact.notes
        given = rows(without)
        change = stepped(approximate, *given) - stepped(without, *given)
        truth = stepped(exact, *given) - stepped(with_wrench, *given)
        # The same channels in the same sense; of the size the rate loop is known to have.
        assert float((change[:, 7:] * truth[:, 7:]).sum() / (truth[:, 7:] ** 2).sum()) == pytest.approx(1.0, abs=0.02)
    assert compose(without, [(effect("gain:thrust", CRAZYFLIE), {"value": 0.9})]).notes == ()


def test_the_new_term_stands_in_the_latex() -> None:
    found = effect("linear_drag", CRAZYFLIE)
    names = {"cx": symbol("c"), "cy": symbol("c"), "cz": symbol("c")}
    assert "- c vx" in found.substitute(learned(wrench=True), names).latex()["vx"].replace("v_{x}", "vx")
    wind = effect("wind", MUSHR).substitute(nominal(MUSHR), {"fx": symbol("gust")})
    assert any("gust" in str(value) for value in (*wind.next.values(), *wind.quantities.values()))


def test_equations_with_effects_compile_and_keep_their_parameters() -> None:
    found = effect("motor_lag", CRAZYFLIE)
    equations = found.substitute(nominal(CRAZYFLIE), found.symbols())
    model = compile_model(equations, dtype=torch.float64)
    state = with_hidden_start(equations, torch.as_tensor(CRAZYFLIE.start), torch.as_tensor(CRAZYFLIE.rest))
    actions = torch.as_tensor(CRAZYFLIE.rest).repeat(10, 1)
    actions[3:, 1] = 1.0
    times = torch.tensor([[0.0], [0.002], [0.005], [0.03]], dtype=torch.float64)  # 1/(4K) = 0.005 s is critical
    many = model.rollout(state, actions, None, times)
    assert bool(many.isfinite().all())
    for time, one in zip(times[1:], many[1:], strict=True):
        fixed = compile_model(found.substitute(nominal(CRAZYFLIE), {"value": float(time)}), dtype=torch.float64)
        torch.testing.assert_close(fixed.rollout(state, actions), one)


@pytest.mark.parametrize("key", ["motor_lag", "delay", "mounting_tilt", "battery_sag", "limit:thrust"])
def test_equations_with_effects_survive_their_file(key: str) -> None:
    found = effect(key, CRAZYFLIE)
    changed = found.substitute(nominal(CRAZYFLIE), found.symbols())
    read = Equations.from_json(changed.to_json())
    assert read.text() == changed.text()
    assert read.numbers == CRAZYFLIE.numbers
    assert read.layouts == changed.layouts


@pytest.mark.parametrize("robot", [MUSHR, CRAZYFLIE], ids=["car", "quadrotor"])
def test_hidden_states_of_two_effects_begin_by_what_is_known(robot: Robot) -> None:
    """Tyres that turn a car late, by a distance and by its inertia, began with each other's memory."""
    equations = nominal(robot)
    hidden = [found for found in applicable(equations) if found.of.hidden or found.key in ("lag:steer", "delay:steer")]
    assert len(hidden) >= 2
    for both in itertools.combinations(hidden, 2):
        values = [{parameter.name: parameter.scale for parameter in found.parameters} for found in both]
        changed = compose(equations, list(zip(both, values, strict=True)))
        state = with_hidden_start(changed, torch.as_tensor(robot.start), torch.as_tensor(robot.rest))
        assert state.shape[-1] == len(changed.layouts.state) > len(robot.layouts.state), both
        assert bool(state.isfinite().all()), both


def test_what_does_not_apply_says_why() -> None:
    bare = Layouts(Layout.of(("vx", "vy")), Layout.of(("steer",)))
    equations = Equations.parse(bare, {"vx": "vx", "vy": "vy + steer"}, 0.05)
    wind = effect("wind", equations)
    assert not wind.applies(equations)
    assert "mass" in wind.why_not(equations)
    assert "car" in effect("slope", CRAZYFLIE).why_not(nominal(CRAZYFLIE))
    with pytest.raises(ModelError, match="needs the robot's mass"):
        wind.substitute(equations, {"fx": 1.0})
    with pytest.raises(UnknownNameError, match="fx"):
        effect("wind", CRAZYFLIE).substitute(nominal(CRAZYFLIE), {"f_x": 1.0})


@pytest.mark.parametrize(
    ("interface", "first"), [("rates", "motor_lag"), ("rates", "rotor_reaction"), ("motors", "motor_lag")]
)
def test_equations_with_an_effect_take_every_effect_that_still_applies(interface: str, first: str) -> None:
    equations = nominal(CRAZYFLIE) if interface == "rates" else INTERFACES[interface]
    once = effect(first, equations)
    informed = once.substitute(equations, {"value": once.parameters[0].scale})
    left = applicable(informed)
    assert first not in {found.key for found in left}
    assert {found.key for found in applicable(equations)} - {found.key for found in left} == {first}
    for found in left:
        found.substitute(informed, free_symbols(found))
    with pytest.raises(ModelError, match=f"{first} is in these equations already"):
        once.substitute(informed, {"value": once.parameters[0].scale})
