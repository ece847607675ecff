"""`nominal --fit-thrust`: step and unit come from the log, a gap is stepped around, wrong combinations are refused."""

from pathlib import Path

import numpy as np
import pytest
from cli_results import Refused
from long_flight import GRAVITY, HOVER, flight, save

from sym2real.cli import main
from sym2real.logs import LogSpec, inspect_logs
from sym2real.symbolic import load_model
from sym2real.trajectory import Array

FULL = 2000.0  # rad/s of a rotor at full command
NOMINAL = ["nominal", "quadrotor", "--interface", "motors", "--attitude", "measured"]
MOTORS = ("motor1", "motor2", "motor3", "motor4")
PER_COMMAND = GRAVITY / (4 * HOVER)


def as_speeds(columns: dict[str, Array]) -> dict[str, Array]:
    """The same flight with rotors whose thrust goes with the square of their speed in rad/s."""
    return columns | {name: FULL * np.sqrt(columns[name]) for name in MOTORS}


def logged(folder: Path, columns: dict[str, Array]) -> list[str]:
    """Options that give the flight, with the specification that `inspect` proposes."""
    log = save(columns, folder / "flight.parquet")
    spec = folder / "flight.toml"
    inspect_logs(log).spec.save(spec)
    return ["--fit-thrust", str(log), "--spec", str(spec)]


def thrust_in(printed: str) -> float:
    """The number in the line on the fit."""
    return float(printed.split("fitted on the first two seconds: ")[1].split(maxsplit=1)[0])


@pytest.mark.parametrize("hertz", [100.0, 50.0])
def test_the_step_is_the_logs_and_an_option_takes_another(
    hertz: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = logged(tmp_path, flight(1000, hertz))
    main([*NOMINAL, *options, "--out", str(tmp_path / "own")])
    printed = capsys.readouterr().out
    assert load_model(tmp_path / "own").dt == pytest.approx(1.0 / hertz, rel=1e-12)
    assert f"time step {1.0 / hertz:g} s, the log's own" in printed
    assert thrust_in(printed) == pytest.approx(PER_COMMAND, rel=0.01)
    main([*NOMINAL, *options, "--dt", "0.04", "--out", str(tmp_path / "other")])
    assert load_model(tmp_path / "other").dt == 0.04
    assert "time step" not in capsys.readouterr().out


def test_without_a_log_the_step_is_the_usual_one(tmp_path: Path) -> None:
    main(["nominal", "quadrotor", "--out", str(tmp_path / "model")])
    assert load_model(tmp_path / "model").dt == 0.02


@pytest.mark.parametrize(("swing", "low", "high"), [(0.0, 0.0, 0.5), (0.02, 1.0, 6.0)])
def test_how_well_the_thrust_is_known_is_printed(
    swing: float, low: float, high: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    columns = flight(1000, 50.0)
    columns |= {name: columns[name] * (1.0 + swing * np.sin(0.02 * np.arange(1000))) for name in MOTORS}
    main([*NOMINAL, *logged(tmp_path, columns), "--out", str(tmp_path / "model")])
    printed = capsys.readouterr().out
    known = float(printed.split(" ± ")[1].split(" %")[0])
    assert low <= known < high
    main([*NOMINAL, *logged(tmp_path, {n: v[:300] for n, v in columns.items()}), "--out", str(tmp_path / "short")])
    assert " ± " not in capsys.readouterr().out


@pytest.mark.parametrize("unit", ["rad/s", "rpm"])
def test_speeds_that_the_specification_names_are_squared(
    unit: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    columns = as_speeds(flight(1000, 100.0))
    scale = {"rad/s": 1.0, "rpm": 60.0 / (2.0 * np.pi)}[unit]
    log = save({n: scale * v if n in MOTORS else v for n, v in columns.items()}, tmp_path / "flight.parquet")
    text = inspect_logs(log).spec.toml()
    for name in MOTORS:
        text = text.replace(f'{name} = "{name}"', f'{name} = {{ column = "{name}", unit = "{unit}" }}')
    assert LogSpec.parse(text).columns["motor1"].unit == unit
    (tmp_path / "flight.toml").write_text(text)
    main([*NOMINAL, "--fit-thrust", str(log), "--spec", str(tmp_path / "flight.toml"), "--out", str(tmp_path / "m")])
    assert thrust_in(capsys.readouterr().out) == pytest.approx(PER_COMMAND / FULL**2, rel=0.02)


def test_speeds_of_no_known_unit_are_refused_with_the_option_that_names_it(
    tmp_path: Path, refused: Refused, capsys: pytest.CaptureFixture[str]
) -> None:
    command = [*NOMINAL, *logged(tmp_path, as_speeds(flight(1000, 100.0))), "--out", str(tmp_path / "model")]
    for asked in ([], ["--motor-unit", "command"]):
        error = refused([*command, *asked])
        assert "--motor-unit rad/s" in error
        assert "found 14" in error  # 2000 √0.5
        assert not (tmp_path / "model").exists()
    main([*command, "--motor-unit", "rad/s"])
    assert thrust_in(capsys.readouterr().out) == pytest.approx(PER_COMMAND / FULL**2, rel=0.02)


def test_commands_are_no_speeds(tmp_path: Path, refused: Refused) -> None:
    options = logged(tmp_path, flight(1000, 100.0))
    error = refused([*NOMINAL, *options, "--motor-unit", "rad/s", "--out", str(tmp_path / "model")])
    assert "--motor-unit command" in error
    assert "flight.parquet" in error


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ("--motor-unit rad/s", "--motor-unit rad/s needs"),
        ("--interface thrust_rates --motor-unit rad/s", "need --interface motors"),
        ("--motor-thrust 2 --fit-thrust {logs}/a.parquet", "found both"),
        ("--spec crazyflie_battery_drag", "found no --log or --fit-thrust"),
        ("--fit-thrust {logs}", "one log to fit the thrust on"),
    ],
)
def test_options_that_contradict_each_other_are_refused(
    options: str, expected: str, refused: Refused, tmp_path: Path
) -> None:
    (tmp_path / "logs").mkdir()
    for name in ("a", "b"):
        save(flight(200, 50.0), tmp_path / "logs" / f"{name}.parquet")
    given = options.format(logs=tmp_path / "logs").split()
    assert expected in refused([*NOMINAL, *given, "--out", str(tmp_path / "model")])
    assert not (tmp_path / "model").exists()


def test_a_gap_is_stepped_around_and_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A second of flight, a hole of five, eight seconds of flight: those give the thrust, and the step stays."""
    columns = flight(1000, 100.0)
    columns["timestamp"] = columns["timestamp"] + np.where(np.arange(1000) < 100, 0.0, 5.0)
    main([*NOMINAL, *logged(tmp_path, columns), "--out", str(tmp_path / "model")])
    printed = " ".join(capsys.readouterr().out.split())
    assert "2 stretches with gaps between them: the longest is used, 8.99 s" in printed
    assert thrust_in(printed) == pytest.approx(PER_COMMAND, rel=0.01)
    assert load_model(tmp_path / "model").dt == pytest.approx(0.01)
