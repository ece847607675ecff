"""A model adapted to a robot on the command line: fakes beside the script, in processes of their own."""

import io
import json
import math
from pathlib import Path

import numpy as np
import pytest

from hardware.adapt import Adapt
from hardware.command_line import main as run_verb
from hardware.errors import LinkError
from hardware.mushr.laboratory import MushrLaboratory
from hardware.robots import of_every_robot
from sym2real.logs import read_log
from sym2real.logs.table import read_table
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.symbolic.storage import save_model

# A machine that others use may be late: what is tested is what happens, not how fast.
PATIENT = "--limits.pose-age 60 --limits.late 60 --limits.overruns 10000"
FAR = "--limits.low -9 -9 --limits.high 9 9"


@pytest.fixture(autouse=True)
def patient_firmware(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the patience above: no real flight may be that late."""
    monkeypatch.setattr("hardware.safety.LEVELS_AFTER", math.inf)


@pytest.mark.slow
def test_a_car_is_put_back_before_every_round_and_each_is_recorded(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Hidden in the fake: its steering is off by 0.2 rad. The same command with a round more goes on with the run."""
    save_model(MUSHR.nominal(), tmp_path / "model")
    out = tmp_path / "adapted"
    command = f"mushr {tmp_path}/model circle --sim --effects offset:steer value=0.2 --seconds 3 --samples 64"
    command += f" --memory off --all-rounds --out {out} --json - {PATIENT} {FAR}"
    for rounds in ("1", "2"):
        run_verb(of_every_robot(Adapt), "adapt", None, [*command.split(), "--rounds", rounds])
        told = json.loads(capsys.readouterr().out)
    assert [row["rows"] for row in told["rounds"]] == [60, 60, 60]
    assert told["rounds"][2]["prediction"] < 0.7 * told["rounds"][0]["prediction"]
    for number in range(3):
        log = read_log(out / "rounds" / f"{number:02d}" / "log.parquet", layouts=MUSHR.layouts)
        start = [log.extra["ref_x"][0], log.extra["ref_y"][0]]
        assert np.hypot(*(log.state[0, :2] - start)) < 0.3
        assert np.hypot(*log.state[0, 4:6]) < 0.1, "it stands at the start"
    drives = [read_table(out / "records" / f"drive_{number}.parquet").columns for number in (1, 2)]
    assert [int(sum(drive["stage"] == 1.0)) for drive in drives] == [120, 60]


def test_a_dry_run_checks_the_drone_and_sends_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    save_model(CRAZYFLIE.nominal(), tmp_path / "model")
    out = tmp_path / "adapted"
    command = f"crazyflie {tmp_path}/model hover --sim --dry-run --out {out} --json -"
    command += " --limits.pose-age 60 --limits.attitude-age 60"
    run_verb(of_every_robot(Adapt), "adapt", None, command.split())
    told = capsys.readouterr()
    assert "of hover by a Crazyflie 2.1" in json.loads(told.out)["dry_run"]
    assert "nothing was flown, learned or written" in " ".join(told.err.split())
    assert not out.exists()


def refused(command: str, capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit) as ended:
        run_verb(of_every_robot(Adapt), "adapt", None, command.split())
    assert ended.value.code == 2
    return " ".join(capsys.readouterr().err.split())


def test_a_run_goes_on_with_the_same_thrust_map_only(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A second one says that each command was another thrust: its logs are of another robot."""
    save_model(CRAZYFLIE.nominal(), tmp_path / "model")
    command = f"crazyflie {tmp_path}/model hover --sim --samples 64 --out {tmp_path}/out"
    command += " --limits.pose-age 60 --limits.attitude-age 60 --limits.high 1.5 1.5 0.3"
    assert "the start lies outside the fence" in refused(command, capsys)
    words = refused(f"{command} --thrust-map 2026.04", capsys)
    assert "holds a run with other settings (thrust_map: {'name': '2025.02'" in words
    assert "effects: [] there, ['added_mass', 'value=0.005'] now" in refused(
        f"{command} --effects added_mass value=0.005", capsys
    )


def test_a_run_on_a_robot_does_not_go_on_with_a_fake(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    save_model(MUSHR.nominal(), tmp_path / "model")
    command = f"mushr {tmp_path}/model circle --rounds 1 --seconds 2 --samples 64 --out {tmp_path}/out {PATIENT} {FAR}"
    monkeypatch.setattr("sys.stdin", io.StringIO())
    with MushrLaboratory(sim=True).open(MUSHR.start, print) as fake:
        assert "a person at the keyboard" in refused(f"{command} --master {fake.link.about['master']}", capsys)
    assert "(sim: False there, True now)" in refused(f"{command} --sim", capsys)


def test_a_person_is_asked_to_put_the_car_back(monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    with MushrLaboratory(sim=True).open(MUSHR.start, said.append) as fake:
        master = fake.link.about["master"]
        with MushrLaboratory(master=master).open(MUSHR.start, said.append) as opened:
            assert opened.put is not None
            monkeypatch.setattr("sys.stdin", io.StringIO("\n"))
            opened.put(np.array([1.5, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]))
            assert said == ["put the car near x 1.50 m, y -0.30 m, yaw 90°, then press Enter"]
            with pytest.raises(LinkError, match="a person at the keyboard"):
                opened.put(MUSHR.start)
