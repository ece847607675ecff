"""What was found must lower held-out errors by a tenth; a single log is scored on the third that the fit left out."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import torch
from noisy_flights import LEFT_OUT, flights_with
from weighed_problems import weighed_problems

from sym2real.dataset import Dataset
from sym2real.diagnosis import Fall, Finding, Gate, diagnose
from sym2real.diagnosis.conclusion import Parts, verdict
from sym2real.diagnosis.errors.floor import Floor
from sym2real.diagnosis.errors.rungs import HeldOut, Rung, RungError, windows_of
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.faults.fault import Fault
from sym2real.diagnosis.predict.candidate import candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.search.beam import Beam
from sym2real.diagnosis.search.intervals import about
from sym2real.diagnosis.search.near import Near, groups_of
from sym2real.diagnosis.search.needed import LAST_THIRD
from sym2real.diagnosis.search.select import Selection
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.explaining import beyond_floor, find_far
from sym2real.diagnosis.unexplained.leftover import Leftover, find_misfit
from sym2real.diagnosis.unexplained.odd_pieces import odd_pieces_notes
from sym2real.effects import effect
from sym2real.experiments.noisy_runs import noisy_runs
from sym2real.report.diagnosis import gate_line
from sym2real.report.leftover import statement
from sym2real.report.summary import summary
from sym2real.robots import CRAZYFLIE, ROBOTS
from sym2real.tasks import make_task


def stage(name: str, position: float, attitude: float) -> Rung:
    errors = {"position": position, "attitude": attitude, "velocity": 10 * position}
    return Rung(name, {0.8: {key: RungError(value, value, value, value, "") for key, value in errors.items()}})


@cache
def problems_of(steps: int) -> Problems:
    """One healthy flight of so many rows."""
    library = Library.of(CRAZYFLIE.nominal(), [])
    return weighed_problems(library, flights_with("", {}, count=1, steps=steps))


@pytest.mark.parametrize(
    ("position", "attitude", "passes"), [(0.89, 1.0, True), (1.0, 0.85, True), (0.91, 0.95, False)]
)
def test_a_tenth_of_position_or_attitude_must_go(position: float, attitude: float, passes: bool) -> None:
    gate = Gate(stage("base", 1.0, 1.0), stage("+ wind", position, attitude))
    assert gate.passed is passes
    assert gate.best is not None
    assert gate.best.part == pytest.approx(1.0 - min(position, attitude))


@pytest.mark.parametrize(
    ("rise", "half_width", "passes"), [(0.2, 0.05, False), (0.2, 0.5, True), (0.05, 0.0, True), (0.2, 0.0, False)]
)
def test_what_rises_beyond_its_interval_passes_no_gate(rise: float, half_width: float, passes: bool) -> None:
    """Position falls by nine tenths, attitude rises; one piece alone has no interval, and a hair is no rise there."""

    def around(value: float) -> RungError:
        return RungError(value, value, value - half_width, value + half_width, "")

    before = Rung("base", {0.8: {"position": around(10.0), "attitude": around(1.0)}})
    after = Rung("+ added_mass", {0.8: {"position": around(1.0), "attitude": around(1.0 + rise)}})
    gate = Gate(before, after)
    assert gate.passed is passes
    assert [fall.channel for fall in gate.worse] == ([] if passes else ["attitude"])


@pytest.mark.parametrize(("fall", "passes"), [(0.5, True), (0.16, False)])
def test_an_error_that_falls_by_chance_passes_no_gate(fall: float, passes: bool) -> None:
    """Windows in which a model is worse here and better there, resampled alike; neither is a rise of such."""
    rng = np.random.default_rng(2)
    drawn = rng.normal(1.0, 0.1, 500)

    def error(value: float) -> RungError:
        own = value * drawn * (1.0 if value == 1.0 else rng.normal(1.0, 0.15, 500))
        return RungError(value, value, *map(float, np.quantile(own, [0.025, 0.975])), "", own)

    for sign in (-1, 1):
        ends = [Rung("", {0.8: {"position": error(value)}}) for value in (1.0, 1.0 + sign * fall)]
        gate = Gate(*ends)
        assert gate.fallen is (passes and sign < 0)
        assert bool(gate.worse) is (passes and sign > 0)


def test_predictions_that_are_worse_than_no_change_judge_nothing() -> None:
    """Of a pole that falls within the horizon, with either model."""
    ends = [replace(stage(name, size, size), beats_hold=False) for name, size in (("base", 1.0), ("+ armature", 2.0))]
    gate = Gate(*ends)
    assert gate.passed
    assert not gate.beats_hold
    assert not Gate(ends[0], replace(ends[1], beats_hold=True)).passed
    assert "better than that nothing changes" in gate_line(gate, Fall(0.8, "position", -1.0))


def test_predictions_of_a_hover_judge() -> None:
    """Where hardly anything moves, that nothing changes is as good; but not surely better."""
    robot = ROBOTS["crazyflie"]
    logs = noisy_runs(robot, [make_task("hover", robot)], count=4, rows=300, seed=3)
    library = Library.of(robot.nominal(), [])
    (base,) = HeldOut(library, logs).ladder([("base", library.null[None])], (0.8, 2.0))
    assert base.beats_hold


def test_findings_that_improve_no_prediction_are_no_answer() -> None:
    gate = Gate(stage("base", 1.0, 1.0), stage("+ wind", 0.95, 0.99))
    problems = problems_of(800)
    found = (Finding("wind", {}, 1.0),)
    assert verdict(Parts((), found, (), gate), problems) == "CANNOT_TELL"
    said = summary("CANNOT_TELL", Parts((), found, (), gate))
    assert said.startswith("No answer: wind () is beyond chance, but no held-out error surely falls by 10 %")
    assert "that of position after 0.8 s falls by 5 %" in said
    assert verdict(Parts((), found, (), Gate(stage("base", 1.0, 1.0), stage("+ wind", 0.5, 1.0))), problems) == "EFFECT"
    worse = Gate(stage("base", 1.0, 1.0), stage("+ wind", 0.5, 1.2))
    assert verdict(Parts((), found, (), worse), problems) == "CANNOT_TELL"
    said = summary("CANNOT_TELL", Parts((), found, (), worse))
    assert "the held-out error of attitude after 0.8 s rises by 20 %" in said
    assert "attitude after 0.8 s rises by 20 %" in gate_line(worse, Fall(0.8, "position", 0.5))


def test_effects_that_too_few_pieces_tell_of_are_named() -> None:
    said = summary("CANNOT_TELL", Parts(suspects={"drag": 0.97, "lag": 0.93}))
    assert said.startswith(
        "No answer: drag (97 %) or lag (93 %) would explain what is missing, but too few independent"
    )
    assert "`sym2real add MODEL drag --fit LOGS`" in said


def test_what_changes_no_prediction_is_not_missing() -> None:
    """A healthy flight whose delay is truly 5 ms: known beyond chance, and of no use to anybody."""
    delay = Finding("delay", {"value": about(0.005, 0.001, "s")}, 0.3, small=True)
    gate, problems = Gate(stage("base", 1.0, 1.0), stage("+ delay", 0.97, 0.99)), problems_of(800)
    assert verdict(Parts((), (delay,), (), gate), problems) == "NOTHING_MISSING"
    assert summary("NOTHING_MISSING", Parts((), (delay,), (), gate)) == (
        "Nothing is missing beyond noise and small disturbances; small: delay (value 0.0050 ± 0.0020 s), beyond "
        "chance, and no error is larger by a tenth without it."
    )
    # One that an error needs, as where two undo each other; an error that rises; too little data; an unfinished search.
    needed, worse = (delay, Finding("lag", {}, 0.2)), Gate(stage("base", 1.0, 1.0), stage("+ delay", 0.97, 1.2))
    assert verdict(Parts((), needed, (), gate), problems) == "CANNOT_TELL"
    assert verdict(Parts((), (delay,), (), worse), problems) == "CANNOT_TELL"
    assert verdict(Parts((), (delay,), (), gate), problems_of(300)) == "CANNOT_TELL"
    assert verdict(Parts((), (delay,), (), gate), problems, finished=False) == "CANNOT_TELL"


def test_a_small_effect_is_no_answer_beside_one_of_another_form() -> None:
    """Five grams more in two of six flights were a limit of the thrust: 2 ms of motor lag were sure."""
    gate, problems = Gate(stage("base", 1.0, 1.0), stage("+ limit", 0.5, 1.0)), problems_of(800)
    limit, lag = (
        Finding("limit:thrust", {}, 0.4),
        Finding("motor_lag", {"value": about(0.002, 0.001, "s")}, 0.5, small=True),
    )
    left = (Leftover("in log2, log5 alone", "limit:thrust", 0.4, "", motion=0.5, instead="added_mass"),)
    assert verdict(Parts((), (limit, lag), (), gate), problems) == "EFFECT"
    assert verdict(Parts((), (limit, lag), left, gate), problems) == "UNEXPLAINED"
    assert verdict(Parts((), (limit, replace(lag, small=False)), left, gate), problems) == "EFFECT"
    said = summary("UNEXPLAINED", Parts((), (limit, lag), left, gate))
    assert "in all of the logs alike: what added_mass in log2, log5 alone explains better than limit:thrust" in said
    assert said.endswith(
        "small: motor_lag (value 0.0020 ± 0.0020 s), beyond chance, and no error is larger by a tenth without it."
    )


def test_where_predictions_judge_nothing_an_effect_is_no_answer_beside_what_is_left() -> None:
    """A thrust that was logged in no unit: the model falls, with a lag of its motors or without."""
    ends = [replace(stage(name, 3.0, 1.0), beats_hold=False) for name in ("base", "+ motor_lag")]
    found, left = (Finding("motor_lag", {}, 1.0),), (Leftover("thrust", "fz", 0.3, "", motion=0.5),)
    assert verdict(Parts((), found, left, Gate(*ends)), problems_of(800)) == "UNEXPLAINED"
    assert verdict(Parts((), found, (), Gate(*ends)), problems_of(800)) == "EFFECT"
    predicted = Gate(stage("base", 3.0, 1.0), stage("+ motor_lag", 1.2, 1.0))
    assert verdict(Parts((), found, left, predicted), problems_of(800)) == "EFFECT"
    hover = Gate(
        *(replace(stage(name, size, 1.0), beats_hold=False) for name, size in (("base", 1.6), ("+ mass", 0.1)))
    )
    # Of a hover few models predict anything.
    assert verdict(Parts((), found, left, hover), problems_of(800)) == "EFFECT"


def test_errors_far_from_what_noise_and_disturbances_make_beside_something_left_leave_no_effect_established() -> None:
    """A rotor that fails in the middle of flights is no damping, though half of the error goes with one."""
    ladder = stage("base", 3.0, 1.0), stage("+ rate_damping", 1.4, 1.0)
    level = {"position": (0.4, "m"), "attitude": (0.9, "rad"), "velocity": (10.0, "m/s")}
    found, left = (Finding("rate_damping", {}, 1.0),), (Leftover("time", "ty", 0.8, "", motion=0.5),)
    far = Parts((), found, left, Gate(*ladder), ladder, (Floor(0.8, level),))
    assert verdict(far, problems_of(800)) == "UNEXPLAINED"
    assert "errors more than 3 times what noise and disturbances make" in summary("UNEXPLAINED", far)
    # Of encoders of 16,384 counts noise is so small that a simulator's own steps are far from it.
    for after, answer in ((104.0, "EFFECT"), (1004.0, "UNEXPLAINED")):
        assert verdict(far, problems_of(800), misfit=(43_000.0, after)) == answer
    near = (Floor(0.8, {**level, "position": (0.5, "m")}),)
    for other in (replace(far, leftovers=()), replace(far, floor=near)):
        assert verdict(other, problems_of(800)) == "EFFECT"


def test_an_error_that_the_findings_do_not_lower_is_another_thing_that_is_left() -> None:
    """A load, and rates that lag a little in a log without noise: the place is right, the attitude as it was."""
    ladder = stage("base", 1.5, 0.9), stage("+ added_mass", 0.03, 0.9)
    floor = (Floor(0.8, {"position": (0.02, "m"), "attitude": (0.08, "rad"), "velocity": (10.0, "m/s")}),)
    found, left = (Finding("added_mass", {}, 1.0),), (Leftover("misfit", "attitude", 0.99, "", motion=0.02),)
    other = Parts((), found, left, Gate(*ladder), ladder, floor)
    assert verdict(other, problems_of(800)) == "EFFECT"
    said = summary("EFFECT", other)
    assert said.endswith("the attitude error stays 11.2 times what noise and disturbances make.")
    lowered = stage("base", 1.5, 1.5), ladder[1]
    assert verdict(replace(other, gate=Gate(*lowered), ladder=lowered), problems_of(800)) == "UNEXPLAINED"


def test_what_removes_less_of_the_misfit_than_it_leaves_is_no_answer_beside_something_left() -> None:
    """Of a rotor that fails in the middle of flights weaker torques remove two fifths."""
    gate, left = Gate(stage("base", 3.0, 1.0), stage("+ torque_scale", 1.2, 1.0)), Leftover("time", "ty", 0.6, "")
    for share, answer in ((0.42, "UNEXPLAINED"), (0.58, "EFFECT")):
        parts = Parts((), (Finding("torque_scale", {}, share),), (replace(left, motion=0.5),), gate)
        assert verdict(parts, problems_of(800)) == answer
        assert verdict(replace(parts, leftovers=()), problems_of(800)) == "EFFECT"


def test_what_stands_still_is_no_error_that_falls() -> None:
    """A goal that never moves is predicted to the last digit, with an effect and without."""
    gate = Gate(stage("base", 1.0, 1e-12), stage("+ damping", 0.95, 0.0))
    assert gate.best is not None
    assert gate.best.channel == "position"
    assert not gate.passed


def test_what_lowers_no_error_by_half_is_no_answer_beside_something_left() -> None:
    """Of a wavy beam dry friction explains most residuals, and a third of the error."""
    found, left = (Finding("joint_friction:ball", {}, 1.0),), (Leftover("angle", "ball", 0.3, "", motion=0.5),)
    for ends, answer in (((1.6, 0.6), "UNEXPLAINED"), ((1.4, 0.6), "EFFECT"), ((1.6, 0.4), "EFFECT")):
        parts = Parts((), found, left, Gate(stage("base", 3.0, 1.0), stage("+ friction", *ends)))
        assert verdict(parts, problems_of(800)) == answer
        assert verdict(replace(parts, leftovers=()), problems_of(800)) == "EFFECT"
    assert "of every error stays" in summary("UNEXPLAINED", parts)


def test_a_threshold_that_leaves_its_command_something_to_explain_has_another_form() -> None:
    """Of another mass half of the time a limit of the thrust explains most, and no answer to the thrust."""
    found, gate = (Finding("limit:thrust", {}, 1.0),), Gate(stage("base", 3.0, 1.0), stage("+ limit:thrust", 1.2, 1.0))
    left = Leftover("thrust", "fz", 0.4, "", motion=0.5)
    assert verdict(Parts((), found, (left,), gate), problems_of(800)) == "UNEXPLAINED"
    said = summary("UNEXPLAINED", Parts((), found, (left,), gate))
    assert "still depends on the same command" in said
    for key, feature in (("joint_friction:q", "q"), ("gain:thrust", "thrust")):
        other = (Finding(key, {}, 1.0),)
        assert verdict(Parts((), other, (replace(left, explained_by=feature),), gate), problems_of(800)) == "EFFECT"
    elsewhere = replace(left, channel="limit:thrust", explained_by="speed")
    assert verdict(Parts((), found, (replace(elsewhere, r2=0.95),), gate), problems_of(800)) == "UNEXPLAINED"
    assert verdict(Parts((), found, (elsewhere,), gate), problems_of(800)) == "EFFECT"
    for other in (replace(left, explained_by="height"), replace(left, motion=0.001)):
        assert verdict(Parts((), found, (other,), gate), problems_of(800)) == "EFFECT"


def test_a_misfit_that_predictions_do_not_show_is_none() -> None:
    """Known to a third: an error of position is beyond its floor from 4/3 on; of velocity none is judged."""
    floor = (Floor(0.8, {"position": (1.0, "m"), "attitude": (1.0, "rad"), "velocity": (1.0, "m/s")}),)
    assert not beyond_floor([stage("base", 5.0, 5.0), stage("+ wind", 1.3, 1.3)], floor)
    assert beyond_floor([stage("base", 1.4, 1.0)], floor)
    assert beyond_floor([], ())


def test_predictions_far_from_noise_leave_something_where_disturbances_explain_every_residual() -> None:
    """They may be as large as all that is wrong, and are no cause where errors are no larger than they make them."""
    sizes = {"position": (1.0, "m"), "attitude": (1.0, "rad"), "velocity": (1.0, "m/s")}
    floor = (Floor(0.8, sizes, {"position": 0.5, "attitude": 1.0, "velocity": 1.0}),)
    (left,) = find_far([stage("base", 2.0, 2.0)], floor, 0.2)
    assert left.matters and left.term == "0.8 s ahead"
    assert "an error of position 4.00 times that of noise alone" in statement(left)
    assert find_far([stage("base", 1.4, 2.9)], floor, 0.2) == ()
    # Beside a finding that no prediction bears out, disturbances are no excuse.
    (alone,) = find_far(
        [stage("base", 1.0, 3.1)], (replace(floor[0], errors={**sizes, "attitude": (9.0, "rad")}),), beyond=0.0
    )
    assert (alone.channel, alone.matters) == ("attitude", True)
    assert find_far([stage("base", 1.4, 2.9)], floor, beyond=0.0) == ()
    (small,) = find_far([stage("base", 12.0, 2.0)], floor, 0.005)
    assert not small.matters


@pytest.mark.parametrize(("steps", "answer"), [(75, "CANNOT_TELL"), (800, "UNEXPLAINED")])
def test_what_is_left_of_a_second_or_two_is_no_answer(steps: int, answer: str) -> None:
    misfit = find_misfit(1.5)
    assert verdict(Parts((), (), misfit), problems_of(steps)) == answer
    said = summary(answer, Parts((), (), misfit))  # type: ignore[arg-type]
    assert said.startswith("Too little data") == (answer == "CANNOT_TELL")
    assert "1.22 times that of noise" in said


@pytest.mark.parametrize("faults", [(), (Fault("sensor_sign:wy", "reversed"),)])
def test_fewer_than_ten_pieces_are_no_answer_whatever_was_found(faults: tuple[Fault, ...]) -> None:
    gate = Gate(stage("base", 1.0, 1.0), stage("+ wind", 0.5, 1.0))
    found = (Finding("wind", {}, 1.0, provisional=True),)
    few = problems_of(300)
    assert few.block_count < SETTINGS.fewest_pieces
    assert verdict(Parts(faults, found, (), gate), few) == "CANNOT_TELL"
    said = summary("CANNOT_TELL", Parts(faults, found, (), gate))
    assert "erhaps missing: wind" in said
    assert "no finding can be tested" in said
    assert said.startswith("The data show sensor_sign:wy; too little data" if faults else "Too little data")
    assert verdict(Parts(faults), few) == "CANNOT_TELL"


@pytest.mark.parametrize(("noise", "answer"), [(0.9, "UNEXPLAINED"), (1.1, "NOTHING_MISSING")])
def test_what_is_left_is_an_answer_where_errors_are_larger_than_noise_makes_them(noise: float, answer: str) -> None:
    """Of an arm that falls noise alone makes the error ahead; a trifle of a torque depends on its motor."""
    floor = Floor(0.8, dict.fromkeys(("position", "attitude"), (1.0, "")), {"position": noise, "attitude": 1.1})
    left, stages = (Leftover("earlier motor", "push", 0.4, "", motion=0.03),), (stage("base", 1.0, 1.0),)
    assert verdict(Parts((), (), left, Gate(), stages, (floor,)), problems_of(900)) == answer


@pytest.mark.parametrize(("before", "after", "worse"), [(1, 1, 0), (0, 1, 1), (1, 0, 1), (0, 0, 1)])
def test_an_error_that_only_tells_what_noise_grows_to_does_not_rise(before: int, after: int, worse: int) -> None:
    """A pole falls within the horizon, whatever the model; a cart's place is predicted well."""
    stages = stage("base", 1.0, 1.0), stage("+ friction", 0.1, 2.0)
    lost = ({0.8: ("attitude",)} if is_lost else {} for is_lost in (before, after))
    gate = Gate(*(replace(rung, worse=where) for rung, where in zip(stages, lost, strict=True)))
    assert len(gate.worse) == worse
    assert gate.passed is not bool(worse)


def test_what_is_less_likely_than_not_is_not_announced_as_missing() -> None:
    sure = Finding("delay", {"value": about(0.1, 0.01, "s")}, 0.9, probability=1.0)
    doubtful = Finding("added_mass", {"value": about(-0.1, 0.01, "kg")}, 0.01, probability=0.0)
    gate = Gate(stage("base", 1.0, 1.0), stage("+ delay", 0.5, 0.5))
    said = summary("EFFECT", Parts((), (sure, doubtful), (), gate))
    assert said.startswith("Missing: delay (value 0.100 ± 0.020 s); less likely than not: added_mass (")
    alone = summary("EFFECT", Parts((), (doubtful,), (), gate))
    assert alone.startswith("Missing: added_mass (")


def test_the_sentence_begins_with_the_verdict() -> None:
    """Of a load that sloshes: a lag of 4 ms is there in every log, and explains nothing of what is missing."""
    lag = Finding("lag", {"value": about(0.0044, 0.001, "s")}, 0.5, group=("lag", "lag:wx_cmd"), small=True)
    left = (Leftover("wz_cmd", "tz", 0.11, "", motion=0.5), Leftover("time", "fx", 0.2, "", motion=0.001))
    gate = Gate(stage("base", 1.0, 1.0), stage("+ lag", 1.01, 1.01))
    said = summary("UNEXPLAINED", Parts((), (lag,), left, gate))
    assert said.startswith(
        "Something is missing that none of the tested effects explains: a disturbance along tz that depends on wz_cmd "
        "(R² 0.11); beside it lag (value 0.0044 ± 0.0020 s) is beyond chance, but no held-out error surely falls by "
        "10 %: that of position after 0.8 s rises by 1 %."
    )
    assert "position after 0.8 s rises by 1 %" in gate_line(gate, Fall(0.8, "position", -0.01))
    minor = summary("NOTHING_MISSING", Parts((), (), left[1:]))
    assert minor == "Nothing is missing beyond noise and small disturbances."
    fallen = Gate(stage("base", 1.0, 1.0), stage("+ lag", 0.5, 1.0))
    said = summary("EFFECT", Parts((), (lag,), left[:1], fallen))
    assert "depends on wz_cmd is left (R² 0.11); what was found may stand for a part of that" in said
    assert "may stand" not in summary("EFFECT", Parts((), (lag,), left[1:], fallen))
    floor = (Floor(0.8, {"position": (0.4, "m"), "attitude": (0.5, "rad"), "velocity": (1.0, "m/s")}),)
    far = summary("EFFECT", Parts((), (lag,), left[:1], fallen, (fallen.after,), floor))
    assert far.endswith("is left (R² 0.11); the attitude error stays 2.0 times what noise and disturbances make.")
    both = Gate(stage("base", 1.0, 1.0), stage("+ lag", 0.5, 0.5))
    part = summary("EFFECT", Parts((), (lag,), left[:1], both, (fallen.after,), floor))
    assert "the attitude error stays 2.0 times what noise and disturbances make, and what was found may stand" in part
    near = summary("EFFECT", Parts((), (lag,), left[:1], fallen, (stage("+ lag", 0.5, 0.6),), floor))
    assert "is left (R² 0.11); what was found may stand" in near
    silent = summary("EFFECT", Parts((), (lag,), (), fallen, (fallen.after,), floor))
    assert silent.endswith("attitude error stays 2.0 times what noise and disturbances make, and no test says by what.")
    assert "no test says" not in summary("EFFECT", Parts((), (lag,), (), both, (both.after,), floor))


def test_beside_a_fault_what_predictions_do_not_bear_out_is_not_missing() -> None:
    fault, found = Fault("sensor_sign:wy", "reversed"), (Finding("wind", {}, 1.0, group=("wind", "mounting_tilt")),)
    gate = Gate(stage("base", 1.0, 1.0), stage("+ wind", 0.95, 0.99))
    assert verdict(Parts((fault,), found, (), gate), problems_of(800)) == "EFFECT"
    said = summary("EFFECT", Parts((fault,), found, (), gate))
    assert said == (
        "The data show sensor_sign:wy; beside it wind () is beyond chance, but no held-out error surely falls by 10 %: "
        "that of position after 0.8 s falls by 5 %."
    )
    alone = summary("EFFECT", Parts((fault,), (), (), gate))
    assert alone == "The data show sensor_sign:wy; beside that nothing is missing beyond noise and small disturbances."


def test_what_changes_no_prediction_stands_behind_what_does() -> None:
    lag = Finding("lag", {"value": about(0.0044, 0.001, "s")}, 0.5, group=("lag", "lag:wx_cmd"), small=True)
    found = (lag, Finding("wind", {}, 0.5, group=("wind", "mounting_tilt")))
    gate = Gate(stage("base", 1.0, 1.0), stage("+ wind", 0.5, 1.0))
    said = summary("EFFECT", Parts((), found, (), gate))
    assert said.startswith("Missing: wind (), or mounting_tilt; small: lag (value 0.0044 ± 0.0020 s), beyond chance")
    assert "or lag:wx_cmd" not in said
    alone = summary("EFFECT", Parts((), (lag,), (), gate))
    assert alone == "Missing: lag (value 0.0044 ± 0.0020 s), or lag:wx_cmd."


@pytest.mark.parametrize(("misfit", "answer"), [(975.0, "UNEXPLAINED"), (1.02, "EFFECT")])
def test_a_fault_alone_is_an_answer_only_where_noise_is_left(misfit: float, answer: str) -> None:
    fault = Fault("sensor_sign:wy", "reversed")
    assert verdict(Parts((fault,), (), find_misfit(misfit)), problems_of(800)) == answer


def test_blocks_are_a_second_and_a_half_of_one_log_and_leave_nothing_out() -> None:
    """What an effect does in a rhythm of its own must not fall between the blocks that test it."""
    problems = problems_of(800)
    segments, dt = problems.problem.segments, CRAZYFLIE.dt
    inside = [np.flatnonzero(problems.blocks == block) for block in range(problems.block_count)]
    assert np.array_equal(np.concatenate(inside), np.arange(len(segments)))
    assert all(len({*segments.log[block].tolist()}) == 1 for block in inside)
    assert all(len(block) * segments.length * dt >= 1.5 for block in inside[:-1])


def test_asking_for_alternatives_changes_no_answer() -> None:
    """A better alternative was put in behind the ladder's back, which then named another effect than the findings."""
    base, data = CRAZYFLIE.nominal(), flights_with("wind", {"fx": 0.02, "fy": -0.01})
    library = Library.of(base, [effect(key, base) for key in ("wind", "linear_drag")])
    tried = candidates(library, data)
    selection = Selection(weighed_problems(library, data), tried, library.null)
    (wrong,) = (one for one in tried if one.name == "linear_drag")
    (scored,) = selection.ranked(selection.present, [wrong])
    selection.put([wrong], scored.fit)
    assert "wind" in groups_of(Near.of(selection))["linear_drag"]
    assert selection.chosen == [wrong]
    Beam(selection).search()
    assert [one.name for one in selection.chosen] == ["wind"]


@pytest.mark.parametrize(
    ("left", "said"),
    [
        (Leftover("time", "fx", 0.3, ""), "a disturbance along fx that depends on time"),
        (Leftover("time", "wx_cmd", 0.3, ""), "a change of wx_cmd that depends on time"),
        (Leftover("constant", "steer", 0.3, "", 0.05, "rad"), "a constant change of steer by 0.05 rad"),
    ],
)
def test_only_forces_and_torques_push_along_something(left: Leftover, said: str) -> None:
    assert statement(left) == said


def test_a_single_log_is_scored_behind_its_fit() -> None:
    (log,) = list(flights_with("wind", {"fx": 0.01, "fy": 0.0}, count=1, steps=300))
    found = diagnose(CRAZYFLIE.nominal(), log, exclude=(*LEFT_OUT, "rate_loop_gain", "mounting_tilt"))
    assert found.held_out == (f"{log.name} (last third)",)
    assert found.gate.passed
    written = found.to_dict()["gate"]
    assert written["best"]["part"] > 0.1
    windows = windows_of(Dataset([log]), 10, LAST_THIRD)
    assert windows is not None
    assert windows.row.min() >= LAST_THIRD * len(log) - 1


def test_a_horizon_of_jittering_stamps_is_said_in_three_digits() -> None:
    assert Fall(0.319992, "position", 0.231).text == "of position after 0.32 s falls by 23 %"


def test_pieces_that_hardly_count_are_told_with_their_log_and_time() -> None:
    problems = problems_of(800)
    trust = torch.ones(len(problems.problem.segments), dtype=torch.float64)
    assert odd_pieces_notes(replace(problems, whitening=replace(problems.whitening, trust=trust))) == ()
    trust[3] = 0.1
    (note,) = odd_pieces_notes(replace(problems, whitening=replace(problems.whitening, trust=trust)))
    segments, (log,) = problems.problem.segments, problems.data
    first, last = log.time[[segments.row[3], segments.row[3] + segments.length - 1]] - log.time[0]
    assert note == (
        f"1 of {len(trust)} pieces, in 1 of 1 logs, are unlike all others and hardly count: "
        f"look at {log.name} ({first:.1f} to {last:.1f} s)"
    )


def by_size(**errors: tuple[float, float]) -> Rung:
    """Errors by channel, each with half of its interval."""
    own = {name: RungError(size, size, size - half, size + half, "") for name, (size, half) in errors.items()}
    return Rung("", {0.8: own})


@pytest.mark.parametrize(
    ("after", "best", "falling", "worse", "fallen"),
    [
        (((0.5, 0.01), (0.8, 0.01)), "position", {"position", "attitude"}, (), True),
        (((0.5, 0.6), (0.8, 0.01)), "attitude", {"attitude"}, (), True),  # the larger fall is chance
        (((0.5, 0.6), (0.95, 0.01)), "attitude", {"attitude"}, (), False),  # surely, and less than a tenth
        (((0.5, 0.6), (0.9, 0.9)), "position", set(), (), False),
        (((1.5, 0.01), (0.5, 0.01)), "attitude", {"attitude"}, ("position",), False),  # one falls, and one rises
        (((1.5, 0.01), (1.05, 0.9)), "attitude", set(), ("position",), False),  # the least rise is the best there is
        (((1.2, 0.01), (1.5, 0.01)), "position", set(), ("attitude", "position"), False),  # the largest rise first
    ],
)
def test_of_all_errors_the_surest_and_largest_fall_is_the_best_and_sure_rises_are_worse(
    after: tuple[tuple[float, float], ...], best: str, falling: set[str], worse: tuple[str, ...], fallen: bool
) -> None:
    position, attitude = after
    before = by_size(position=(1.0, 0.01), attitude=(1.0, 0.01), velocity=(1.0, 0.01))
    gate = Gate(before, by_size(position=position, attitude=attitude, velocity=(9.0, 0.01)))  # which nobody judges
    assert gate.best is not None
    assert (gate.best.channel, gate.falling, gate.fallen) == (best, falling, fallen)
    assert tuple(rise.channel for rise in gate.worse) == worse
    assert gate.passed is fallen
    written = gate.to_dict()
    assert written is not None
    assert (written["passed"], written["best"]["channel"], len(written["worse"])) == (fallen, best, len(worse))
    for some in (Gate(before, None), Gate(None, before), Gate()):
        assert (some.best, some.worse, some.falling, some.to_dict()) == (None, (), set(), None)
        assert some.passed


@pytest.mark.parametrize(
    ("part", "surely", "text"),
    [
        (0.5, True, "falls by 50 %"),
        (0.5, False, "falls by 50 %, within chance"),
        (0.05, False, "falls by 5 %"),
        (-0.5, True, "rises by 50 %"),
        (-0.5, False, "rises by 50 %, within chance"),
        (0.0, True, "falls by 0 %"),
    ],
)
def test_a_change_within_chance_is_said_to_be_so_where_it_would_matter(part: float, surely: bool, text: str) -> None:
    assert Fall(0.8, "position", part, surely).text == f"of position after 0.8 s {text}"


def test_a_large_misfit_that_stays_leaves_no_effect_established_beside_something_left() -> None:
    """A wall that a pendulum hits is no limit of its torque; pieces in which it does are trusted less, not unseen."""
    found, left = (Finding("limit:torque", {}, 1.0),), (Leftover("hinge", "hinge_push", 0.3, "", motion=0.5),)
    ladder = stage("base", 3.0, 1.0), stage("+ limit:torque", 1.4, 1.0)
    parts, problems = Parts((), found, left, Gate(*ladder)), problems_of(800)
    for misfit, answer in (((382.0, 377.0), "UNEXPLAINED"), ((382.0, 170.0), "EFFECT"), ((1.3, 1.2), "EFFECT")):
        assert verdict(parts, problems, misfit=misfit) == answer
        assert verdict(replace(parts, leftovers=()), problems, misfit=misfit) == "EFFECT"
    # Where no prediction is better than that nothing changes, a tenth is too much.
    blind = Gate(*(replace(own, beats_hold=False) for own in ladder))
    for misfit, answer in (((2110.0, 616.0), "UNEXPLAINED"), ((43.8, 3.1), "EFFECT")):
        assert verdict(replace(parts, gate=blind), problems, misfit=misfit) == answer
