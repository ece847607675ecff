"""A model whose mass nobody gave: every verb that prints forces or masses of it says per what they are."""

from __future__ import annotations

from pathlib import Path

import pytest

from sym2real.cli import main
from sym2real.data import example_flight
from sym2real.diagnosis.faults.checking import Question
from sym2real.diagnosis.pipeline import prepare
from sym2real.diagnosis.stages import Stages
from sym2real.logs import read_log
from sym2real.robots import PER_KILOGRAM
from sym2real.symbolic import load_model

SPEC = "crazyflie_battery_drag"
NOMINAL = ["nominal", "quadrotor", "--interface", "motors", "--attitude", "measured", "--spec", SPEC]


@pytest.mark.parametrize(("mass", "said"), [([], 1), (["--mass", "0.027"], 0)], ids=["no mass", "a mass"])
def test_forces_per_kilogram_are_said_to_be(
    mass: list[str], said: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flight, model = str(example_flight()), str(tmp_path / "model")
    commands = [
        [*NOMINAL, "--fit-thrust", flight, *mass, "--out", model],
        ["plan", flight, "--spec", SPEC, "--model", model],
        ["add", model, "wind", "fx=0.02", "--out", str(tmp_path / "windy")],
    ]
    for command in commands:
        main(command)
        assert " ".join(capsys.readouterr().out.split()).count(PER_KILOGRAM) == said, command[0]
    equations = load_model(tmp_path / "model")
    log = read_log(flight, spec=SPEC, layouts=equations.layouts, dt=equations.dt)
    assert prepare(Question(equations, log), Stages(lambda _: None)).notes.count(PER_KILOGRAM) == said
