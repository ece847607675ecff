"""What a diagnosis leaves in its folder, and what goes when another one takes its place."""

import io
import json
import signal
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from rich.console import Console
from standard_set import Case, simulate_case

from sym2real.cli.results import write_diagnosis
from sym2real.dataset import Dataset
from sym2real.diagnosis import Diagnosis, diagnose
from sym2real.diagnosis.errors.rungs import Rung, RungError
from sym2real.diagnosis.score.finding import Finding
from sym2real.diagnosis.score.held_out import Gate
from sym2real.diagnosis.search.intervals import Estimate
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic import load_model

HEAVIER = Finding("added_mass", {"value": Estimate(0.004, 0.0039, 0.0041, "kg")}, share=1.0)
FOUND = Diagnosis("EFFECT", "Missing: added_mass.", findings=(HEAVIER,))
NOTHING = Diagnosis("NOTHING_MISSING", "Nothing is missing.")
# Everything but what a mass looks like, to keep the search short.
EXCLUDED = (
    *("limit:*", "delay*", "lag*", "rate_limit*", "dead_band*", "offset:w*", "gain:w*", "sensor*", "time_shift*"),
    *("motor_lag", "rotor*", "rate*", "flapping_moment", "translational_lift", "thrust_curve", "periodic_force"),
    *("mounting_tilt", "wind", "*_drag", "torque_bias", "com_offset", "ground_effect", "battery_sag"),
)


@pytest.fixture(autouse=True)
def _interrupts() -> Iterator[None]:
    """Ctrl-C as Python has it: a shell that starts the tests in the background has it ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="module")
def logs() -> Dataset:
    return Dataset(simulate_case(Case("crazyflie", (("added_mass", {"value": 0.004}),), seed=1), 3, 350))


def written(found: Diagnosis, logs: Dataset, out: Path) -> str:
    console = Console(file=io.StringIO(), width=300)
    result, _ = write_diagnosis(CRAZYFLIE.nominal(), logs, found, out, console)
    assert json.loads((out / "diagnosis.json").read_text())["files"] == result["files"]
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


def files_in(out: Path) -> set[str]:
    return {file.relative_to(out).as_posix() for file in out.rglob("*") if file.is_file()}


@pytest.mark.slow
def test_the_next_diagnosis_removes_what_the_last_one_wrote_and_nothing_else(logs: Dataset, tmp_path: Path) -> None:
    written(FOUND, logs, tmp_path)
    assert {"model/equations.json", "simulator/plant.toml", "report.html"} <= files_in(tmp_path)
    own = {"simulator/mine.txt", "mine.html"}
    for name in own:
        (tmp_path / name).write_text("mine")
    short = Dataset([replace(logs[0], name="another")])
    written(NOTHING, short, tmp_path)
    assert files_in(tmp_path) == {"diagnosis.json", "report.html", *own}
    assert not (tmp_path / "model").exists()


def test_a_list_of_files_elsewhere_is_not_heeded(logs: Dataset, tmp_path: Path) -> None:
    (tmp_path / "elsewhere.txt").write_text("mine")
    out = tmp_path / "out"
    out.mkdir()
    (out / "diagnosis.json").write_text(json.dumps({"files": ["../elsewhere.txt", str(tmp_path / "elsewhere.txt"), 3]}))
    written(NOTHING, Dataset([logs[0]]), out)
    assert (tmp_path / "elsewhere.txt").exists()


def test_what_predictions_do_not_bear_out_is_not_written(logs: Dataset, tmp_path: Path) -> None:
    error = RungError(0.1, 0.1, 0.09, 0.11, "m")
    stage = Rung("base", {0.8: {"position": error}})
    failed = replace(FOUND, verdict="CANNOT_TELL", gate=Gate(stage, stage))
    assert "no model or simulator was written" in written(failed, Dataset([logs[0]]), tmp_path)
    assert not {file for file in files_in(tmp_path) if file.startswith(("model", "simulator"))}


def test_an_interrupted_drawing_leaves_the_answer_and_the_model(
    logs: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sym2real.report.html.pages.diagnosis_page", lambda *_: signal.raise_signal(signal.SIGINT))
    assert "interrupted" in written(FOUND, logs, tmp_path)
    assert load_model(tmp_path / "model").effects[0][0] == "added_mass"


def interrupted_while(stage: str, logs: Dataset) -> Diagnosis:
    """A diagnosis to which Ctrl-C is sent when a stage begins."""

    def on_progress(what: str) -> None:
        if what.startswith(stage):
            signal.raise_signal(signal.SIGINT)

    base = CRAZYFLIE.nominal()
    return diagnose(base, logs, exclude=EXCLUDED, horizon=0.5, on_progress=on_progress, finish_on_interrupt=True)


@pytest.mark.slow
@pytest.mark.parametrize("stage", ["scoring", "explaining", "looking", "locating"])
def test_a_finished_search_is_kept_whatever_is_interrupted_behind_it(stage: str, logs: Dataset) -> None:
    found = interrupted_while(stage, logs)
    assert found.findings[0].effect == "added_mass"
    assert found.findings[0].values["value"] == pytest.approx(0.004, rel=0.1)
    assert any(note.startswith(f"interrupted while {stage}") for note in found.notes)
    assert found.established == (stage not in ("scoring", "explaining"))
    assert ("the scoring was interrupted" in found.summary) == (stage in ("scoring", "explaining"))


def test_a_search_that_was_interrupted_before_it_found_anything_cannot_tell(logs: Dataset) -> None:
    found = interrupted_while("searching", logs)
    assert (found.verdict, found.findings) == ("CANNOT_TELL", ())
    assert "the search was interrupted before it ended" in found.summary.lower()
    assert "too little data" not in found.summary
