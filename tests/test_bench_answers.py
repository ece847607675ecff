"""Tables of benches judge answers whose worth is known, with seeds that only the final run takes where it asks."""

from __future__ import annotations

from typing import Any

import answers
import numpy as np
import pytest
from invariance import CHANGED, PLAIN, figures
from mistakes_list import MISTAKES
from repeated import DEVELOPMENT, Settings, share
from sealed_seeds import SEALED
from user_mistakes import judged

from sym2real.errors import ModelError


def estimate(value: float, half: float) -> dict[str, Any]:
    return {"value": value, "low": value - half, "high": value + half, "unit": ""}


def answer(*found: tuple[str, float], verdict: str = "", **changes: Any) -> dict[str, Any]:
    findings = [{"effect": key, "group": [key], "parameters": {"value": estimate(size, 0.1)}} for key, size in found]
    plain = {"findings": findings, "faults": [], "notes": [], "leftover": None, "position_error": []}
    return {**plain, "verdict": verdict or ("EFFECT" if found else "NOTHING_MISSING"), **changes}


def test_answers_that_begin_with_one_effect_or_its_group_are_the_same() -> None:
    assert answers.same_first(answer(("delay", 0.1)), answer(("delay", 0.3), ("wind", 1.0)))
    assert answers.same_first(answer(("added_mass", 0.1)), answer(("gain:thrust", 0.9)))
    assert not answers.same_first(answer(("delay", 0.1), ("wind", 1.0)), answer(("wind", 1.0), ("delay", 0.1)))
    assert answers.same_first(answer(), answer())
    assert not answers.same_first(answer(), answer(verdict="UNEXPLAINED"))
    assert not answers.same_first(answer(), answer(("delay", 0.1)))


def test_a_delay_of_all_commands_is_part_of_each_command_s_own() -> None:
    truth = {"delay": {"value": 0.15}, "delay:steer": {"value": 0.04}, "wind": {"fx": 1.0}}
    apart = answer(("delay:steer", 0.19), ("delay:speed", 0.15), truth=truth)
    own = {"delay:steer": {"value": 0.19}, "delay:speed": {"value": 0.15}, "wind": {"fx": 1.0}}
    assert answers.in_form_of_the_answer(apart)["truth"] == own
    for found in (("delay", 0.15), ("delay:steer", 0.04)), (("wind", 1.0),):
        assert answers.in_form_of_the_answer(answer(*found, truth=truth))["truth"] == truth


def test_a_group_that_an_answer_reports_of_itself_makes_it_no_more_right() -> None:
    wide = answer(("offset:speed", 0.1))
    wide["findings"][0]["group"] += ["dead_band:steer", "delay"]
    assert not answers.named(wide, "dead_band:steer")
    assert not answers.same_first(wide, answer(("delay", 0.1)))
    assert answers.named(wide, "rolling_resistance")  # a group of physics


def test_no_finding_stands_for_two_effects() -> None:
    keys = ("added_mass", "gain:thrust")  # of one group: each alone stands for either
    assert all(answers.named(answer(("added_mass", 0.1)), key) for key in keys)
    assert not answers.all_named(answer(("added_mass", 0.1)), keys)
    assert not answers.all_named(answer(("added_mass", 0.1), ("wind", 1.0)), keys)
    assert answers.all_named(answer(("added_mass", 0.1), ("gain:thrust", 0.9)), keys)
    assert not answers.all_named(answer(), keys)


def test_values_are_within_both_intervals_only_if_each_is_in_the_other() -> None:
    near, far = answer(("delay", 0.15)), answer(("delay", 0.3))
    assert answers.within_both(answer(("delay", 0.1)), near) == [True]
    assert answers.within_both(answer(("delay", 0.1)), far) == [False]
    narrow = answer(("delay", 0.15))
    narrow["findings"][0]["parameters"]["value"] = estimate(0.15, 0.01)
    assert answers.within_both(answer(("delay", 0.1)), narrow) == [False]
    assert answers.within_both(answer(("delay", 0.1)), answer(("wind", 0.1))) == []


def test_a_wind_is_the_same_in_a_world_that_was_turned() -> None:
    wind = {"fx": estimate(1.0, 0.1), "fy": estimate(0.0, 0.2)}
    turned = answers.turned(wind, np.pi / 2)
    assert [turned[name]["value"] for name in ("fx", "fy")] == pytest.approx([0.0, 1.0], abs=1e-12)
    assert turned["fx"]["high"] - turned["fx"]["low"] == pytest.approx(0.4)
    one = {"findings": [{"effect": "wind", "group": ["wind"], "parameters": wind}]}
    other = {"findings": [{"effect": "wind", "group": ["wind"], "parameters": turned}]}
    assert answers.within_both(one, other, np.pi / 2) == [True, True]
    assert answers.within_both(one, other) == [False, False]


def test_the_table_of_invariance_holds_for_equal_answers_and_misses_for_others() -> None:
    def record(changed: dict[str, Any]) -> dict[str, Any]:
        plain = {name: answer(("delay", 0.1)) for name in CHANGED}
        truth = {"robot": "mushr", "yaw": False, "truth": {"delay": {"value": 0.1}}, "excluded": []}
        return {**truth, "angle": 0.3, "answers": {**plain, **changed}}

    alike = figures([record({}) for _ in range(5)], "mushr")
    assert all(row.holds is not False for row in alike)
    other = figures([record(dict.fromkeys(set(CHANGED) - {PLAIN}, answer(("lag:steer", 0.1))))], "mushr")
    assert [row.holds for row in other if row.bar] == [True, False]


def test_a_mistake_that_is_not_named_is_wrong_or_silent() -> None:
    mistake = next(one for one in MISTAKES["mushr"] if one.name == "wz late")
    fault = {"effect": "time_shift:wz", "evidence": "behind", "fix": ""}
    named = judged(mistake, answer(faults=[fault], verdict="EFFECT"), ["wz is 100 ms behind"])
    assert named["named"] and named["compare_names"] and not (named["wrong"] or named["silent"] or named["beside"])
    beside = judged(mistake, answer(("wind", 1.0), faults=[fault]), [])
    assert beside["beside"] and not beside["compare_names"]
    wrong = judged(mistake, answer(("lag:steer", 0.1)), [])
    assert wrong["wrong"] and not wrong["named"]
    assert judged(mistake, answer(), [])["silent"]
    crash = answers.refusal(ValueError("wz is behind"))
    assert crash["verdict"] == answers.CRASHED
    assert judged(mistake, crash, [])["crashed"]
    assert not judged(mistake, crash, [])["named"]  # what a crash says names nothing
    assert judged(mistake, answers.refusal(ModelError("the logged wz is behind")), [])["named"]
    unexplained = judged(mistake, answer(verdict="UNEXPLAINED"), [])
    assert not (unexplained["named"] or unexplained["wrong"] or unexplained["silent"])


def test_what_may_be_said_of_healthy_logs_names_no_mistake() -> None:
    remarks = [
        "no plain simulator: the base's own errors were not calibrated and may look like effects; diagnose "
        "logs of the healthy robot first, and put what these show into the base",
        "no sensor noise, as of a simulation without --noise or behind a low-pass: errors of any size count",
        "run_1: resampled to 20 ms from stamps 40 ms apart (40 to 40), 200 rows became 399: commands held",
        "8 logs, 3200 rows, time step 0.02 s",
        "steer and speed hardly vary: effects on them, a delay say, cannot be seen",
    ]
    for listed in MISTAKES.values():
        assert [one.name for one in listed if one.named_in(["added_mass", "wind"], remarks)] == []


UNITS_OF_THRUST = {"thrust in PWM", "thrust in grams", "thrust in m/s²"}


@pytest.mark.parametrize(
    ("robot", "said", "names"),
    [
        ("crazyflie", "thrust in no unit of N that is known: the numbers are 134000 times", UNITS_OF_THRUST),
        ("crazyflie", "x y z in mm instead of m: the logged numbers are 1000 times", {"x … in mm", "z in mm"}),
        ("crazyflie", "the logged wx and the attitude's derivative correlate by -0.99", {"wx reversed"}),
        ("mushr", "a heading that turns against the path", {"yaw reversed", "sine and cosine swapped"}),
        ("mushr", "steer and speed are written a row late", {"commands a row late"}),
        ("mushr", "steer and speed are written a row ahead", {"commands a row early"}),
    ],
)
def test_a_sentence_names_its_own_mistake_and_no_other_kind(robot: str, said: str, names: set[str]) -> None:
    assert {one.name for one in MISTAKES[robot] if one.named_in([], [said])} == names


def test_shares_have_their_interval() -> None:
    (row,) = share("right", [True] * 19 + [False], ">= 0.95")
    assert row.value == pytest.approx(0.95)
    assert row.holds
    # Wilson's interval of 19 of 20, as any table has it.
    assert "19 of 20 (95 %: 0.76 to 0.99)" in row.name
    assert share("nothing", []) == []


def test_sealed_seeds_are_taken_only_where_asked_and_overlap_with_no_others() -> None:
    assert Settings(cases=3).seeds_of("invariance") == [DEVELOPMENT, DEVELOPMENT + 1, DEVELOPMENT + 2]
    assert Settings(cases=2, sealed=True).seeds_of("invariance")[0] == SEALED["invariance"]
    assert Settings(seeds=(5, 9)).seeds_of("invariance") == [5, 9]
    starts = sorted([DEVELOPMENT, *SEALED.values()])
    assert np.diff(starts).min() > 100_000
