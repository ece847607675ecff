"""What the command line refuses: logs, numbers and models that cannot mean anything, each in one error by name."""

import shlex
import shutil
import warnings
from pathlib import Path

import pytest
from cli_results import Refused

from sym2real import diagnosis
from sym2real.cli import main
from sym2real.diagnosis import Plan, Term
from sym2real.report.diagnosis import term_command
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.symbolic import save_model

EMPTY = Plan(visible=(), seconds=4.0, blocks=2, notes=())


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the first-principles models of both robots, and the log of a flight."""
    folder = tmp_path_factory.mktemp("models")
    save_model(CRAZYFLIE.nominal(), folder / "quadrotor")
    save_model(MUSHR.nominal(), folder / "car")
    main(["simulate", "crazyflie", "circle", "--noise", "--seconds", "4", "--out", str(folder / "flight.csv")])
    header, first, *_ = (folder / "flight.csv").read_text().splitlines()
    (folder / "one_row.csv").write_text(f"{header}\n{first}\n")
    return folder


@pytest.mark.parametrize(
    "command",
    [
        "diagnose {models}/quadrotor {models}/one_row.csv",
        "diagnose {models}/quadrotor {models}/flight.csv --held-out {models}/one_row.csv",
        "diagnose {models}/quadrotor {models}/flight.csv {models}/one_row.csv",
        "add {models}/quadrotor wind --fit {models}/one_row.csv --out X",
        "compare {models}/quadrotor {models}/one_row.csv",
        "plan {models}/quadrotor {models}/one_row.csv",
        "learn crazyflie --data {models}/one_row.csv --out X",
    ],
)
def test_a_log_of_one_row_is_refused_by_its_file(
    command: str, models: Path, refused: Refused, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert "one_row.csv: expected" in refused(command.format(models=models))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "command",
    [
        "diagnose {models}/quadrotor {models}/flight.csv {models}/../{folder}/flight.csv",
        "diagnose {models}/quadrotor {models}/flight.csv --held-out copy.csv",
        "add {models}/quadrotor wind --fit {models}/flight.csv --held-out {models}/flight.csv --out X",
        "compare {models}/quadrotor copy.csv {models}/flight.csv",
    ],
)
def test_a_log_that_is_given_twice_is_refused(
    command: str, models: Path, refused: Refused, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(models / "flight.csv", tmp_path / "copy.csv")
    error = refused(command.format(models=models, folder=models.name))
    assert "expected every log once" in error
    assert error.endswith(".csv again")


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("add {models}/quadrotor wind fx=0.1 fx=0.2 --out {models}/new", "expected fx once, found fx=0.1 and fx=0.2"),
        (
            "add {models}/quadrotor wind fx=0.1 wind fy=0.2 --out {models}/new",
            "wind: expected once with all its values behind it, found 2 times",
        ),
        ("plan crazyflie circle speed=30 --seconds 2", "circle: the simulated Crazyflie 2.1 crashed after"),
        ("plan {models}/car {models}/car_log.csv", "expected columns of the model"),
        ("plan {models}/quadrotor fligth.csv", "fligth.csv: expected a file"),
        ("diagnose {models}/quadrotor {models}/flight.csv --horizon 0.001", "at least one time step, 0.02 s"),
    ],
)
def test_what_cannot_be_put_in_planned_or_scored(command: str, message: str, models: Path, refused: Refused) -> None:
    (models / "car_log.csv").write_text("t,x,y\n0.0,1,2\n0.1,1,2\n0.2,1,3\n")
    assert message in refused(command.format(models=models))
    assert not (models / "new").exists()


def test_logs_are_planned_with_the_equations_of_the_robot_that_is_named(
    models: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = []
    monkeypatch.setattr(diagnosis, "plan", lambda equations, *_, **__: given.append(equations) or EMPTY)
    main(["plan", "crazyflie", str(models / "flight.csv")])
    assert given[0].robot == "crazyflie"


def test_the_command_of_a_proposed_term_is_one_line_of_a_shell() -> None:
    command = term_command(Term("fz", "0.0123*vx*vx - 0.0456*vy*vy + 0.0789*vz*vx", 0.1), "my runs/base")
    words = shlex.split(command)
    assert words[:3] == ["sym2real", "add", "my runs/base"]
    assert words[3] == "term:fz=0.0123*vx*vx - 0.0456*vy*vy + 0.0789*vz*vx"


def test_ctrl_c_while_an_error_is_told_ends_as_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[str] = []

    def say(text: str) -> None:
        told.append(text)
        if len(told) == 1:
            raise KeyboardInterrupt

    monkeypatch.setattr("sym2real.cli.terminal.say_error", say)
    with pytest.raises(SystemExit) as ended:
        main(["no-such-verb"])
    assert ended.value.code == 130
    assert told[1] == "interrupted: files that were already written stay"
