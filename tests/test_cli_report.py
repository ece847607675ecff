"""The verbs that write a page."""

import re
from pathlib import Path

import pytest
from cli_results import result_of
from report_pages import BASE, logs

from sym2real.logs import write_log
from sym2real.symbolic import save_model

ASKED = ("How good is the model?", "Where does it fail?", "What remains?")


def questions(page: Path) -> list[str]:
    return re.findall(r"<h2[^>]*>(.*?)</h2>", page.read_text(encoding="utf-8"))


@pytest.fixture
def flown(tmp_path: Path) -> tuple[Path, Path]:
    """A model folder and a log."""
    write_log(logs()[0], tmp_path / "flight.csv")
    return save_model(BASE, tmp_path / "base"), tmp_path / "flight.csv"


def test_compare_writes_a_page(flown: tuple[Path, Path], tmp_path: Path) -> None:
    model, log = flown
    result = result_of(["compare", str(model), str(log), "--report", str(tmp_path / "page.html")], tmp_path)
    assert result["report"] == str(tmp_path / "page.html")
    assert questions(tmp_path / "page.html") == list(ASKED)


def test_adapt_writes_a_page_of_recorded_flights(
    flown: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "flights"
    folder.mkdir()
    for place, log in enumerate(logs()):
        write_log(log, folder / f"{place}.csv")
    adapting = ["adapt", str(flown[0]), str(folder), "--learner", "fine-tune", "--rounds", "1"]
    out = tmp_path / "adapted"
    result = result_of([*adapting, "--out", str(out), "--report", str(out / "page.html")], tmp_path)
    assert questions(out / "page.html") == ["How good is the model?", "Where does it fail?",
                                            "What happens when it is added?", "What remains?"]  # fmt: skip
    assert result["best"] == 1
