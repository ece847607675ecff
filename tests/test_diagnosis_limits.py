"""Commands that are cut off: which ends are searched for, and that the travel of a servo is found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from noisy_flights import LEFT_OUT, flights_with
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.diagnosis.predict.candidate import candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.search.select import reported
from sym2real.effects import applicable, compose, effect
from sym2real.plants import MujocoPlant
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS

TRAVEL = 0.15
# What the nominal car lacks of MuJoCo's, and what a limit is taken for.
INCLUDED = ("gain:steer", "gain:speed", "offset:steer", "lateral_slip", "lever_arm", "dead_band:steer", "lag:steer")


def test_what_cannot_be_less_than_nothing_is_not_reported_as_less() -> None:
    """Where the base's own delay was 20 ms and the robot's is 5 ms, none is missing: a negative one is no delay."""
    (delay, *_), (offset,) = (effect(key, MUSHR).parameters for key in ("delay", "offset:steer"))
    assert reported(0.005, 0.02, delay) == 0.0
    assert reported(0.03, 0.02, delay) == pytest.approx(0.01)
    assert reported(0.005, 0.02, offset) == pytest.approx(-0.015)


def test_an_inertia_that_the_base_has_none_of_left_is_reported_as_one_that_can_be() -> None:
    """Beyond the end of what there can be, behind a base calibrated the other way: it is composed all the same."""
    model = ROBOTS["cart_pole"].nominal()
    armature = effect("armature:slider", model)
    (parameter,) = armature.parameters
    value = reported(parameter.low, -parameter.domain.low, parameter)
    assert value == parameter.low
    assert compose(model, [(armature, {"value": value})]).quantities
    assert reported(parameter.low, 0.0, parameter) == parameter.low


@pytest.fixture(scope="module")
def drives() -> Dataset:
    return simulate_case(Case("mushr", (("limit:steer", {"magnitude": TRAVEL}),), seed=11), rows=200)


def test_steering_ends_alike_on_both_sides_and_a_motor_does_not(drives: Dataset) -> None:
    base = MUSHR.nominal()
    library = Library.of(base, [effect(key, base) for key in ("limit:steer", "limit:speed")])
    backwards = Dataset([*drives, *(replace(drive, action=-drive.action) for drive in drives)])
    found = {one.name: one for one in candidates(library, backwards)}
    freed = {name: [library.slots[slot].parameter.name for slot in one.slots] for name, one in found.items()}
    assert freed == {"limit:steer": ["magnitude"], "limit:speed": ["upper"]}
    largest = max(np.abs(drive.column("steer")).max() for drive in drives)
    assert all(0.0 < start < largest for start in found["limit:steer"].starts)


@pytest.mark.parametrize(
    ("sides", "end"),
    [((-2.0, 0.5), "lower"), ((-0.5, 2.0), "upper"), ((-2.0, 1.5), "magnitude")],
    ids=["held up against gravity", "the other way", "to both sides"],
)
def test_a_motor_is_cut_off_where_its_logs_reach(sides: tuple[float, float], end: str) -> None:
    """A joint that gravity pulls one way is pushed the other way: its motor's limit is at that end, whichever it is."""
    robot = ROBOTS["cart_pole"]
    limit, values = effect("limit:drive", robot), np.linspace(*sides, 1001)
    free = {parameter.name for parameter in limit.parameters} - {*limit.searching.fixed(limit.body, values, [])}
    assert free == {end}
    starts = np.array(limit.searching.starts(limit.body, values))
    assert len(starts) > 2
    reach = sides[0] if end == "lower" else max(map(abs, sides))
    assert ((starts / reach > 0.0) & (starts / reach < 1.0)).all()
    assert all(sides[0] < size < sides[1] for size in limit.searching.sizes(limit.body, values))


@pytest.mark.slow
@pytest.mark.parametrize("magnitude", [0.8, 1.2])
def test_a_limit_of_one_rate_command_is_found_that_the_loop_knows_nothing_of(magnitude: float) -> None:
    """Without its answer the loop asks for several times as much; the other command, built alike, is not cut off."""
    base, flights = CRAZYFLIE.nominal(), flights_with("limit:wx_cmd", {"magnitude": magnitude}, 6)
    assert max(np.abs(flight.column("wx_cmd")).max() for flight in flights) > 3 * magnitude
    found = diagnose(base, flights, exclude=[pattern for pattern in LEFT_OUT if pattern != "limit:*"])
    assert {one.effect: one.values for one in found.findings} == {
        "limit:wx_cmd": {"magnitude": pytest.approx(magnitude, rel=0.05)}
    }


@pytest.mark.slow
def test_the_travel_of_a_servo_is_found(drives: Dataset) -> None:
    base = MUSHR.nominal()
    others = [one.key for one in applicable(base) if one.key not in (*INCLUDED, "limit:steer")]
    found = diagnose(base, drives, exclude=others)
    named = {one.effect: one.values for one in found.findings}
    assert "limit:steer" in named
    assert "gain:steer" not in named
    assert named["limit:steer"]["magnitude"] == pytest.approx(TRAVEL, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("threshold", [0.06, 0.15])
def test_commands_that_are_dropped_below_a_threshold_are_found(threshold: float) -> None:
    """The equations' threshold is soft, MuJoCo's is not."""
    base, data = MUSHR.nominal(), simulate_case(Case("mushr", (("dead_zone:steer", {"value": threshold}),), seed=12))
    others = [one.key for one in applicable(base) if one.key not in (*INCLUDED, "dead_zone:steer")]
    finding = diagnose(base, data, MujocoPlant(MUSHR), exclude=others).findings[0]
    value = finding.parameters["value"]
    assert finding.effect == "dead_zone:steer"
    assert value.low < threshold < value.high
    assert value.high - value.low < 0.2 * threshold
