"""The launch scripts with a fake robot beside them, in a process of its own, as a user starts them."""

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from rich.console import Console

from hardware.checking import Checking
from hardware.command_line import main as run_verb
from hardware.crazyflie.laboratory import CrazyflieLaboratory
from hardware.crazyflie.thrust_map import THRUST_MAPS
from hardware.interfaces import Reading
from hardware.recorder import STAGES
from hardware.run import Run
from hardware.safety import Limits
from sym2real.errors import DataError, ModelError, ShapeError
from sym2real.logs.table import read_table
from sym2real.robots import CRAZYFLIE, quadrotor
from sym2real.symbolic.storage import save_model

# A machine that others use may be late: what is tested is what happens, not how fast.
PATIENT = Limits(pose_age=60.0, attitude_age=60.0, late=60.0, overruns=10000)


@pytest.fixture(autouse=True)
def patient_firmware(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the patience above: no real flight may be that late."""
    monkeypatch.setattr("hardware.safety.LEVELS_AFTER", math.inf)


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("model")
    save_model(CRAZYFLIE.nominal(), folder)
    return str(folder)


def test_a_flight_from_check_to_comparison(model: str, tmp_path: Path) -> None:
    """Hidden in the fake: a fifth of the thrust is missing. It still takes off, hovers too low, and lands."""
    out, said = tmp_path / "run", Console(record=True, width=120)
    laboratory = CrazyflieLaboratory(sim=True, effects=("gain:thrust", "value=0.85"), limits=PATIENT)
    flown = Run(model, "hover", out, laboratory, seconds=4.0, samples=512)
    result = flown.run(said)
    words = said.export_text()
    order = ["warming", "waiting for", "measuring", "taking off", "landing", "record in", "ahead"]
    assert [words.index(word) for word in order] == sorted(words.index(word) for word in order)
    assert result["completed"]
    assert result["ended"] == "the task is over"
    record, task = read_table(out / "flight.parquet").columns, read_table(out / "hover.csv").columns
    assert record["z"][-1] < 0.06
    assert set(record["stage"]) == {0.0, 1.0, 2.0}
    in_task = record["stage"] == STAGES["task"]
    assert in_task.sum() == 200
    # On a machine that others use, motion capture may have had a gap: no velocity is known right after one.
    assert len(task["z"]) == np.isfinite(record["vz"][in_task]).sum() > 150
    assert task["z"].mean() < 0.99  # MPPI believes the model: the drone hangs below the place
    about = yaml.safe_load((out / "flight.yaml").read_text())
    assert about["ended"] == "the task is over"
    assert about["thrust_map"]["name"] == "2025.02"
    assert result["comparison"]["horizons"]
    with pytest.raises(DataError, match="written over"):
        flown.run(Console(quiet=True))


def test_a_dry_run_sends_nothing(model: str, tmp_path: Path) -> None:
    out = tmp_path / "run"
    dry = Run(model, "hover", out, CrazyflieLaboratory(sim=True, limits=PATIENT), samples=64, dry_run=True)
    assert dry.run(Console(quiet=True))["sent"] == 0
    assert not out.exists()


def test_the_link_is_checked_and_nothing_moves(capsys: pytest.CaptureFixture[str]) -> None:
    options = "--sim --dry-run --seconds 1 --json - --limits.pose-age 60"
    run_verb(Checking[CrazyflieLaboratory], "check", None, options.split())
    told = json.loads(capsys.readouterr().out)
    held = {check["name"]: check["holds"] for check in told["checks"]}
    assert held["battery"] and held["tilt"] and held["position"] and held["motion capture"]
    assert held["yaw against motion capture"]


def test_a_map_must_be_named_for_a_real_robot(model: str, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"--thrust-map.*2026\.04"):
        CrazyflieLaboratory().map()
    with pytest.raises(ModelError, match="--mass"):
        CrazyflieLaboratory(thrust_map="2025.02", hover_counts=40000.0).map()
    calibrated = CrazyflieLaboratory(thrust_map="2025.02", hover_counts=40000.0, mass=0.03, gain=0.5).map()
    assert calibrated.per_newton == pytest.approx(2 * 40000.0 / (0.03 * 9.81))
    assert CrazyflieLaboratory(sim=True).map() is THRUST_MAPS["2025.02"]
    said = Console(record=True)
    with pytest.raises(ModelError, match="--thrust-map"):
        Run(model, "hover", tmp_path / "run", CrazyflieLaboratory()).run(said)
    assert "warming" not in said.export_text(), "it is asked for before the work"
    wrong = CrazyflieLaboratory(thrust_map="paper", effects=("wind",))
    with pytest.raises(ModelError, match="--sim"), wrong.open(CRAZYFLIE.start, print):
        pass


def test_a_robot_that_does_not_answer_is_one_error(capsys: pytest.CaptureFixture[str]) -> None:
    options = "--thrust-map paper --uri udp://127.0.0.1:1 --capture mock"
    options += " --settings rigid_bodies=cf1(0,0,0,1,0,0,0) frequency=100"
    with pytest.raises(SystemExit) as ended:
        run_verb(Checking[CrazyflieLaboratory], "check", None, options.split())
    assert ended.value.code == 2
    assert "udp://127.0.0.1:1" in capsys.readouterr().err


def test_numbers_that_no_flight_has_are_refused_before_it(model: str, tmp_path: Path, capsys: Any) -> None:
    """No seconds were the task's own twenty; a mass in grams took off at full thrust, and landed at full thrust."""
    for typed in ("--seconds 0", "--seconds -3", "--samples 0", "--seed -1"):
        command = f"{model} hover --out {tmp_path} --sim {typed}"
        with pytest.raises(SystemExit) as ended:
            run_verb(Run[CrazyflieLaboratory], "fly", None, command.split())
        assert ended.value.code == 2
        assert "expected a" in capsys.readouterr().err
    for mass in (32.0, 0.0, -0.03, float("nan")):
        with pytest.raises(ShapeError, match="a mass in kg that"):
            CrazyflieLaboratory(sim=True, mass=mass).pilot()
    degrees, percent = (Limits(tilt=70.0), Limits(standing_tilt=10.0)), Limits(blind_thrust=94.0)
    for limits in (*degrees, percent, Limits(low=(1.5, -1.5, 0.0), high=(-1.5, 1.5, 1.7)), Limits(descent=-0.3)):
        with pytest.raises(ShapeError, match="limits: expected"):
            CrazyflieLaboratory(sim=True, limits=limits).pilot()


ON_THE_GROUND = np.array([0.1, 0.2, 0.0125, 1.0, *[0.0] * 9])


def ground(**changed: object) -> list[Reading]:
    values = {"battery": 4.0, "flags": frozenset({"can_fly"}), "extra": {"capture_yaw": 0.0}} | changed
    ages, noise = {"pose": 0.01, "attitude": 0.01}, 1e-4 * np.random.default_rng(0).standard_normal((100, 13))
    state = values.pop("state", ON_THE_GROUND)
    return [Reading(0.01 * at, state + noise[at], ages, **values) for at in range(100)]  # type: ignore[arg-type,operator]


def test_poses_that_repeat_to_the_last_bit_forbid_a_take_off() -> None:
    frozen = [replace(reading, state=ON_THE_GROUND) for reading in ground()]
    failed = [check for check in CrazyflieLaboratory().checks(frozen) if not check.holds]
    assert [check.name for check in failed] == ["spread of the position"]


def test_checks_hold_on_a_robot_that_stands_ready() -> None:
    assert all(check.holds for check in CrazyflieLaboratory().checks(ground()))


@pytest.mark.parametrize(
    ("changed", "name"),
    [
        ({"battery": 3.4}, "battery"),
        ({"battery": float("nan")}, "battery"),
        ({"flags": frozenset({"locked"})}, "supervisor"),
        ({"state": np.array([9.0, 0.0, 0.0, 1.0, *[0.0] * 9])}, "position"),
        ({"state": np.array([0.0, 0.0, 0.0, 0.98, 0.2, *[0.0] * 8])}, "tilt"),
        ({"state": np.array([*ON_THE_GROUND[:10], 0.0, 0.0, 0.1])}, "rate"),
        ({"extra": {"capture_yaw": 1.0}}, "yaw against motion capture"),
        ({"state": np.full(13, np.nan)}, "tilt"),
    ],
)
def test_what_forbids_a_take_off_is_named(changed: dict[str, object], name: str) -> None:
    failed = [check for check in CrazyflieLaboratory().checks(ground(**changed)) if not check.holds]
    assert name in [check.name for check in failed]
    assert all(check.advice for check in failed)


@pytest.mark.parametrize(("interface", "group"), [("motors", "commands"), ("thrust_attitude", "state")])
def test_a_model_of_other_commands_is_refused_before_anything_arms(interface: Any, group: str, tmp_path: Path) -> None:
    save_model(quadrotor(0.03, (1.6e-5, 1.6e-5, 2.9e-5), interface=interface), tmp_path / "model")
    script = Run(str(tmp_path / "model"), "hover", tmp_path / "run", CrazyflieLaboratory(sim=True))
    with pytest.raises(ModelError, match=f"expected a model with the {group} .*, found"):
        script.run(Console(quiet=True))
    assert not (tmp_path / "run").exists()
