"""What equations remember of effects that were put into them, and that a simulated robot can be given the same."""

from __future__ import annotations

import json

import numpy as np
import pytest
from effects_cases import Run, change, nominal, plain, predicted, run, simulated

from sym2real.diagnosis import add, add_term
from sym2real.effects import as_simulated, compose, effect, injected, noted
from sym2real.effects.voltage import with_voltage
from sym2real.errors import ModelError
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.symbolic import Equations

Steps = tuple[tuple[str, dict[str, float]], ...]


def in_steps(robot: Robot, steps: Steps) -> Equations:
    equations = nominal(robot)
    for key, values in steps:
        equations = add(equations, key, values)
    return equations


def test_equations_remember_effects_whose_values_are_numbers() -> None:
    base = CRAZYFLIE.nominal()
    informed = add(base, [("gain:thrust", {"value": 0.9}), ("added_mass", {"value": 0.004}), ("wind", {"fx": 0.0})])
    assert [(key, dict(values)) for key, values in informed.effects] == [
        ("added_mass", {"value": 0.004}),
        ("gain:thrust", {"value": 0.9}),
    ]
    assert noted(informed) == ("added_mass value=0.004 kg", "gain:thrust value=0.9")
    again = Equations.from_json(informed.to_json())
    assert (again.effects, noted(base)) == (informed.effects, ())
    wind = effect("wind", base)
    assert compose(base, [(wind, wind.symbols())]).effects == ()  # a hypothesis is none yet


def test_a_file_without_effects_opens() -> None:
    content = json.loads(CRAZYFLIE.nominal().to_json())
    del content["effects"]
    assert Equations.from_json(json.dumps(content)).effects == ()


# One effect twice, and two whose order matters; how far the ratio of sizes may be from 1, as in effects_cases.
TWICE = [
    (CRAZYFLIE, (("added_mass", {"value": 0.005}), ("added_mass", {"value": 0.003})), 0.01),
    (CRAZYFLIE, (("payload", {"mass": 0.003, "rx": 0.02}), ("added_mass", {"value": 0.003})), 0.03),
    (CRAZYFLIE, (("delay", {"value": 0.03}), ("delay", {"value": 0.03})), 0.05),
    (CRAZYFLIE, (("offset:wy_cmd", {"value": 0.3}), ("gain:wy_cmd", {"value": 0.5})), 0.01),
    (CRAZYFLIE, (("gain:wy_cmd", {"value": 0.5}), ("limit:wy_cmd", {"upper": 0.5})), 0.01),
    (CRAZYFLIE, (("sensor_bias:wz", {"value": 0.3}), ("sensor_scale:wz", {"value": 0.5})), 0.01),
    (CRAZYFLIE, (("sensor_scale:wz", {"value": 0.5}), ("sensor_bias:wz", {"value": 0.3})), 0.01),
    (MUSHR, (("slope", {"gx": 0.3}), ("slope", {"gx": 0.2, "gy": 0.5})), 0.05),
    (MUSHR, (("offset:steer", {"value": 0.05}), ("offset:steer", {"value": -0.02})), 0.15),
    (MUSHR, (("tyre_friction", {"value": 0.3}), ("tyre_friction", {"value": 0.6})), 0.25),
]


@pytest.mark.parametrize(
    ("robot", "steps", "off"), TWICE, ids=lambda one: "-".join(k for k, _ in one) if isinstance(one, tuple) else None
)
def test_a_simulated_robot_with_the_effects_of_a_model_moves_as_the_model(
    robot: Robot, steps: Steps, off: float
) -> None:
    equations, given, (true_plain, plain_equations) = in_steps(robot, steps), run(robot), plain(robot)
    if steps[0][0] == "tyre_friction":  # from motions that slippery tyres allow
        held = Run(robot, given.starts, np.repeat(given.actions[:, :1], 12, axis=1))
        given = Run(robot, simulated(held, list(injected(equations, robot)))[:, -1], given.actions)
        true_plain, plain_equations = simulated(given, []), predicted(nominal(robot), given)
    truth = change(robot, simulated(given, list(injected(equations, robot))), true_plain)
    told = change(robot, predicted(equations, given), plain_equations)
    sizes = np.linalg.norm(told), np.linalg.norm(truth)
    assert float((told * truth).sum() / (sizes[0] * sizes[1])) > 0.97
    assert sizes[0] / sizes[1] == pytest.approx(1.0, abs=off)


def test_what_a_simulated_robot_cannot_have_is_refused_with_the_reason() -> None:
    both = in_steps(MUSHR, (("understeer", {"value": 0.01}), ("tyre_slip", {"value": 0.01})))
    assert {key for key, _ in as_simulated(both)} == {"understeer", "tyre_slip"}
    with pytest.raises(ModelError, match=r"no counterpart there \(fz\)"):
        as_simulated(add_term(CRAZYFLIE.nominal(), "fz", "0.01*vz"))
    with pytest.raises(ModelError, match="no voltage"):
        as_simulated(add(with_voltage(CRAZYFLIE.nominal(), 4.1), "battery_sag", {"value": 0.2}))
