"""`inspect` prints the `nominal` command for a log: it runs as it stands, and the model is for that log."""

import json
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_results import result_of
from kinematic_car import car, drive
from log_files import saved
from long_flight import flight, save

from sym2real.cli import main
from sym2real.data import example_flight
from sym2real.effects import effect
from sym2real.symbolic import load_model

PUT = {"KILOGRAMS": "0.027", "METRES": "0.2955"}


def inspected(log: Path, folder: Path, *options: str) -> dict[str, Any]:
    """What `inspect --json` says of the next command."""
    found: dict[str, Any] = result_of(["inspect", str(log), *options], folder)["nominal"]
    return found


def runs(command: str, log: Path, spec: Path, folder: Path) -> dict[str, Any]:
    """What `compare` says for the log of the model ``model`` that a printed line makes."""
    words = shlex.split(command)
    assert words[0] == "sym2real"
    main([str(folder / "model") if word == "runs/nominal" else PUT.get(word, word) for word in words[1:]])
    return result_of(["compare", str(folder / "model"), str(log), "--spec", str(spec)], folder)


def test_motors_of_a_flight(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec = tmp_path / "my flight.toml"
    found = inspected(example_flight(), tmp_path, "--out", str(spec))
    printed = " ".join(capsys.readouterr().out.split())
    assert found["command"] in printed
    assert found["remarks"] == []
    assert "--interface motors --attitude measured --motor-unit command --dt 0.02 --fit-thrust" in found["command"]
    compared = runs(found["command"], example_flight(), spec, tmp_path)
    assert compared["one_step"]["errors"]["position"]["value"] < 0.001
    assert {"floor", "excess", "fit", "skill", "skill_mean"} <= set(compared["horizons"][0]["errors"]["position"])
    assert compared["residuals"]["lines"]
    assert load_model(tmp_path / "model").layouts.action.columns == ("motor1", "motor2", "motor3", "motor4")


def test_the_step_of_a_log_at_another_rate(tmp_path: Path) -> None:
    log, spec = save(flight(1000, 100.0), tmp_path / "flight.parquet"), tmp_path / "flight.toml"
    found = inspected(log, tmp_path, "--out", str(spec))
    runs(found["command"], log, spec, tmp_path)
    assert load_model(tmp_path / "model").dt == 0.01


@pytest.mark.parametrize(("rate", "held"), [(50.0, False), (10.0, True)])
def test_rows_slower_than_controllers_may_lack_commands(
    rate: float, tmp_path: Path, capsys: pytest.CaptureFixture[str], *, held: bool
) -> None:
    """So the model is to be made with a controller's period; with one that was given nobody is asked for it."""
    log, spec = str(save(flight(400, rate), tmp_path / "flight.parquet")), str(tmp_path / "flight.toml")
    inspected(Path(log), tmp_path, "--out", spec)
    for number, given in enumerate(((), ("--dt", "0.02"))):
        words = ["--interface", "motors", "--log", log, "--spec", spec, "--out", str(tmp_path / f"model{number}")]
        main(["nominal", "quadrotor", *words, *given])
        printed = " ".join(capsys.readouterr().out.split())
        assert ("commands are held for the 0.1 s between two rows" in printed) == (held and not given)


def test_motors_of_no_known_unit_are_asked_for(tmp_path: Path) -> None:
    columns = flight(1000, 100.0)
    columns |= {f"motor{i}": 1400.0 + 800.0 * (columns[f"motor{i}"] - 0.5) for i in range(1, 5)}
    columns |= {f"motor{i}": 2.0 * columns[f"motor{i}"] for i in range(1, 5)}
    found = inspected(save(columns, tmp_path / "flight.parquet"), tmp_path)
    assert "--motor-unit UNIT" in found["command"]
    assert any("UNIT is what the motors are counted in" in remark for remark in found["remarks"])
    assert any("SPEC.toml is the specification above" in remark for remark in found["remarks"])


@pytest.mark.parametrize(
    ("robot", "task", "options"),
    [
        ("crazyflie", "circle", "quadrotor --interface thrust_rates --mass KILOGRAMS --dt 0.02"),
        ("mushr", "circle", "car --wheelbase METRES --dt 0.05"),
    ],
)
def test_simulated_robots(robot: str, task: str, options: str, tmp_path: Path) -> None:
    log, spec = tmp_path / "log.csv", tmp_path / "log.toml"
    main(["simulate", robot, task, "--seconds", "6", "--noise", "--out", str(log)])
    found = inspected(log, tmp_path, "--out", str(spec))
    assert found["command"] == f"sym2real nominal {options} --out runs/nominal"
    assert any(("measure it" in remark) or ("weighs" in remark) for remark in found["remarks"])
    runs(found["command"], log, spec, tmp_path)


def test_thrust_per_mass_needs_no_mass(shared_data: Path, tmp_path: Path) -> None:
    spec = tmp_path / "wind.toml"
    log = shared_data / "quadrotor_wind" / "baseline_nowind.csv"
    found = inspected(log, tmp_path, "--out", str(spec))
    assert "KILOGRAMS" not in found["command"]
    runs(found["command"], log, spec, tmp_path)
    assert "thrust" in load_model(tmp_path / "model").layouts.action.columns


def test_a_log_without_commands_has_no_line_and_says_why(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    columns = {name: v for name, v in flight(1000, 100.0).items() if not name.startswith("motor")}
    found = inspected(save(columns, tmp_path / "log.parquet"), tmp_path)
    assert found["command"] == ""
    assert found["remarks"] == ["no `nominal` line for this log: it lacks thrust, or four motors in a known unit"]
    assert found["remarks"][0] in " ".join(capsys.readouterr().out.split())


def test_numbers_of_rotors_that_no_motor_command_needs_let_a_weak_rotor_be_tested(tmp_path: Path) -> None:
    options = ["nominal", "quadrotor", "--mass", "0.75", "--out"]
    main([*options, str(tmp_path / "plain")])
    main([*options, str(tmp_path / "known"), "--arm", "0.12", "--torque-per-thrust", "0.016"])
    plain, known = (load_model(tmp_path / name) for name in ("plain", "known"))
    assert known.next == plain.next
    assert "arm, torque_per_thrust" in str(effect("rotor_loss", plain).why_not(plain))
    assert effect("rotor_loss", known).why_not(known) == ""


def test_rotors_whose_thrust_nobody_gives_hover_at_half_command(tmp_path: Path) -> None:
    options = ["nominal", "quadrotor", "--mass", "1.2", "--interface", "motors", "--arm", "0.2", "--out"]
    main([*options, str(tmp_path / "model")])
    model = load_model(tmp_path / "model")
    assert model.numbers["arm"] == pytest.approx(0.2)
    still = np.zeros(model.layouts.state.size)
    still[model.layouts.state.index("qw")] = 1.0
    after = model.predict(still, np.full(4, 0.5))
    assert after[model.layouts.state.index("vz")] == pytest.approx(0.0, abs=1e-9)


def test_a_car_without_a_heading_gets_no_line_that_asks_for_one(tmp_path: Path) -> None:
    """Its model holds one; a steering beyond a right angle is a steering wheel's, which the gear is wanted of."""
    time, _, yaw, speed, steer = car()
    wheel, rate = np.degrees(16.0 * steer), np.degrees(np.gradient(yaw, time))
    columns = drive(gyro_z_dps=rate, steering_wheel_deg=wheel, speed_setpoint=speed)
    found = inspected(saved(tmp_path, columns), tmp_path)
    assert found["command"] == ""
    assert "it lacks yaw, its heading" in found["remarks"][0]
    rows = json.loads((tmp_path / "result.json").read_text())["columns"]
    said = {row["meaning"]: row for row in rows}
    assert "no wheel of the road turns" in said["steer"]["evidence"]
    assert said["steer"]["confidence"] == "guess"
    assert "nothing in the log tells its sign" in said["wz"]["evidence"]
    file = saved(tmp_path, columns | {"heading_deg": np.degrees(yaw)})
    assert inspected(file, tmp_path, "--out", str(tmp_path / "car.toml"))["command"]
    assert '# steer = { column = "steering_wheel_deg", unit = "deg", scale' in (tmp_path / "car.toml").read_text()
