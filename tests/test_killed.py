"""Ctrl-C, a killed process, two writers: files are whole or not there, and what goes on ends as if nothing had been."""

from __future__ import annotations

import os
import re
import signal
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from forked import forked, in_fork, started
from quick_engines import Given

from sym2real.cli import main
from sym2real.experiments import learning
from sym2real.regression import ENGINES
from sym2real.report import tables
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.symbolic import save_model

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="processes are ended by POSIX signals")

LEARN = ("learn", "mushr", "--out", "model", "--episodes", "2", "--steps", "60", "--samples", "32", "--no-wrench")
ENDED = {0, 2}  # 2: so short a drive makes a model that cannot drive, which is saved and said
LOADED = (learning, tables)  # here, once for all the forks
FILES_BETWEEN = 3  # that a run may write until it is ended
MADE, WRITTEN = "os.mkdir", "os.rename"  # a folder beside a file's place, and the file moved to it
PLACES = {MADE: 0, WRITTEN: 1}  # which argument the new place is


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return save_model(CRAZYFLIE.nominal(), tmp_path_factory.mktemp("models") / "quadrotor")


@pytest.fixture(scope="module", autouse=True)
def _nothing_is_searched() -> Iterator[None]:
    """Forks have what this process has: it is files that are written and read again, whatever the search finds."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(ENGINES._entries, "beam", Given(MUSHR.nominal()))
        yield


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Files of a run of ``learn`` that nothing disturbed."""
    folder = tmp_path_factory.mktemp("learned")
    assert forked(LEARN, folder).status in ENDED
    return whole_files(folder)


def whole_files(folder: Path) -> dict[str, bytes]:
    """What lies in a folder under names that are looked for, but for the seconds that a fit took.

    A killed process may leave `.writing-…` beside them, and a folder of that name may go while a writer is at work.
    """
    found: dict[str, bytes] = {}
    for place, folders, files in os.walk(folder):
        folders[:] = [name for name in folders if not name.startswith(".writing-")]
        for name in files:
            if not name.startswith(".writing-"):
                file = Path(place, name)
                found[str(file.relative_to(folder))] = re.sub(rb'"seconds": [-+.e\d]+', b"", file.read_bytes())
    return found


def run_until(number: signal.Signals, event: str, count: int, arguments: Sequence[str], folder: Path) -> int:
    """Run the command line, have it send itself a signal just before it makes its so-manieth place; how it ended.

    Args:
        number: the signal.
        event: Python's name for how it makes one, of its audit events.
        count: of places in the folder that were not there.
        arguments: what is typed after the program's name.
        folder: where it runs.
    """
    left = [count]

    def hear(name: str, called: tuple[object, ...]) -> None:
        if name != event:
            return
        place = Path(str(called[PLACES[event]])).absolute()
        left[0] -= place.is_relative_to(folder) and not place.exists()
        if left[0] == 0:
            os.kill(os.getpid(), number)

    def work() -> None:
        sys.addaudithook(hear)
        main(arguments)

    return in_fork(work, folder).status


@pytest.mark.parametrize(("number", "status"), [(signal.SIGKILL, -signal.SIGKILL), (signal.SIGINT, 130)])
def test_learning_that_is_ended_again_and_again_goes_on_to_the_same_bytes(
    number: signal.Signals, status: int, learned: dict[str, bytes], tmp_path: Path
) -> None:
    assert "model/equations.json" in learned
    ends = []
    while not ENDED.intersection(ends):
        kept = whole_files(tmp_path)
        ends.append(run_until(number, WRITTEN, FILES_BETWEEN + 1, LEARN, tmp_path))
        files = whole_files(tmp_path)
        assert files.items() >= kept.items()
        assert all(learned[name] == content for name, content in files.items())
    assert set(ends) <= {status, *ENDED}
    assert ends.count(status) >= 2
    assert whole_files(tmp_path) == learned


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_a_run_that_is_ended_while_it_writes_leaves_whole_files_or_none(
    number: signal.Signals, model: Path, tmp_path: Path
) -> None:
    commands = (
        ["add", str(model), "wind", "fx=0.01", "--out", "new"],
        ["export", str(model), "torchscript", "--out", "new/model.pt"],
    )
    for one, arguments in enumerate(commands):
        whole = tmp_path / f"whole {one}"
        whole.mkdir()
        assert forked(arguments, whole).status == 0
        for event in PLACES:
            ended = tmp_path / f"ended {one} {event}"
            ended.mkdir()
            status = run_until(number, event, one + 1, arguments, ended)
            assert status == (130 if number == signal.SIGINT else -number)
            assert whole_files(ended).keys() <= whole_files(whole).keys()
            assert all(len(content) == len(whole_files(whole)[name]) for name, content in whole_files(ended).items())
            assert number == signal.SIGKILL or not list(ended.rglob(".writing-*"))


def test_ctrl_c_is_one_line_on_standard_error_and_keeps_the_last_diagnosis(model: Path, tmp_path: Path) -> None:
    main(["simulate", "crazyflie", "circle", "--noise", "--seconds", "4", "--out", str(tmp_path / "flight.csv")])
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "diagnosis.json").write_text('{"files": []}')
    before = whole_files(tmp_path)

    def hear(name: str, called: tuple[object, ...]) -> None:
        if name == "open" and str(called[0]).endswith("flight.csv"):
            os.kill(os.getpid(), signal.SIGINT)

    def interrupted() -> None:
        sys.addaudithook(hear)
        main(["diagnose", str(model), "flight.csv", "--out", "out"])

    done = in_fork(interrupted, tmp_path)
    assert (done.status, done.out) == (130, "")
    assert done.err.splitlines()[-1] == "interrupted: files that were already written stay"
    assert whole_files(tmp_path) == before


def test_two_writers_of_one_folder_leave_one_model_or_one_that_is_refused(model: Path, tmp_path: Path) -> None:
    commands = [["add", str(model), "wind", f"fx={value}", "--out", "new"] for value in ("0.01", "0.02")]
    ends = both(commands, tmp_path)
    assert 0 in ends
    assert set(ends) <= {0, 2}  # a folder that already holds the other's model is refused
    shown = forked(["show", "new"], tmp_path)
    assert shown.status == 0 or "save the model again" in shown.err
    assert not list(tmp_path.rglob(".writing-*"))


def test_two_that_learn_in_one_folder_leave_the_model_of_one(learned: dict[str, bytes], tmp_path: Path) -> None:
    assert set(both([LEARN, LEARN], tmp_path)) <= ENDED
    assert whole_files(tmp_path) == learned


def both(commands: Sequence[Sequence[str]], folder: Path) -> list[int]:
    """How two runs that begin together end."""
    processes = [started(lambda one=one: main(one), folder) for one in commands]  # type: ignore[misc]
    return [os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]) for process in processes]
