"""Named parameters of equations of one's own as effects: what is in question, what is known, and how it is changed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from handwritten import BOAT, boat, crane, sailed

from sym2real import add
from sym2real.diagnosis.predict.competitors import competing
from sym2real.effects import applicable, effect, injected, noted
from sym2real.errors import ModelError, UnknownNameError
from sym2real.robots import CRAZYFLIE, ROBOTS
from sym2real.symbolic import Equations, lift_constants, load_model, save_model


def of_parameters(equations: Equations) -> set[str]:
    keys, _ = competing(equations, sailed(0, logs=1, rows=60))
    return {key for key in keys if key.startswith("parameter")}


def test_a_factor_is_another_value_in_the_equations() -> None:
    model = boat()
    heavier = add(model, "parameter:mass", {"factor": 1.2})
    other = replace(model, parameters={**model.parameters, "mass": 1.2 * BOAT["mass"]})
    state, command = np.array([0.0, 0.0, 0.6, 0.8, 0.3, -0.1, 0.2]), np.array([4.0, 3.0])
    np.testing.assert_array_equal(heavier.predict(state, command), other.predict(state, command))
    assert np.abs(heavier.predict(state, command) - model.predict(state, command)).max() > 1e-3
    assert heavier.parameters["mass"] == pytest.approx(30.0)
    assert add(heavier, "parameter:mass", {"factor": 1 / 1.2}).parameters["mass"] == pytest.approx(25.0)
    free = effect("parameter:mass", model)
    searched = free.substitute(model, free.symbols())
    np.testing.assert_array_equal(searched.predict(state, command), model.predict(state, command))


def test_a_model_with_another_parameter_opens_again(tmp_path: Path) -> None:
    heavier = add(boat(), "parameter:mass", {"factor": 1.2})
    save_model(heavier, tmp_path / "heavier")
    opened = load_model(tmp_path / "heavier")
    assert isinstance(opened, Equations)
    assert opened.to_json() == heavier.to_json()
    assert noted(opened) == ("parameter:mass factor=1.2",)
    assert noted(opened.at(mass=30.0)) == noted(opened)  # once it is a number it was another one all the same


def test_what_has_a_name_is_in_question_and_what_is_known_is_not() -> None:
    """A time step and gravity are known; of zero there is no multiple, and of what no equation has no trace."""
    assert of_parameters(boat()) == {f"parameter:{name}" for name in BOAT}
    model = boat()
    more = replace(model, parameters={**model.parameters, "nothing": 0.0, "unused": 3.0})
    assert of_parameters(more) == of_parameters(model)
    reasons = {left.effect: left.reason for left in competing(more, sailed(0, logs=1, rows=60))[1]}
    assert reasons["parameter:dt"] == "is the time step, which is known"
    assert reasons["parameter:nothing"] == "is zero, and so is every multiple of it"
    assert reasons["parameter:unused"] == "no equation has unused"
    assert "gravity" in effect("parameter:g", crane()).searching.why_not(effect("parameter:g", crane()).body)


def test_what_a_user_knows_is_written_as_a_number() -> None:
    assert of_parameters(boat().at(mass=25.0)) == {f"parameter:{name}" for name in BOAT} - {"parameter:mass"}


def test_equations_without_named_parameters_have_no_such_effect() -> None:
    for robot in ROBOTS.values():
        assert not any(found.given is not None for found in applicable(robot.nominal()))
    with pytest.raises(UnknownNameError, match="parameter"):
        effect("parameter:mass", CRAZYFLIE)
    with pytest.raises(ModelError, match="model with named parameters"):
        add(CRAZYFLIE.nominal(), "parameter", {"factor": 1.2})
    with pytest.raises(UnknownNameError, match="parameter:mass"):
        add(boat(), "parameter:mas", {"factor": 1.2})
    with pytest.raises(ModelError, match="no equation has unused"):
        add(replace(boat(), parameters={**boat().parameters, "unused": 1.0}), "parameter:unused", {"factor": 1.2})


def test_no_simulator_has_the_parameters_of_equations() -> None:
    heavier = add(boat(), "parameter:mass", {"factor": 1.2})
    with pytest.raises(ModelError, match="no counterpart there \\(mass\\)"):
        injected(heavier, CRAZYFLIE)
    with pytest.raises(ModelError, match="no simulator"):
        effect("parameter:mass", boat()).inject(factor=1.2)


def test_constants_that_calibration_lifts_do_not_compete() -> None:
    """They are numbers, which are known, whatever they are called while a fit moves them."""
    from sym2real.diagnosis.predict.candidate import library_for
    from sym2real.diagnosis.predict.library import library_of

    data = sailed(0, logs=1, rows=60)
    library = library_for(boat(), data)
    lifted = library_of(lift_constants(library.base), tuple(dict.fromkeys(map(library.key, library.effects))))
    assert list(lifted.effects) == list(library.effects)


def test_forces_push_the_mass_that_is_there() -> None:
    """A force in N moves a boat of twice the mass half as far, whichever of both is said first."""
    still, nothing = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), np.zeros(2)
    wind, twice = ("wind", {"fx": 5.0}), ("parameter:mass", {"factor": 2.0})
    pushed = add(boat(), [wind]).predict(still, nothing)[4]
    assert pushed == pytest.approx(boat().dt * 5.0 / BOAT["mass"])
    for model in (add(boat(), [wind, twice]), add(boat(), [twice, wind]), add(add(boat(), [wind]), [twice])):
        assert model.predict(still, nothing)[4] == pytest.approx(pushed / 2)
