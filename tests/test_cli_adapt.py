"""``sym2real adapt`` as a user types it: in a simulator, with logs, again, and with what cannot be."""

import json
from pathlib import Path
from typing import Any

import pytest
from cli_results import Refused, result_of

from sym2real.cli import main
from sym2real.logs import read_log
from sym2real.neural import Composed, open_model
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.symbolic import Equations, save_model

QUICK = ["--seconds", "6", "--samples", "128"]


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A nominal car, a car whose steering does more than it should, and three drives of it with noise."""
    folder = tmp_path_factory.mktemp("adapt")
    save_model(MUSHR.nominal(), folder / "base")
    main(["add", str(folder / "base"), "gain:steer", "value=1.3", "--out", str(folder / "changed")])
    for seed in range(3):
        drive = ["simulate", str(folder / "changed" / "simulator"), "circle", "--noise", "--seed", str(seed)]
        main([*drive, "--seconds", "12", "--out", str(folder / "drives" / f"drive_{seed}.csv")])
    return folder


def adapt(place: Path, *options: str) -> list[str]:
    return ["adapt", str(place / "base"), str(place / "changed" / "simulator"), "circle", *QUICK, *options]


@pytest.fixture(scope="module")
def adapted(place: Path) -> dict[str, Any]:
    return result_of(adapt(place, "--rounds", "1", "--out", str(place / "adapted")), place)


def test_a_model_adapts_to_a_simulator(place: Path, adapted: dict[str, Any]) -> None:
    zero_shot, first = adapted["rounds"]
    assert first["prediction"] < 0.3 * zero_shot["prediction"]
    assert first["gain"]["low"] > 0.0
    assert adapted["best"] == 1
    assert json.loads((place / "adapted" / "adaptation.json").read_text())["rounds"] == adapted["rounds"]
    assert isinstance(open_model(place / "adapted"), Composed)
    assert Path(adapted["figure"]).stat().st_size > 10_000
    log = place / "adapted" / "rounds" / "01" / "log.parquet"
    assert len(read_log(log)) == 120
    compared = result_of(["compare", str(place / "adapted" / "rounds" / "00"), str(log)], place)
    assert compared["one_step"]


def test_a_dry_run_says_what_it_would_do_and_does_nothing(place: Path) -> None:
    out = str(place / "never")
    told = result_of(adapt(place, "--out", out, "--dry-run"), place)
    assert told["dry_run"] == "at most 11 episodes of 6 s of circle by a MuSHR racecar"
    faster = ["adapt", str(place / "base"), "mushr", "circle", "speed=0.5", "--out", out, "--dry-run"]
    assert "of circle by a MuSHR racecar" in result_of(faster, place)["dry_run"]
    logs = ["adapt", str(place / "base"), str(place / "drives"), "--out", out, "--dry-run"]
    assert result_of(logs, place)["dry_run"] == "at most 3 of 3 logs"
    assert not (place / "never").exists()


def test_the_models_own_constants_are_fitted(place: Path) -> None:
    found = result_of(adapt(place, "--rounds", "1", "--learner", "fine-tune", "--out", str(place / "tuned")), place)
    zero_shot, first = found["rounds"]
    assert first["prediction"] < 0.3 * zero_shot["prediction"]
    assert first["learned"]["penalty"] > 0.0
    tuned = open_model(place / "tuned")
    assert isinstance(tuned, Equations)
    assert tuned.next["wz"] != MUSHR.nominal().next["wz"]


def test_a_second_call_continues(place: Path, adapted: dict[str, Any]) -> None:
    out = str(place / "adapted")
    flown = (place / "adapted" / "rounds" / "01" / "log.parquet").stat().st_mtime_ns
    continued = result_of(adapt(place, "--rounds", "1", "--out", out), place)
    assert continued["rounds"] == adapted["rounds"]
    assert continued["best"] == 1
    assert (place / "adapted" / "rounds" / "01" / "log.parquet").stat().st_mtime_ns == flown


@pytest.mark.slow
def test_logs_one_a_round_and_their_effects_in_the_equations(place: Path) -> None:
    options = ["--out", str(place / "from_logs"), "--diagnose", "--learner", "none", "--rounds", "1"]
    found = result_of(["adapt", str(place / "base"), str(place / "drives"), *options], place)
    assert [entry["log"] for entry in found["rounds"]] == ["drive_0", "drive_1"]
    assert found["rounds"][1]["learned"]["effects"] == ["gain:steer"]
    assert found["rounds"][1]["gain"]["low"] > 0.5
    informed = open_model(place / "from_logs")
    assert isinstance(informed, Equations)
    assert dict(informed.effects)["gain:steer"]["value"] == pytest.approx(1.3, rel=0.05)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("base nowhere circle", "unknown target: neither a folder nor a robot 'nowhere'"),
        ("base nowhere --spec mushr_steering_offset", "unknown target: neither a folder nor a robot 'nowhere'"),
        ("base changed circle", "changed is a model; expected the simulator in it: changed/simulator"),
        ("base crazyflie circle", "crazyflie is a crazyflie; the model is of a mushr"),
        ("base crazyflie hover --dry-run", "crazyflie is a crazyflie; the model is of a mushr"),
        ("base mushr loop", "unknown task 'loop'"),
        ("base mushr circle colour=1", "unknown option of circle that is a number 'colour'"),
        ("base mushr", "TASK: expected what to fly in mushr"),
        ("base drives circle", "TASK: nothing flies with the logs of"),
        ("base mushr circle --spec mushr_steering_offset", "--spec is for logs"),
        ("flyer drives", "drive_0.csv"),
        ("base base", "TASK: expected what to fly in base"),
        ("base drives --out base", "another place for --out, found what this command reads as model"),
        ("base drives --out changed", "holds a model that was not adapted there"),
    ],
)
def test_what_cannot_be_is_one_clear_error(
    arguments: str, said: str, place: Path, refused: Refused, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(place)
    save_model(CRAZYFLIE.nominal(), place / "flyer")
    assert said in refused(f"adapt {arguments}" + ("" if "--out" in arguments else " --out refused"))
    assert not (place / "refused").exists()
