"""A model whose mass nobody gave: every verb that prints forces or masses of it says per what they are."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch

from sym2real.cli import main
from sym2real.data import example_flight
from sym2real.diagnosis.pipeline import prepare
from sym2real.diagnosis.question import Question
from sym2real.effects import applicable, effect
from sym2real.logs import read_log
from sym2real.robots import Motors, quadrotor
from sym2real.stages import Stages
from sym2real.symbolic import compile_model, load_model
from sym2real.symbolic.mass_normalised import PER_KILOGRAM

SPEC = "crazyflie_battery_drag"
NOMINAL = ["nominal", "quadrotor", "--interface", "motors", "--attitude", "measured", "--spec", SPEC]


@pytest.mark.slow
@pytest.mark.parametrize(("mass", "said"), [([], 1), (["--mass", "0.027"], 0)], ids=["no mass", "a mass"])
def test_forces_per_kilogram_are_said_to_be(
    mass: list[str], said: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flight, model = str(example_flight()), str(tmp_path / "model")
    commands = [
        [*NOMINAL, "--fit-thrust", flight, *mass, "--out", model],
        ["plan", model, flight, "--spec", SPEC],
        ["add", model, "wind", "fx=0.02", "--out", str(tmp_path / "windy")],
    ]
    for command in commands:
        main(command)
        assert " ".join(capsys.readouterr().out.split()).count(PER_KILOGRAM) == said, command[0]
    equations = load_model(tmp_path / "model")
    units = [effect(key, equations).parameters[0].unit for key in ("linear_drag", "wind", "added_mass")]
    assert units == (["1/s", "m/s²", "1"] if said else ["N s/m", "N", "kg"])
    log = read_log(flight, spec=SPEC, layouts=equations.layouts, dt=equations.dt)
    assert prepare(Question(equations, log), Stages(lambda _: None)).notes.count(PER_KILOGRAM) == said


def test_every_unit_of_an_effect_has_one_per_kilogram() -> None:
    """A model without a mass has no newton and no kilogram in any unit of its effects."""
    for interface in ("thrust_rates", "motors"):
        equations = quadrotor(None, interface=interface)
        units = {parameter.unit for one in applicable(equations) for parameter in one.parameters}
        assert not [unit for unit in units if "N" in unit or "kg" in unit], units


def test_a_mass_that_nobody_gave_makes_no_robot_large() -> None:
    """A nano quadrotor at 0.7 m: a robot of 1 kg would feel the ground there, by a twentieth of its thrust."""
    base = quadrotor(interface="motors", attitude="measured", motors=Motors(thrust=4.905))
    near = effect("ground_effect", base).substitute(base, {"value": 1.0})
    state, action = torch.tensor([0.0, 0.0, 0.7, 0.0, 0.0, 0.0]), torch.full((4,), 0.5)
    inputs = torch.tensor([float(name == "qw") for name in base.layouts.inputs])
    lifted, plain = (compile_model(model)(state, action, inputs)[-1] for model in (near, base))
    assert 0.0 <= float(lifted - plain) < 1e-3 * 9.81 * base.dt
