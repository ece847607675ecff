"""What the verbs around a diagnosis print and leave: files, models that fly, simulators, hypotheses of one's own."""

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_results import Refused, result_of
from real_logs import motor_level_equations
from rich.console import Console
from standard_set import Case, simulate_case

from sym2real.cli import main
from sym2real.cli.model import logs_for
from sym2real.cli.results import write_simulator
from sym2real.data import example_flight
from sym2real.dataset import Dataset
from sym2real.diagnosis import add, add_term, compare, diagnose, try_effect
from sym2real.diagnosis.estimate.simulator import flown_along, with_effects_of
from sym2real.effects import noted
from sym2real.effects.voltage import with_voltage
from sym2real.errors import ModelError
from sym2real.logs import read_logs, write_log
from sym2real.plants import MujocoPlant
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic import load_model, save_model

# Left out to keep the tests short; mass, wind, tilt, drag and what stands for them compete.
EXCLUDED = (
    *("gain:w*", "limit:*", "delay*", "lag*"),
    *("motor_lag", "flapping_moment", "translational_lift", "thrust_curve"),
)
TRUE_MASS = 0.004


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A base model and three CSV logs of a robot that is too heavy."""
    folder = tmp_path_factory.mktemp("found")
    save_model(CRAZYFLIE.nominal(), folder / "base")
    for trajectory in simulate_case(Case("crazyflie", (("added_mass", {"value": TRUE_MASS}),), seed=1), 3, 350):
        write_log(trajectory, folder / f"{trajectory.name}.csv")
    return folder


@pytest.fixture(scope="module")
def logs(folder: Path) -> list[str]:
    return [str(path) for path in sorted(folder.glob("run_*.csv"))]


@pytest.fixture(scope="module")
def diagnosed(folder: Path, logs: list[str]) -> dict[str, Any]:
    options = ["--exclude", *EXCLUDED, "--no-calibrate", "--horizon", "0.6", "--out", str(folder / "found")]
    return result_of(["diagnose", str(folder / "base"), *logs, *options], folder)


def test_the_object_is_the_designs(folder: Path, diagnosed: dict[str, Any]) -> None:
    assert diagnosed == json.loads((folder / "found" / "diagnosis.json").read_text())
    assert {"verdict", "summary", "faults", "findings", "leftover", "where", "ladder", "floor"} <= diagnosed.keys()
    (finding, *_) = diagnosed["findings"]
    assert finding["effect"] == "added_mass"
    assert finding["parameters"]["value"].keys() == {"value", "low", "high", "unit", "determined"}
    assert {"share", "group", "separate_by", "provisional", "small", "doubtful", "fix"} <= finding.keys()
    assert [rung["model"] for rung in diagnosed["ladder"]][:2] == ["base", "+ added_mass"]
    horizons = [row["horizon"] for row in diagnosed["ladder"][0]["horizons"]]
    assert horizons == [0.1, 0.2, 0.5, 0.6]  # --horizon is the longest, and is there
    assert [row["horizon"] for row in diagnosed["floor"]] == horizons
    last = [rungs["horizons"][-1]["errors"]["position"] for rungs in diagnosed["ladder"]]
    floor = diagnosed["floor"][-1]["errors"]["position"]
    assert last[0].keys() == {"value", "mean", "low", "high", "unit"}
    assert floor.keys() == {"value", "unit"}
    assert 0.5 * floor["value"] < last[1]["value"] < 0.3 * last[0]["value"]
    wanted = {"statement", "channel", "feature", "low", "high", "ratio", "coverage", "inside_training"}
    assert all(wanted == statement.keys() for statement in diagnosed["where"])


def test_it_leaves_a_page_a_model_and_a_simulator(folder: Path, diagnosed: dict[str, Any]) -> None:
    out = folder / "found"
    assert (out / "report.html").stat().st_size > 10_000
    heavier = load_model(out / "model")
    assert noted(heavier)[0].startswith("added_mass value=0.00")
    value = diagnosed["findings"][0]["parameters"]["value"]["value"]
    assert value == pytest.approx(TRUE_MASS, rel=0.1)
    assert str(round(0.02 / (CRAZYFLIE.mass + value), 4))[:5] in heavier.latex()["vx"]


def test_the_found_model_flies_the_found_simulator(folder: Path, diagnosed: dict[str, Any], tmp_path: Path) -> None:
    out, errors = folder / "found", {}
    for model in (folder / "base", out / "model"):
        options = ["--plant", str(out / "simulator"), "--samples", "128", "--seconds", "4"]
        errors[model.name] = result_of(["run", str(model), "hover", *options], tmp_path)["final"]
    assert errors["model"] < 0.6 * errors["base"]
    log = tmp_path / "log.csv"
    main(["simulate", str(out / "simulator"), "hover", "--seconds", "4", "--out", str(log)])
    thrust = read_logs([log], layouts=CRAZYFLIE.layouts, dt=CRAZYFLIE.dt)[0].column("thrust")[-50:].mean()
    assert thrust == pytest.approx((CRAZYFLIE.mass + TRUE_MASS) * 9.81, rel=0.03)


@pytest.mark.slow
def test_a_hypothesis_is_fitted_held_out_and_written(folder: Path, logs: list[str], tmp_path: Path) -> None:
    options = ["--fit", *logs[:2], "--held-out", logs[2], "--no-calibrate", "--out", str(tmp_path / "heavier")]
    tried = result_of(["add", str(folder / "base"), "added_mass", *options], tmp_path)
    assert tried["supported"]
    assert tried["finding"]["parameters"]["value"]["value"] == pytest.approx(TRUE_MASS, rel=0.1)
    assert {"gain:thrust", "offset:thrust"} <= set(tried["finding"]["group"])
    assert tried["rivals"]
    assert all(rival["gain"] < tried["gain"] for rival in tried["rivals"])
    assert tried["held_out"] == ["run_3"]
    fitted = tried["finding"]["parameters"]["value"]["value"]
    assert tried["effects"] == [{"effect": "added_mass", "values": {"value": fitted}}]
    assert (tmp_path / "heavier" / "simulator" / "robot.xml").exists()


def test_a_sag_that_was_found_per_volt_is_per_volt_in_the_model(tmp_path: Path) -> None:
    """The log holds the voltage, the model does not: 0.3 1/V taken for 0.3 1/s drops the robot in three seconds."""
    spec = "crazyflie_battery_drag"
    save_model(motor_level_equations(example_flight(), spec), tmp_path / "base")
    options = ["--fit", str(example_flight()), "--spec", spec, "--out", str(tmp_path / "new")]
    tried = result_of(["add", str(tmp_path / "base"), "battery_sag", *options], tmp_path)
    assert tried["finding"]["parameters"]["value"]["unit"] == "1/V"
    written = load_model(tmp_path / "new")
    assert written.depends("vz", "vbat")
    assert "t" not in written.layouts.inputs


def test_a_sag_per_volt_is_neither_simulated_nor_flown_there(refused: Refused, tmp_path: Path) -> None:
    sag, console = {"value": 0.2}, Console(file=io.StringIO(), width=200)
    informed = add(with_voltage(CRAZYFLIE.nominal(), 4.1), "battery_sag", sag)
    write_simulator(informed, tmp_path / "simulator", console)
    assert isinstance(console.file, io.StringIO)
    assert "no simulator was written: its battery has no voltage" in console.file.getvalue()
    assert not (tmp_path / "simulator").exists()
    save_model(informed, tmp_path / "model")
    assert "no simulator gives vbat" in refused(f"run {tmp_path}/model hover")


@pytest.mark.slow
def test_a_wrong_hypothesis_is_refused_and_a_better_one_named(folder: Path, logs: list[str]) -> None:
    base = CRAZYFLIE.nominal()
    data = read_logs([Path(log) for log in logs], layouts=base.layouts, dt=base.dt)
    tried = try_effect(base, "torque_bias", data)
    assert not tried.supported
    assert "do not ask for torque_bias" in tried.summary
    assert tried.rivals[0].effect in ("added_mass", "offset:thrust")
    assert abs(tried.finding.values["tx"]) < 2e-6
    without = try_effect(base, "torque_bias", data, exclude=("added_mass", "gain:*"))
    assert without.rivals[0].effect == "offset:thrust"
    assert not {rival.effect for rival in without.rivals} & {"added_mass", "gain:thrust"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("", "expected an effect"),
        ("wind fx=0.1 --fit {log}", "expected their names alone"),
        ("term:fz=0.01 --fit {log}", "expected their names alone"),
        ("wind fx=0.1 --horizon 0.5", "--horizon: expected --fit"),
        ("wind fx=0.1 --held-out {log}", "--held-out: expected --fit"),
        ("rotor_loss --fit {log}", "rotor cannot be fitted"),
        ("periodic_force --fit {log}", "phase cannot be fitted"),
        ("wnd fx=0.1", "did you mean 'wind'"),
        ("wind gx=0.1", "did you mean 'fx'"),
        ("tyre_friction value=0.5", "effect of a car"),
    ],
)
def test_bad_hypotheses_get_one_clear_error(
    arguments: str, message: str, folder: Path, logs: list[str], refused: Refused
) -> None:
    assert message in refused(f"add {folder}/base {arguments.format(log=logs[0])} --out {folder}/unused")
    assert not (folder / "unused").exists()


@pytest.mark.slow
def test_an_interrupted_search_answers_with_what_it_has(logs: list[str]) -> None:
    base = CRAZYFLIE.nominal()
    data = Dataset(list(read_logs([Path(log) for log in logs], layouts=base.layouts, dt=base.dt)))

    def interrupt(message: str) -> None:
        if message.startswith("found so far"):
            raise KeyboardInterrupt

    found = diagnose(base, data, exclude=EXCLUDED, finish_on_interrupt=True, on_progress=interrupt)
    assert [finding.effect for finding in found.findings] == ["added_mass"]
    assert any("interrupted" in note for note in found.notes)
    with pytest.raises(KeyboardInterrupt):
        diagnose(base, data, exclude=EXCLUDED, on_progress=interrupt)


@pytest.mark.slow
def test_an_informed_model_is_diagnosed_again_and_nothing_is_left(folder: Path, logs: list[str]) -> None:
    """Also one whose command filters and hidden states a log does not hold."""
    small = {"value": 1e-4}
    chosen = [("added_mass", {"value": TRUE_MASS}), ("delay", small), ("motor_lag", small)]
    informed = add(CRAZYFLIE.nominal(), chosen)
    data = logs_for(informed, [Path(log) for log in logs], None)
    assert np.isfinite(compare(informed, data).at(0.5).errors["position"].value)
    found = diagnose(informed, data, exclude=EXCLUDED)
    assert "added_mass" not in [one.effect for one in found.findings]


@pytest.mark.slow
def test_an_informed_model_is_calibrated_in_a_simulator_that_knows_as_much(logs: list[str]) -> None:
    """Else what the model knows rightly counts as its own error, and the rest of the effect as none."""
    informed = add(CRAZYFLIE.nominal(), "added_mass", {"value": TRUE_MASS / 2})
    data = logs_for(informed, [Path(log) for log in logs], None)
    found = diagnose(informed, data, MujocoPlant(CRAZYFLIE), exclude=EXCLUDED)
    assert (found.verdict, found.findings[0].effect) == ("EFFECT", "added_mass")
    assert found.findings[0].values["value"] == pytest.approx(TRUE_MASS / 2, rel=0.1)
    assert [key for key, _ in found.apply(informed).effects] == ["added_mass", "added_mass"]


@pytest.mark.slow
def test_commands_that_a_model_delays_are_late_in_its_simulator_too(logs: list[str]) -> None:
    late = add(CRAZYFLIE.nominal(), "delay", {"value": 0.04})
    plant, _ = with_effects_of(late, MujocoPlant(CRAZYFLIE), CRAZYFLIE.dt)
    assert plant is not None
    flown, _ = flown_along(late, plant, logs_for(late, [Path(log) for log in logs[:2]], None))
    assert flown is not None
    # Commands have been delayed already: the equations alone predict what the simulator does.
    error = compare(CRAZYFLIE.nominal(), flown, start="measured").at(0.5).errors["position"].value
    assert error < 0.2 * compare(late, flown, start="measured").at(0.5).errors["position"].value


def test_a_model_that_no_simulator_can_have_is_not_calibrated_and_says_why(logs: list[str]) -> None:
    plant, note = with_effects_of(add_term(CRAZYFLIE.nominal(), "fz", "0.01*vz"), MujocoPlant(CRAZYFLIE), CRAZYFLIE.dt)
    assert plant is None
    assert "no counterpart there (fz)" in note


def test_a_remark_on_the_data_is_printed_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Before the search, which takes long; the result holds it all the same."""
    main(["nominal", "car", "--wheelbase", "0.2955", "--out", str(tmp_path / "bicycle")])
    main(["simulate", "mushr", "circle", "--seconds", "6", "--out", str(tmp_path / "log.csv")])
    capsys.readouterr()
    few = ["--exclude", "gain:*", "offset:*", "delay*", "lag*", "limit:*", "rate_limit*", "dead_band*"]
    found = result_of(["diagnose", str(tmp_path / "bicycle"), str(tmp_path / "log.csv"), *few], tmp_path)
    said = " ".join(capsys.readouterr().out.split())
    assert said.count("no sensor noise") == 1
    assert said.count("no plain simulator") == 1
    assert any("no sensor noise" in note for note in found["notes"])


def test_values_and_logs_at_once_are_refused(folder: Path, logs: list[str]) -> None:
    base = CRAZYFLIE.nominal()
    with pytest.raises(ModelError, match="found both"):
        add(base, "wind", {"fx": 0.1}, fit=read_logs([Path(logs[0])], layouts=base.layouts, dt=base.dt))
