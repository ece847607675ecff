"""Confidence is what was counted: of the finding's own kind, never certain, and none where counting does not apply."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import pytest

from sym2real.diagnosis import Finding
from sym2real.diagnosis.score.finding import rated
from sym2real.diagnosis.score.reliability import Confidence, counts, kind

FLAGS = (True, False)
FOUND = (Finding("wind", {}, 0.7), Finding("delay", {}, 0.2))


def test_the_counts_are_of_kinds_that_findings_have() -> None:
    known = {kind(passed=a, leftover=b, first=c) for a, b, c in product(FLAGS, FLAGS, FLAGS)}
    assert counts() and set(counts()) <= known
    assert all(0 <= one.right <= one.of and one.of > 0 for one in counts().values())


def test_few_cases_make_nothing_certain() -> None:
    assert Confidence(1, 1).value == pytest.approx(0.75)
    assert Confidence(0, 1).value == pytest.approx(0.25)
    assert 0.98 < Confidence(100, 100).value < 1.0


def test_findings_have_the_confidence_of_their_kind() -> None:
    first, further = rated(FOUND, passed=True, leftover=False, calibrated=True)
    assert first.confidence == counts()[kind(passed=True, leftover=False, first=True)]
    assert further.confidence == counts()[kind(passed=True, leftover=False, first=False)]
    assert first.confidence is not None
    assert first.to_dict()["confidence"] == {"value": first.confidence.value, "cases": first.confidence.of}
    doubted, _ = rated(FOUND, passed=False, leftover=False, calibrated=True)
    assert doubted.confidence is not None and doubted.confidence.value < first.confidence.value


def test_nobody_has_counted_findings_without_calibration_or_from_too_little_data() -> None:
    assert all(one.confidence is None for one in rated(FOUND, passed=True, leftover=False, calibrated=False))
    provisional = [replace(one, provisional=True) for one in FOUND]
    assert all(one.confidence is None for one in rated(provisional, passed=True, leftover=False, calibrated=True))
