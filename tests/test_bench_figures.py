"""What a benchmark writes: its figures with their bars, as numbers that any program reads."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from figures import Figure, report


@pytest.mark.parametrize(
    ("value", "bar", "holds"),
    [(1.0, "<= 1.0", True), (1.0, "< 1.0", False), (0.9, ">= 1", False), (0.5, "0.3 to 0.5", True), (2.0, "", None)],
)
def test_a_bar_is_held_or_missed(value: float, bar: str, holds: bool | None) -> None:
    assert Figure("one", np.float64(value), "m", bar).holds is holds


def test_figures_are_written_whatever_numbers_they_are(tmp_path: Path) -> None:
    file = tmp_path / "new" / "figures.json"
    report("some", [Figure("one", np.float32(0.5), "m", "< 1"), Figure("two", 3, "pairs")], [7], file)
    written = json.loads(file.read_text())
    assert [(row["name"], row["value"], row["holds"]) for row in written["figures"]] == [
        ("one", 0.5, True),
        ("two", 3.0, None),
    ]
    assert written["seeds"] == [7]
