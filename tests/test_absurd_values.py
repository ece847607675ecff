"""Values that no robot has, in models and plants: one clear error that names the file and what is wrong with it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import torch
from file_strings import read, write
from safetensors.torch import save_file

from sym2real.adaptation.record import Record
from sym2real.cli import main
from sym2real.effects import effect
from sym2real.effects.filters import filter_commands
from sym2real.errors import DataError, ModelError, ShapeError, Sym2RealError
from sym2real.experiments.learning import trained_dependence
from sym2real.experiments.models import open_model
from sym2real.field import Field
from sym2real.logs import LogSpec
from sym2real.neural.storage import load_residual
from sym2real.plants import load_plant, save_plant
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.symbolic import Equations, save_model
from sym2real.symbolic.storage import training_region

NESTED = "[" * 20_000 + "]" * 20_000
HUGE = 10**400


def set_at(content: Any, place: list[Any], value: Any) -> None:
    *outside, last = place
    for key in outside:
        content = content[key]
    content[last] = value


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (["dt"], HUGE, r"out of range - at `\$\.dt"),
        (["dt"], float("nan"), "JSON is malformed"),
        (["parameters", "k"], HUGE, r"out of range - at `\$\.parameters"),
        (["parameters", "k"], float("nan"), "JSON is malformed"),
        (["numbers", "mass"], float("inf"), "JSON is malformed"),
        (
            ["effects"],
            [{"effect": "slope", "values": {"gx": "a"}}],
            r"`float`, got `str` - at `\$\.effects\[0\]\.values",
        ),
        (["layouts", "state", 0, "kind"], "matrix", r"'matrix' - at `\$\[0\]\.kind"),
        (["layouts", "state", 0, "columns"], "xy", r"`array`, got `str` - at `.*\.columns"),
        (["layouts", "state", 0, "columns"], ["x y"], "letters, digits and _, found 'x y'"),
        (["layouts", "state", 0, "hidden"], "no", r"`bool`, got `str` - at `.*\.hidden"),
        (["layouts", "state", 0, "colour"], "red", "unknown entry of a field 'colour'"),
        (["colour"], "red", "unknown field `colour`"),
        (["layouts", "state", 0], ["x"], r"`object`, got `array` - at `\$\.layouts"),
        (["layouts", "state", 0], {"name": "position"}, "missing required field `columns`"),
        (["notes"], [{"a": 1}], r"`str`, got `object` - at `\$\.notes"),
        (["next", "x"], "1" * 5000, "equation of 'x'"),
    ],
)
def test_equations_with_a_value_that_none_have(place: list[Any], value: Any, message: str, tmp_path: Path) -> None:
    equations = Equations.parse(
        MUSHR.layouts, dict.fromkeys(MUSHR.layouts.state, "k*x"), 0.05, parameters={"k": 1.0}, numbers={"mass": 1.0}
    )
    file = save_model(equations, tmp_path) / "equations.json"
    content = read(file)
    set_at(content, place, value)
    write(file, content)
    with pytest.raises(ModelError, match=rf"equations\.json.*{message}"):
        open_model(str(tmp_path))


def test_a_weight_that_is_no_number(tmp_path: Path) -> None:
    equations = Equations.parse(MUSHR.layouts, dict.fromkeys(MUSHR.layouts.state, "k*x"), 0.05, parameters={"k": 1.0})
    file = save_model(equations, tmp_path) / "parameters.safetensors"
    about = read(file)
    save_file({"parameters": torch.tensor([float("nan")], dtype=torch.float64)}, file, about)
    with pytest.raises(ModelError, match="parameter 'k': expected a finite number, found nan"):
        open_model(str(tmp_path))


@pytest.mark.parametrize("name", ["equations.json", "training.json", "settings.json", "plant.toml", "spec.toml"])
def test_a_file_that_is_nested_without_end(name: str, tmp_path: Path) -> None:
    file = tmp_path / name
    save_plant(MUSHR, [("slope", {"gx": 0.1})], tmp_path)
    file.write_text(f"robot = {NESTED}" if name.endswith("toml") else NESTED)
    opened = {
        "equations.json": lambda: open_model(str(tmp_path)),
        "training.json": lambda: training_region(tmp_path),
        "settings.json": lambda: Record(tmp_path, MUSHR.layouts).claim({}),
        "plant.toml": lambda: load_plant(tmp_path),
        "spec.toml": lambda: LogSpec.load(file),
    }
    with pytest.raises(Sym2RealError, match=rf"{name}.*(too deeply|recursion|got `array`)"):
        opened[name]()


@pytest.mark.parametrize(
    ("dependence", "region"),
    [("rows", {"x": [0, HUGE]}), ([{"state": "x"}], {"x": [0]}), ([3], [3]), ({"a": 1}, 3)],
)
def test_a_training_record_of_another_shape(dependence: object, region: object, tmp_path: Path) -> None:
    (tmp_path / "training.json").write_text(json.dumps({"dependence": dependence, "region": region}))
    with pytest.raises(DataError, match=r"training\.json"):
        training_region(tmp_path)
    with pytest.raises(DataError, match=r"training\.json"):
        trained_dependence(tmp_path)


@pytest.mark.parametrize(
    ("effects", "message"),
    [
        ('[{ effect = "delay", value = 1e9 }]', "delay: expected at least 0 and at most 60 s"),
        (f'[{{ effect = "slope", gx = {HUGE} }}]', "slope: expected a finite number for gx"),
        (f'[{{ effect = "slope", gx = 1{"0" * 5000} }}]', "expected a plant file"),
        ('[{ effect = "slope", gx = nan }]', "slope: expected a finite number for gx"),
        ('[{ effect = "slope", gx = true }]', "slope: expected a number for gx"),
        ('["slope"]', "expected a plant file"),
    ],
)
def test_a_plant_with_a_value_that_none_has(effects: str, message: str, tmp_path: Path) -> None:
    save_plant(MUSHR, [], tmp_path)
    with (tmp_path / "plant.toml").open("a") as file:
        file.write(f"effects = {effects}\n")
    with pytest.raises((DataError, ModelError), match=rf"plant\.toml: {message}"):
        load_plant(tmp_path)


def test_a_delay_without_end_in_equations_fills_no_memory() -> None:
    late = Equations.parse(
        MUSHR.layouts, dict.fromkeys(MUSHR.layouts.state, "x"), 0.05, filters=[("delay", {"value": "1e9"})]
    )
    with pytest.raises(ModelError, match="delay of at most 60 s, found 1e"):
        filter_commands(late, torch.zeros(3, 2))
    with pytest.raises(ModelError, match="at most 60 s for value"):
        effect("time_shift:x", MUSHR).inject(value=1e9)


def test_the_description_of_another_robot(tmp_path: Path) -> None:
    """As it is, and with its body named as the other's."""
    for robot in (MUSHR, CRAZYFLIE):
        save_plant(robot, [], tmp_path / robot.name)
    foreign = (tmp_path / "mushr" / "robot.xml").read_text()
    for text in (foreign, foreign.replace('"mushr"', '"crazyflie"')):
        (tmp_path / "crazyflie" / "robot.xml").write_text(text)
        with pytest.raises(DataError, match=r"robot\.xml: expected a MuJoCo description of a crazyflie, found another"):
            load_plant(tmp_path / "crazyflie")


@pytest.mark.parametrize("place", ["../mushr/robot.xml", "/dev/stdin", "robot.xml/../../x.xml"])
def test_a_description_elsewhere_is_not_opened(place: str, tmp_path: Path) -> None:
    save_plant(MUSHR, [], tmp_path)
    file = tmp_path / "plant.toml"
    file.write_text(file.read_text().replace('"robot.xml"', json.dumps(place)))
    with pytest.raises(DataError, match="a description beside the plant file"):
        load_plant(tmp_path)


def test_equations_of_a_quadrotor_that_name_a_car(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = save_model(CRAZYFLIE.nominal(), tmp_path) / "equations.json"
    content = read(file)
    write(file, {**content, "robot": "mushr"})
    with pytest.raises(SystemExit):
        main(["compare", str(tmp_path), "log.csv"])
    printed = capsys.readouterr()
    assert "names the robot mushr: expected the state x y sin_yaw" in " ".join((printed.out + printed.err).split())


@pytest.mark.parametrize("about", ['"crazyflie"', "{}", '{"state": ["x y"], "action": ["thrust"], "widths": [4]}', "["])
def test_a_residual_whose_header_says_something_else(about: str, tmp_path: Path) -> None:
    save_file({"w": torch.zeros(1)}, tmp_path / "residual.safetensors", {"about": about})
    with pytest.raises(DataError, match=r"residual\.safetensors"):
        load_residual(tmp_path)


def test_a_field_says_which_column_cannot_be_named() -> None:
    for column in ("a b", "1x", "x;", "for", "", "ﬁ"):
        with pytest.raises(ShapeError, match="letters, digits and _"):
            Field("sensor", ("x", column))
