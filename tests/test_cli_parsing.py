"""Help that fits the terminal and keeps its paragraphs, numbers that cannot be read, the version."""

import subprocess
import sys

import pytest
from cli_results import Refused

import sym2real
from sym2real.cli import VERBS, main, numbers
from sym2real.robots import robot


@pytest.fixture(autouse=True)
def terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")


def help_of(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit) as stopped:
        main([*arguments, "--help"])
    assert stopped.value.code == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    return printed.out


@pytest.mark.parametrize("verb", ["", *VERBS, "nominal quadrotor", "nominal car"])
def test_a_help_fits_the_terminal_and_names_what_has_no_option(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    said = help_of(verb.split(), capsys)
    assert len(said) > 300
    assert max(len(line) for line in said.splitlines()) <= 80
    if verb:
        assert said.startswith("usage:")
        assert "STR" not in said.split("\n\n")[0].split()


def test_paragraphs_and_examples_of_a_help_stay(capsys: pytest.CaptureFixture[str]) -> None:
    general = help_of([], capsys)
    assert "\n      fly them with MPPI\n\nFrom a model and your logs to what is missing:\n" in general
    assert "sym2real --version" in general
    assert len(general.splitlines()) < 90  # two screens: what a verb does is in its own help
    example = help_of(["nominal", "quadrotor"], capsys).partition("For example:\n")[2]
    assert example.startswith("  sym2real nominal quadrotor --mass 1.2 --interface motors --out runs/nominal\n")


def test_a_reader_that_stops_gets_no_traceback() -> None:
    command = [sys.executable, "-m", "sym2real", "add", "--help"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        assert running.stdout is not None
        assert running.stderr is not None
        running.stdout.close()
        assert running.stderr.read() == b""
    assert running.returncode == 0


def test_diagnose_says_when_an_interrupt_leaves_an_answer(capsys: pytest.CaptureFixture[str]) -> None:
    said = " ".join(help_of(["diagnose"], capsys).split())
    assert "Once the progress line says that it searches, Ctrl-C ends what is being done there" in said
    assert "and keeps what is done; earlier it ends without an answer" in said


def test_the_version_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    main(["--version"])
    assert capsys.readouterr().out == f"sym2real {sym2real.__version__}\n"


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("diagnose model log.csv --horizon abc", "--horizon: expected a number greater than 0, found"),
        ("diagnose model log.csv --horizon 0", "--horizon: expected a number greater than 0, found '0'"),
        ("add model wind --fit log.csv --out new --horizon inf", "--horizon"),
        ("learn crazyflie --out model --steps 4.5", "greater than 0 and at most 1000000, found '4.5'"),
        ("learn crazyflie --out model --episodes 0", "--episodes: expected a whole number"),
        ("simulate crazyflie hover --out log.csv --seconds -1", "--seconds: expected a number great"),
        ("run model hover --seconds inf", "--seconds: expected a number greater than 0 and at most 86400"),
        ("run model hover --samples 100000000000", "--samples: expected a whole number greater than 0"),
        ("run mushr circle --samples 0", "--samples: expected a whole number greater than 0"),
        ("run model hover --seed -1", "--seed: expected a whole number from 0"),
        ("plan crazyflie hover --seconds inf", "found 'inf'"),
        ("plan crazyflie hover --yaw-rate nan", "--yaw-rate: expected a number, found 'nan'"),
        ("plan mushr circle --dither -1", "--dither: expected a number that is not negative, found '-1'"),
        ("nominal car --wheelbase inf --out model", "--wheelbase: expected a number greater than 0"),
        ("nominal quadrotor --mass -1 --out model", "--mass: expected a number greater than 0"),
        ("nominal quadrotor --inertia 1 nan 1 --out model", "--inertia: expected a number great"),
    ],
)
def test_a_number_that_cannot_be_read(
    command: str, message: str, refused: Refused, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    said = refused(command)
    assert message in said
    assert "class" not in said


def test_the_most_samples_are_those_of_mppi() -> None:
    """Said twice, because the help must not wait for the controller's libraries."""
    assert numbers.MOST_SAMPLES == robot.MOST_SAMPLES
