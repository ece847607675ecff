"""Fixtures that several test files share."""

import gc
import os
import sys
import zlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pytest
import torch
from cli_results import Refused

from sym2real.cli import main

os.environ.setdefault("SYM2REAL_TRACEBACK", "1")  # an error that nobody foresaw is to fail a test with its traceback
sys.path.append(str(Path(__file__).resolve().parents[1] / "tools" / "bench"))  # what tests and benches share
# Files that take half a minute or more, or minutes with their slow tests.
LONG = {
    *("test_hardware_crazyflie", "test_diagnosis_near", "test_diagnosis_sanity", "test_text_never_runs"),
    *("test_site", "test_level_ground", "test_experiments_study", "test_cli_found", "test_adaptation_loop"),
    *("test_diagnosis_slow_logs", "test_diagnosis_units", "test_robots_from_mjcf", "test_diagnosis_mistakes"),
    *("test_robots_arm", "test_robots_differential_drive", "test_robots_hexarotor", "test_hostile", "test_real_logs"),
    *("test_diagnosis_chain", "test_cli_streams"),
}
BESIDE_THE_CHECKOUT = Path(__file__).resolve().parents[2] / "shared" / "data"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The long files first, so that no worker is left alone with one; the others shuffled by their names.

    Of those that wait for robots, few are then run at the same time.
    """
    items.sort(key=lambda item: (item.path.stem not in LONG, zlib.crc32(item.path.name.encode())))


def pytest_collection_finish() -> None:
    """Libraries leave a million objects; to look through them for garbage, over and over, takes a 20th of the time."""
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder with the four measured sets: ``SYM2REAL_DATA``, else ``../shared/data`` beside the checkout."""
    folder = Path(os.environ.get("SYM2REAL_DATA", BESIDE_THE_CHECKOUT))
    if not folder.is_dir():
        pytest.skip(f"the measured sets are not here ({folder}); set SYM2REAL_DATA to their folder")
    return folder


@pytest.fixture
def set_threads() -> Iterator[Callable[[int], None]]:
    """Sets torch's threads for one test: another that forks would wait for those that its child does not have."""
    before = torch.get_num_threads()
    yield torch.set_num_threads
    torch.set_num_threads(before)


@pytest.fixture
def refused(capsys: pytest.CaptureFixture[str]) -> Refused:
    """Types a command that is refused, and gives the one error that it ends with on standard error, on one line."""

    def said(command: str | Sequence[str]) -> str:
        capsys.readouterr()
        with pytest.raises(SystemExit) as stopped:
            main(command.split() if isinstance(command, str) else command)
        assert stopped.value.code == 2
        progress, begins, error = capsys.readouterr().err.partition("error: ")
        assert "error:" not in progress + error
        assert 1 <= error.count("\n") <= 3
        return " ".join((begins + error).split())

    return said
