"""A wrong parameter of equations that a user has written: found, with its size, also beside the catalogue's effects."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from handwritten import boat, crane, sailed, swung
from noisy_flights import LEFT_OUT, flights

from sym2real.dataset import Dataset
from sym2real.diagnosis import Diagnosis, diagnose, try_effect
from sym2real.effects import noted
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic import Equations, symbol

MASS = CRAZYFLIE.mass


def quadrotor(mass: float = MASS) -> Equations:
    """A Crazyflie as somebody writes it: rotors that give so many times the thrust that they are told, over a mass."""
    given, inertia = CRAZYFLIE.nominal(), MASS / symbol("mass")
    scaled = {name: inertia * symbol(name) for name in ("fx", "fy", "fz")}
    scaled["thrust"] = inertia * symbol("rotors") * symbol("thrust")
    named = given.substitute(scaled, parameters={"mass": mass, "rotors": 1.0})
    return replace(named, robot="", numbers={})


def ratios(found: Diagnosis) -> dict[str, float]:
    """Effects and the first value of each."""
    return {finding.effect: next(iter(finding.values.values())) for finding in found.findings}


@pytest.mark.parametrize(
    ("model", "logs"),
    [(boat(), lambda: sailed(11)), (crane(), lambda: swung(11)), (quadrotor(), flights)],
    ids=["boat", "crane", "quadrotor"],
)
def test_of_parameters_that_are_right_none_is_named(model: Equations, logs: Callable[[], Dataset]) -> None:
    found = diagnose(model, logs(), exclude=LEFT_OUT)
    assert found.verdict == "NOTHING_MISSING"
    assert not found.findings


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "logs", "name", "factor"),
    [
        (boat(), lambda: sailed(12, mass=30.0), "mass", 1.2),
        (crane(), lambda: swung(12, length=0.575), "length", 1.15),
        (crane(), lambda: swung(13, pole_mass=0.3), "pole_mass", 0.75),
    ],
    ids=["boat", "crane", "pole"],
)
def test_a_parameter_that_is_wrong_is_named_with_its_size(
    model: Equations, logs: Callable[[], Dataset], name: str, factor: float
) -> None:
    data = logs()
    found = diagnose(model, data)
    (finding,) = found.findings
    assert (found.verdict, finding.effect, finding.group) == ("EFFECT", f"parameter:{name}", (f"parameter:{name}",))
    assert finding.parameters["factor"].low < factor < finding.parameters["factor"].high
    assert finding.values["factor"] == pytest.approx(factor, rel=0.03)
    better, value = found.apply(model), model.parameters[name]
    assert finding.fix.startswith(f"{name} = {better.parameters[name]:.4g} (95 % ")
    assert f"in place of {value:g}" in finding.fix
    assert noted(better) == (f"parameter:{name} factor={finding.values['factor']:.4g}",)
    again = diagnose(Equations.from_json(better.to_json()), data)
    assert again.verdict == "NOTHING_MISSING"


@pytest.mark.slow
def test_a_parameter_is_found_beside_effects_of_the_catalogue() -> None:
    drifting = diagnose(boat(), sailed(14, drag=4.5, wind=(2.0, -1.0)))
    assert ratios(drifting) == pytest.approx({"wind": 2.0, "parameter:drag": 0.75}, rel=0.05)
    late = diagnose(crane(), swung(14, cart_mass=1.5, late=2), exclude=["delay:*"])  # there is one command
    assert ratios(late) == pytest.approx({"parameter:cart_mass": 1.25, "delay": 0.04}, rel=0.05)


def test_what_is_likely_of_a_command_goes_by_how_far_it_goes() -> None:
    """Nobody said in which unit: an offset of 2 N beside 24 N was beyond what is likely of a command from -1 to 1."""
    logs = Dataset(replace(log, action=log.action - 2.0) for log in swung(15))
    assert ratios(diagnose(crane(), logs, exclude=["parameter:*"])) == pytest.approx({"offset:drive": 2.0}, rel=0.03)


@pytest.mark.slow
def test_parameters_that_no_log_parts_are_one_group() -> None:
    """A mass that is too small, rotors that are too strong, and the catalogue's gain of the thrust."""
    left_out = (*(key for key in LEFT_OUT if key != "gain:*"), "gain:w*")
    found = diagnose(quadrotor(MASS / 1.2), flights(), exclude=left_out)
    (finding,) = found.findings
    assert {"parameter:mass", "parameter:rotors", "gain:thrust"} <= set(finding.group)
    assert finding.group[1].startswith("parameter:") or finding.effect.startswith("parameter:")
    thrust = found.apply(quadrotor(MASS / 1.2)).predict(CRAZYFLIE.start, [0.3, 0.0, 0.0, 0.0])
    assert thrust == pytest.approx(quadrotor().predict(CRAZYFLIE.start, [0.3, 0.0, 0.0, 0.0]), abs=1e-3)


@pytest.mark.slow
def test_one_parameter_is_held_against_logs_as_a_hypothesis() -> None:
    data = sailed(12, mass=30.0)
    tried = try_effect(boat(), "parameter:mass", data)
    assert tried.supported
    assert tried.apply(boat()).parameters["mass"] == pytest.approx(30.0, rel=0.03)
    assert not try_effect(boat(), "parameter:arm", data).supported
