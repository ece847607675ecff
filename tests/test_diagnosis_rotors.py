"""A weak rotor of a robot that is commanded motor by motor."""

from __future__ import annotations

import pytest
import torch
from motor_flights import equations, motor_flights

from sym2real.diagnosis import add, diagnose
from sym2real.diagnosis.predict.library import Library
from sym2real.effects import applicable, effect
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic import compile_model

# What a weak rotor was taken for.
RIVALS = ("rotor_loss", "com_offset", "torque_bias", "added_mass", "wind", "linear_drag")
ROTORS = (1, 2, 3, 4)


@pytest.mark.parametrize("rotor", ROTORS)
def test_a_search_takes_a_rotor_away_as_adding_the_effect_does(rotor: int) -> None:
    base = equations()
    library = Library.of(base, [effect(key, base) for key in ("added_mass", "rotor_loss", "thrust_curve")])
    values = library.null
    values[list(library.indices("rotor_loss"))] = 0.0
    (slot,) = library.indices(f"rotor_loss {rotor}")
    values[slot] = 0.2
    state, action = torch.as_tensor(CRAZYFLIE.start), torch.tensor([0.4, 0.5, 0.45, 0.55], dtype=torch.float64)
    direct = compile_model(add(base, "rotor_loss", {"rotor": rotor, "value": 0.2}), dtype=torch.float64)
    searched = library.model(library.equations.dt)(state, action, None, values)
    torch.testing.assert_close(searched, direct(state, action), rtol=0.0, atol=1e-12)
    assert float((searched - library.model(library.equations.dt)(state, action, None, library.null)).abs().max()) > 1e-3


@pytest.mark.slow
def test_a_weak_rotor_is_named_and_not_a_mass_off_centre() -> None:
    base = equations()
    others = [one.key for one in applicable(base) if one.key not in RIVALS]
    found = diagnose(base, motor_flights(strength=(1.0, 0.9, 1.0, 1.0)), exclude=others)
    assert [one.effect for one in found.findings] == ["rotor_loss"]
    assert found.findings[0].values == pytest.approx({"rotor": 2.0, "value": 0.1}, rel=0.05)
