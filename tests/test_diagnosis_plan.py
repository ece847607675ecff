"""What a manoeuvre can show, against what is known of manoeuvres and effects."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from math import inf
from pathlib import Path

import pytest
import torch
from noisy_flights import flights_with
from standard_set import DRIVES, FLIGHTS

from sym2real.cli import main
from sym2real.diagnosis import Plan, plan
from sym2real.diagnosis.design.visible import Changes
from sym2real.diagnosis.estimate.fit import Hypothesis, Problems
from sym2real.diagnosis.estimate.whitening import Spread
from sym2real.diagnosis.predict.candidate import candidates, library_for
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.effects import applicable
from sym2real.errors import ModelError, UnknownNameError
from sym2real.experiments.planned import manoeuvre, planned_runs, usual_noise
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS
from sym2real.tasks.standard_paths import Manoeuvre

HOVER = (Manoeuvre("hover", height=0.6),) * 2
CIRCLE = Manoeuvre("circle", 1.5, 1.0)
OTHER_WAY = Manoeuvre("circle", 1.5, 1.0, clockwise=True)
# To keep the tests short; none of the facts below is about these.
LEFT_OUT = ("delay:*", "lag:*", "gain:w*", "limit:*", "rate_limit:*", "dead_band:*", "flapping_moment")


@cache
def planned(robot: str, manoeuvres: tuple[Manoeuvre, ...], yaw_rate: float = 0.0, dither: float = 1.0) -> Plan:
    runs = planned_runs(ROBOTS[robot], manoeuvres, seconds=8.0, yaw_rate=yaw_rate, dither=dither)
    return plan(ROBOTS[robot].nominal(), runs, usual_noise(ROBOTS[robot]), LEFT_OUT)


def inseparable(found: Plan, one: str, other: str) -> bool:
    return tuple(sorted((one, other))) in found.pairs


def smallest(found: Plan, effect: str, parameter: str = "value") -> float | None:
    return next(one.smallest for one in found.visible if (one.effect, one.parameter) == (effect, parameter))


@pytest.mark.slow
def test_tilt_and_wind_are_one_in_hover_and_two_while_turning() -> None:
    assert inseparable(planned("crazyflie", HOVER), "wind", "mounting_tilt")
    assert not inseparable(planned("crazyflie", HOVER, yaw_rate=0.7), "wind", "mounting_tilt")


@pytest.mark.slow
def test_hover_shows_no_quadratic_drag_and_fast_flight_does() -> None:
    assert smallest(planned("crazyflie", HOVER), "quadratic_drag") is None
    assert smallest(planned("crazyflie", FLIGHTS), "quadratic_drag") is not None
    assert not inseparable(planned("crazyflie", FLIGHTS), "linear_drag", "quadratic_drag")


@pytest.mark.slow
def test_ground_effect_and_mass_are_one_at_one_height() -> None:
    low = (Manoeuvre("hover", height=0.12),)
    assert inseparable(planned("crazyflie", low), "ground_effect", "added_mass")
    assert not inseparable(planned("crazyflie", FLIGHTS), "ground_effect", "added_mass")


@pytest.mark.slow
def test_without_dither_hover_shows_neither_delay_nor_motor_lag() -> None:
    still = planned("crazyflie", HOVER, dither=0.01)
    assert smallest(still, "motor_lag") is None
    assert (smallest(still, "delay") or 1.0) > 0.1
    assert 0.008 / 3 < (smallest(planned("crazyflie", HOVER), "motor_lag") or 1.0) < 0.008 * 3
    assert not inseparable(planned("crazyflie", FLIGHTS), "delay", "motor_lag")


@pytest.mark.slow
def test_a_circle_both_ways_parts_steering_offset_from_steering_gain() -> None:
    assert inseparable(planned("mushr", (CIRCLE, CIRCLE), dither=0.01), "offset:steer", "gain:steer")
    assert not inseparable(planned("mushr", (CIRCLE, OTHER_WAY), dither=0.01), "offset:steer", "gain:steer")
    assert inseparable(planned("mushr", (CIRCLE, CIRCLE), dither=0.01), "yaw_bias", "lever_arm")


@pytest.mark.slow
def test_several_speeds_part_rolling_resistance_from_a_speed_gain() -> None:
    assert inseparable(planned("mushr", (CIRCLE, CIRCLE), dither=0.01), "gain:speed", "rolling_resistance")
    assert not inseparable(planned("mushr", DRIVES), "gain:speed", "rolling_resistance")


@pytest.mark.parametrize(
    ("effect", "parameter", "known"),
    [
        ("added_mass", "value", 0.4e-3),
        ("com_offset", "rx", 0.03e-3),
        ("wind", "fx", 4e-3),
        ("linear_drag", "cx", 3e-3),
        ("delay", "value", 2e-3),
        ("battery_sag", "value", 0.002),
        ("mounting_tilt", "roll", 0.0087),
    ],
)
def test_the_smallest_effects_of_the_standard_flights_are_those_that_were_found(
    effect: str, parameter: str, known: float
) -> None:
    """Measured with another simulator and a search of its own: the order of magnitude is what must agree."""
    found = smallest(planned("crazyflie", FLIGHTS), effect, parameter)
    assert found is not None
    assert known / 3 < found < 3 * known


@pytest.mark.parametrize(("effect", "known"), [("offset:steer", 0.007), ("gain:steer", 0.025), ("gain:speed", 0.005)])
def test_the_smallest_effects_of_the_standard_drives_are_those_that_were_found(effect: str, known: float) -> None:
    found = smallest(planned("mushr", DRIVES), effect)
    assert found is not None
    assert known / 2 < found < 2 * known


def test_few_logs_show_nothing_that_no_prediction_needs() -> None:
    """What no prediction needs whole logs must establish, and few cannot."""
    model = CRAZYFLIE.nominal()
    others = [known.key for known in applicable(model) if known.key != "linear_drag"]
    few, many = (plan(model, flights_with("", {}, count), exclude=others).visible for count in (4, 8))
    sizes = [[(row.smallest or inf) / (row.matters or inf) for row in rows] for rows in (few, many)]
    assert len(sizes[0]) == 3
    assert min(sizes[0]) >= 1.0 - 1e-9
    assert min(sizes[1]) < 1.0


def test_what_no_manoeuvre_tells_apart_is_of_the_robot() -> None:
    """A quadrotor stands on no slope and has no wheelbase; rate commands go by their columns, not by a pattern."""
    flight = {row.effect: row.always for row in planned("crazyflie", HOVER).visible}
    assert flight["wind"] == ()
    assert flight["added_mass"] == ("gain:thrust",)
    assert flight["torque_bias"] == ("offset:wx_cmd", "offset:wy_cmd", "offset:wz_cmd")
    drive = {row.effect: row.always for row in planned("mushr", DRIVES).visible}
    assert drive["wind"] == ("slope",)
    assert drive["gain:steer"] == ()  # large angles tell it from a wheelbase


def test_the_verb_takes_manoeuvres_and_logs(tmp_path: Path) -> None:
    main(["plan", "mushr", "circle", "speed=1.2", "--seconds", "4", "--json", str(tmp_path / "plan.json")])
    planned_result = json.loads((tmp_path / "plan.json").read_text())
    assert {"visible", "inseparable", "seconds", "blocks"} <= planned_result.keys()
    assert {row["effect"] for row in planned_result["visible"]} >= {"offset:steer", "tyre_friction"}
    assert planned_result["seconds"] == pytest.approx(4.0, abs=0.1)


def test_manoeuvres_and_options_that_do_not_exist_are_named() -> None:
    assert manoeuvre(MUSHR, "circle", {"clockwise": 1.0}).clockwise
    with pytest.raises(UnknownNameError, match="did you mean 'circle'"):
        manoeuvre(CRAZYFLIE, "circel", {})
    with pytest.raises(UnknownNameError, match="did you mean 'speed'"):
        manoeuvre(CRAZYFLIE, "circle", {"sped": 1.0})
    with pytest.raises(UnknownNameError, match="circle"):
        manoeuvre(MUSHR, "hover", {})
    for options in ({"size": float("nan")}, {"speed": float("inf")}, {"height": float("nan")}):
        with pytest.raises(ModelError, match="expected"):
            manoeuvre(CRAZYFLIE, "circle", options)


def test_an_effect_is_apart_from_another_where_what_that_leaves_of_it_would_be_found() -> None:
    """What an arm does to a car, a slip does in part; the part by least squares on the predictions themselves."""
    found = planned("mushr", DRIVES)
    (arm,) = (row for row in found.visible if (row.effect, row.parameter) == ("lever_arm", "rx"))
    assert arm.smallest is not None
    assert arm.separable is not None
    assert arm.separable > arm.smallest
    assert arm.nearest not in (*arm.like, *arm.always, "lever_arm", "")
    assert "mean_share" not in {row.parameter for row in found.visible}  # of a delay that is none there is no share
    for row in found.visible:
        limit = row.effect.startswith(("limit", "dead_zone", "rate_limit", "tyre_friction"))
        if row.smallest is not None and row.separable is not None and not limit:
            assert row.separable >= row.smallest * (1 - 1e-9)


@pytest.mark.parametrize("effect", ["lever_arm", "wind"])
def test_what_an_effect_leaves_of_another_is_what_its_fit_leaves(effect: str) -> None:
    """Against a fit of the other to logs that have the one: the same number by another way."""
    data = planned_runs(MUSHR, DRIVES, seconds=4.0, yaw_rate=0.0, dither=1.0)
    library = library_for(MUSHR.nominal(), data, exclude=LEFT_OUT)
    problem = Problem(library, data)
    spread = Spread.of(problem, library.null)
    sizes = (len(problem.segments.channel), 1e-4), (len(spread.names), 1e-2)
    whitening = spread.whitening(*(torch.full((count,), size, dtype=torch.float64) for count, size in sizes))
    problems = Problems(problem, whitening)
    smooth = [own for own in candidates(library, data) if not own.needs_start]
    changes = Changes.of(problems, smooth)
    (own,) = (candidate for candidate in smooth if candidate.name == effect)
    whole, others = changes.others(changes.columns[..., changes.places[effect][:1]], but=effect)
    nearest = next(candidate for candidate in smooth if candidate.name == others[0].nearest)

    left = []
    for sign in (1.0, -1.0):  # the other may have one sign only
        values = library.null.clone()
        values[own.free[0]] += 0.1 * sign * library.scale[own.free[0]]
        there = Problem(library, data, replace(problem.segments, measured=problem.states(values[None])[0]))
        (fit,) = Problems(there, whitening).fit([Hypothesis(nearest.free, library.null)])
        nothing = float(whitening.loss(there.residuals(library.null[None])).sum())
        assert nothing == pytest.approx(0.01 * float(whole[0]), rel=0.05)
        left.append(fit.total / nothing)
    assert min(left) == pytest.approx(others[0].left, rel=0.1, abs=0.01)
