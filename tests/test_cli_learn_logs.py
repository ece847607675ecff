"""`learn quadrotor --data` and `learn car --data`: equations of a robot that is not registered, from its logs alone."""

from pathlib import Path

import pytest
from cli_results import Refused, result_of
from quick_engines import Linear

from sym2real.cli import main
from sym2real.experiments.flights import car_drives
from sym2real.experiments.learning import learn_from_logs
from sym2real.experiments.measured import measured
from sym2real.logs import read_log, write_log
from sym2real.regression import ENGINES
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS, Robot
from sym2real.symbolic import load_model


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Noise-free logs of the plain car, steered by pure pursuit and at random; the last is for judging."""
    folder = tmp_path_factory.mktemp("drives")
    logs = [str(folder / f"{place}.csv") for place in range(5)]
    for log, drive in zip(logs, car_drives(len(logs), seed=5), strict=True):
        write_log(drive, log)
    return logs


@pytest.mark.slow
def test_any_car_is_learned_from_its_logs_and_compared(drives: list[str], tmp_path: Path) -> None:
    *training, held_out = drives
    model = str(tmp_path / "model")
    main(["learn", "car", "--data", *training, "--numbers", "wheelbase=0.31", "mass=4", "--out", model])
    learned = load_model(tmp_path / "model")
    assert (learned.robot, learned.dt) == ("", 0.05)
    assert learned.layouts.action == MUSHR.layouts.action
    assert learned.numbers == {"wheelbase": 0.31, "mass": 4.0}
    compared = result_of(["compare", model, held_out], tmp_path)
    assert compared["one_step"]["errors"]["position"]["skill"] > 0.9


def test_what_is_learned_is_what_a_registered_robot_of_the_same_logs_learns(
    drives: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(ENGINES._entries, "beam", Linear)
    logs = [Path(drive) for drive in drives[:2]]
    anonymous, named = (learn_from_logs(measured(name), logs, None, "beam").equations for name in ("car", "mushr"))
    assert anonymous.next == named.next
    assert anonymous.numbers == {}
    assert named.numbers == MUSHR.numbers


def test_the_step_is_that_of_the_logs(drives: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every second row of a drive at 20 Hz is a log of 10 Hz; a registered robot keeps its own step."""
    monkeypatch.setitem(ENGINES._entries, "beam", Linear)
    thin = list[Path]()
    for log in drives[:3]:
        header, *rows = Path(log).read_text().splitlines()
        thin.append(tmp_path / Path(log).name)
        thin[-1].write_text("\n".join([header, *rows[::2], ""]))
    dts = {name: learn_from_logs(measured(name), thin, None, "beam").equations.dt for name in ("car", "mushr")}
    assert dts == {"car": 0.1, "mushr": 0.05}


def test_a_quadrotor_of_logs_takes_thrust_and_rates(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(ENGINES._entries, "beam", Linear)
    log = tmp_path / "log.csv"
    main(["simulate", "crazyflie", "circle", "--seconds", "6", "--out", str(log)])
    learned = learn_from_logs(measured("quadrotor"), [log], None, "beam").equations
    assert learned.layouts.action == CRAZYFLIE.layouts.action
    assert learned.dt == pytest.approx(read_log(log).dt)


@pytest.mark.parametrize(("kind", "like"), [("quadrotor", CRAZYFLIE), ("car", MUSHR)])
def test_without_logs_it_has_no_simulator_and_the_error_says_what_to_type(
    kind: str, like: Robot, refused: Refused, tmp_path: Path
) -> None:
    said = refused(f"learn {kind} --out {tmp_path}/model")
    assert "expected --data LOGS" in said
    assert f"`sym2real nominal {kind} --help`" in said
    assert like.name in said
    assert not (tmp_path / "model").exists()
    assert kind not in ROBOTS


def test_a_log_with_motors_is_sent_to_the_equations_for_motors(refused: Refused, tmp_path: Path) -> None:
    columns = "t,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz,motor1,motor2,motor3,motor4"
    rows = [",".join([f"{0.02 * i:.2f}", "0,0,1,1,0,0,0,0,0,0,0,0,0", "0.5,0.5,0.5,0.5"]) for i in range(200)]
    (tmp_path / "log.csv").write_text("\n".join([columns, *rows, ""]))
    said = refused(f"learn quadrotor --data {tmp_path}/log.csv --out {tmp_path}/model")
    assert "`sym2real nominal quadrotor --interface motors`" in said
