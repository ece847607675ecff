"""What the command line refuses: logs, numbers and models that cannot mean anything, each in one error by name."""

from __future__ import annotations

import shutil
import warnings
from pathlib import Path

import pytest

from sym2real.cli import main
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.symbolic import save_model


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


def said(command: str, capsys: pytest.CaptureFixture[str]) -> str:
    """The one error of a command that is refused."""
    capsys.readouterr()
    with warnings.catch_warnings(), pytest.raises(SystemExit) as stopped:
        warnings.simplefilter("error")
        main(command.split())
    assert stopped.value.code == 2
    printed = capsys.readouterr()
    return " ".join((printed.out + printed.err).split())


@pytest.mark.parametrize(
    "command",
    [
        "diagnose {models}/quadrotor {models}/one_row.csv",
        "diagnose {models}/quadrotor {models}/flight.csv --held-out {models}/one_row.csv",
        "diagnose {models}/quadrotor {models}/flight.csv {models}/one_row.csv",
        "add {models}/quadrotor wind --fit {models}/one_row.csv --out X",
        "compare {models}/quadrotor {models}/one_row.csv",
        "plan {models}/one_row.csv --model {models}/quadrotor",
        "learn crazyflie --data {models}/one_row.csv --out X",
    ],
)
def test_a_log_of_one_row_is_refused_by_its_file(
    command: str, models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert "one_row.csv: expected" in said(command.format(models=models), capsys)
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
    command: str, models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(models / "flight.csv", tmp_path / "copy.csv")
    error = said(command.format(models=models, folder=models.name), capsys)
    assert "expected every log once" in error
    assert error.endswith(".csv again")


def test_a_value_that_is_given_twice_is_refused(models: Path, capsys: pytest.CaptureFixture[str]) -> None:
    error = said(f"add {models}/quadrotor wind fx=0.1 fx=0.2 --out {models}/windy", capsys)
    assert "wind: expected fx once, found fx=0.1 and fx=0.2" in error
    assert not (models / "windy").exists()
