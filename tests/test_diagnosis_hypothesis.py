"""The sentence about a hypothesis says what its numbers say, at every border between two answers."""

from __future__ import annotations

from dataclasses import replace

import pytest

from sym2real.diagnosis.faults.fault import Fault
from sym2real.diagnosis.score.finding import Finding
from sym2real.diagnosis.score.hypothesis_test import Alternative, HypothesisTest
from sym2real.diagnosis.settings import SETTINGS

WIND, DRAG = Finding("wind", {}, 1.0), Finding("drag", {}, 0.5)
ASKED = HypothesisTest(
    findings=(WIND,), supported=True, gain=0.123, beside={"wind": 0.123}, refused=(), unneeded=(), outdone=(),
    rivals=(), faults=(), ladder=(), floor=(), held_out=(), apart=False, notes=(), seconds=1.0,
)  # fmt: skip
BOTH = replace(ASKED, findings=(WIND, DRAG), beside={"wind": 0.1, "drag": 0.02})
MANY = ("wind", "a", "b", "c", "d")


def rival(name: str, gain: float, instead_of: str = "wind", *, better: bool = False) -> Alternative:
    return Alternative(name, gain, as_good=False, instead_of=instead_of, better=better)


@pytest.mark.parametrize(
    ("tried", "others"),
    [
        (ASKED, "no other effect does as well"),
        (replace(ASKED, findings=(replace(WIND, group=MANY),)), "a or b or c does as well"),
        (
            replace(ASKED, findings=(replace(WIND, doubtful=True),)),
            "commands that change between the rows of the logs do as well",
        ),
        (BOTH, "no other effect does as well as one of them"),
        (replace(BOTH, findings=(replace(WIND, group=MANY), DRAG)), "a or b or c does as well as wind"),
        (replace(BOTH, findings=(WIND, replace(DRAG, group=("drag", "lag")))), "lag does as well as drag"),
    ],
)
def test_what_the_logs_ask_for_is_said_with_what_does_as_well(tried: HypothesisTest, others: str) -> None:
    lowered = "wind: it lowers" if len(tried.findings) == 1 else "wind and drag: together they lower"
    assert tried.summary == f"The logs ask for {lowered} the held-out loss by 12.3 %; {others}."


@pytest.mark.parametrize("count", [1, 2])
def test_what_is_refused_has_too_little_or_too_few_pieces_for_all_it_has(count: int) -> None:
    """One alone must save half of what one of several must; what predictions do not need is not asked for its gain."""
    least = SETTINGS.gain_of(count)
    tried = replace((ASKED, BOTH)[count - 1], supported=False, refused=("wind",))
    more = replace(tried, beside={**tried.beside, "wind": 1.001 * least})
    assert "The logs do not establish wind" in more.summary
    assert "too few independent pieces" in more.summary
    exact = replace(tried, beside={**tried.beside, "wind": least})
    assert exact.summary.startswith("The logs do not ask for wind")
    assert f"; up to {100 * least:.3g} % is needed" in exact.summary
    left = f"; wind lowers what the others leave by {100 * least:.3g} %"
    assert exact.summary.endswith(f"{left if count == 2 else ''}.")


def test_what_predictions_do_not_need_is_said_where_nothing_else_speaks_against_it() -> None:
    unneeded = replace(BOTH, supported=False, refused=("drag", "wind"), unneeded=("wind", "drag"))
    assert unneeded.summary.startswith("The logs show wind and drag: together they lower the held-out loss by 12.3 %")
    assert "but predictions do not need wind or drag, and whole logs do not establish it." in unneeded.summary
    one = replace(unneeded, unneeded=("drag",))
    assert one.summary.startswith("The logs do not establish wind")  # a tenth is no matter of gain
    small = replace(one, beside={"wind": 0.001, "drag": 0.02})
    assert small.summary.startswith("The logs do not ask for wind")


@pytest.mark.parametrize(
    ("other", "said"),
    [
        (rival("lag", 0.123 + 0.9 * SETTINGS.gain), False),
        (rival("lag", 0.123 + 1.1 * SETTINGS.gain), True),
        (rival("alike", 0.123 + 1.1 * SETTINGS.gain), False),
        (rival("lag", 0.1, better=True), True),
        (rival("alike", 0.1, better=True), True),
    ],
)
def test_another_effect_is_better_beyond_what_an_effect_must_gain_or_where_that_is_sure(
    other: Alternative, *, said: bool
) -> None:
    tried = replace(ASKED, findings=(replace(WIND, group=("wind", "alike")),), rivals=(other,))
    both = "; only a fit of both says how much of each there is" if other.better else ""
    expected = f"; {other.effect} in its place lowers it by {100 * other.gain:.3g} %{both}."
    assert tried.summary.endswith(expected if said else "; alike does as well.")


def test_another_effect_is_better_only_where_somebody_says_so() -> None:
    assert not Alternative("lag", 0.1, as_good=True, instead_of="wind").better


def test_what_is_outdone_comes_first_and_is_said_so() -> None:
    rivals = (rival("lag", 0.9, better=True), rival("sag", 0.3, "drag", better=True))
    both = "; only a fit of both says how much of each there is."
    assert replace(BOTH, rivals=rivals).summary.endswith("; lag in the place of wind lowers it by 90 %" + both)
    outdone = replace(BOTH, rivals=rivals, outdone=("drag",), supported=False, refused=("drag",))
    assert outdone.summary == (
        "The logs do not ask for wind and drag: together they lower the held-out loss by 12.3 %"
        "; sag in the place of drag lowers it by 30 %, and leaves too little for it."
    )


def test_a_fault_of_the_logs_that_is_undone_before_the_fit_is_no_silent_refusal() -> None:
    """A biased gyro's bias was NOT SUPPORTED, and nothing said that it had been taken off."""
    fault = Fault("wind", "the logged wx is off", value=0.0397)
    refused = replace(ASKED, supported=False, refused=("wind",), faults=(fault,))
    assert ", once the fault of the logs is undone (wind (0.0397)), but" in refused.summary
    assert "undone" not in replace(refused, faults=(replace(fault, effect="drag"),)).summary
    assert "undone" not in replace(ASKED, faults=(fault,)).summary


def test_the_written_answer_has_its_only_finding_twice_and_not_whether_logs_were_kept_apart() -> None:
    written, several = ASKED.to_dict(), BOTH.to_dict()
    assert written["finding"] == WIND.to_dict() == written["findings"][0]
    assert written["summary"] == ASKED.summary
    assert "finding" not in several
    assert [one["effect"] for one in several["findings"]] == ["wind", "drag"]
    assert "apart" not in {*written, *several}
    assert ASKED.summary in repr(ASKED)
