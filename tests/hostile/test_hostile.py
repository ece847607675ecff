"""Damaged inputs: each gets its answer, an answer that names the damage, or one clear error."""

import sys
from collections import Counter
from pathlib import Path

import pytest
from forked import Ran
from hostile_case import KINDS, Case
from hostile_run import CLEAN, ENDS, FAILED, NAMED, SAME, Outcome, contents, judged, run_all, table

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="every case is a fork of one process")

CASES, SEED, JOBS = 256, 0, 1  # the other workers have other tests


@pytest.fixture(scope="module")
def outcomes() -> list[Outcome]:
    return list(run_all(range(CASES), SEED, JOBS))


@pytest.mark.slow
def test_every_damaged_input_has_an_answer_or_a_clear_error(outcomes: list[Outcome]) -> None:
    failures = [f"case {one.number}, {one.kind}: {one.why}" for one in outcomes if one.end == FAILED]
    assert not failures, "\n".join(failures)
    assert sorted(one.number for one in outcomes) == list(range(CASES))


@pytest.mark.slow
def test_every_kind_and_every_end_is_there(outcomes: list[Outcome]) -> None:
    assert Counter(one.kind for one in outcomes).keys() == KINDS.keys()
    assert min(Counter(one.kind for one in outcomes).values()) >= CASES // len(KINDS)
    ends = Counter(one.end for one in outcomes)
    assert min(ends[end] for end in (SAME, NAMED, CLEAN)) >= CASES // 25
    assert table(outcomes).splitlines()[-1] == f"| all | {CASES} | {' | '.join(str(ends[end]) for end in ENDS)} |"


@pytest.mark.parametrize(
    ("status", "err", "end"),
    [
        (2, "error: log.csv, row 3: expected a number, found 'x'\n", CLEAN),
        (2, "error: log.csv, row 4: expected a number, found 'x'\n", FAILED),  # another place
        (2, "error: other, row 3: expected a number, found 'x'\n", FAILED),
        (2, "error: log.csv, row 3 is bad\n", FAILED),
        (2, "error: log.csv, row 3: expected a number, found 'x'\n\n\n\n", FAILED),
        (2, "Traceback\nerror: log.csv, row 3: expected a number, found 'x'\n", FAILED),
        (70, "error: log.csv, row 3: expected a number, found 'x'\n", FAILED),
        (-14, "", FAILED),
    ],
)
def test_what_is_judged_to_be_a_clear_error(status: int, err: str, end: str, tmp_path: Path) -> None:
    case = Case(("inspect", "log.csv"), (r"log\.csv", r"row 3\b"), reads="log")
    assert judged(case, Ran(status, "", err), tmp_path, {})[0] == end


@pytest.mark.parametrize(
    ("result", "end"),
    [
        ('{"a": 1, "note": "of x.csv"}', SAME),
        ('{"a": 1, "note": "of y.csv"}', FAILED),
        ('{"a": 2, "note": "of x.csv"}', FAILED),
        ('{"a": 2, "note": "row 3 left out"}', NAMED),
        ('{"a": 2, "note": "row 4 left out"}', FAILED),
    ],
)
def test_what_is_judged_to_be_an_answer(result: str, end: str, tmp_path: Path) -> None:
    (tmp_path / "result.json").write_text(result)
    case = Case(("inspect", "log.csv"), ("log",), told="row 3 left out", reads="log")
    undamaged = {"log": {"a": 1, "note": "of x.csv"}}
    assert judged(case, Ran(0, "", ""), tmp_path, undamaged)[0] == end
    assert judged(Case((), ()), Ran(0, "", ""), tmp_path, {})[0] == FAILED


def test_words_that_an_undamaged_answer_has_name_no_damage(tmp_path: Path) -> None:
    (tmp_path / "result.json").write_text('["row 3 left out", 2]')
    case = Case(("inspect", "log.csv"), ("log",), told="row 3 left out", reads="log")
    assert judged(case, Ran(0, "", ""), tmp_path, {"log": ["row 3 left out", 1]})[0] == FAILED


def test_another_name_may_be_in_the_answer_but_no_other_number(tmp_path: Path) -> None:
    (tmp_path / "result.json").write_text('{"a": 1.5e-3, "note": "ψ: 20 ms"}')
    case = Case(("inspect", "ψ.csv"), (), reads="log", renamed=True)
    for note, end in (("log: 20 ms", SAME), ("log: 40 ms", FAILED)):
        assert judged(case, Ran(0, "", ""), tmp_path, {"log": {"a": 1.5e-3, "note": note}})[0] == end
    assert judged(case, Ran(2, "", "error: ψ.csv: expected a file, found none"), tmp_path, {})[0] == FAILED


def test_contents_see_what_changes(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("a")
    (tmp_path / "link").symlink_to("file")
    before = contents(tmp_path)
    (tmp_path / "link").unlink()
    (tmp_path / "link").write_text("a")
    assert contents(tmp_path)["file"] == before["file"]
    assert contents(tmp_path)["link"] != before["link"]
