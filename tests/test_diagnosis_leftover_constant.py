"""A constant disturbance that the library has no name for is left over with its size; trim of single runs is not."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from noisy_flights import flights_with, flown
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset
from sym2real.diagnosis import Diagnosis, diagnose
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.estimate.whitening import Spread, estimate
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.search.select import Selection
from sym2real.diagnosis.unexplained.dependence import Terms
from sym2real.diagnosis.unexplained.disturbance_terms import CONSTANT, Dependence, TermFit
from sym2real.diagnosis.unexplained.leftover import Leftover, find_misfit, split_in_words
from sym2real.plants import MujocoPlant
from sym2real.report.leftover import measure, statement
from sym2real.robots import CRAZYFLIE, MUSHR, Robot

# The wind and what stands for it; and, to keep the tests short, much else: mass, drag and centre of mass compete.
OUT = (
    *("wind", "mounting_tilt", "slope", "gain:*", "offset:*", "limit:*", "delay*", "lag*", "motor_lag", "thrust_curve"),
    *("battery_sag", "ground_effect", "flapping_moment", "translational_lift", "quadratic_drag"),
)
WIND = {"fx": 0.02, "fy": 0.0}


@cache
def diagnosed(*, windy: bool) -> Diagnosis:
    """Eight short noisy flights, each with a trim of its own, in MuJoCo's air."""
    case = Case("crazyflie", (("wind", WIND),) if windy else (), seed=11, yaw=True)
    return diagnose(CRAZYFLIE.nominal(), simulate_case(case, rows=150), exclude=OUT)


def test_the_unit_one_goes_without_saying() -> None:
    speed = np.linspace(0.0, 2.0, 100)
    words = split_in_words(["speed"], speed[:, None], np.where(speed < 1.0, 0.5, 2.0), "1")
    assert words == "0.5 where speed is below 1, 2 above"
    assert statement(Leftover("constant", "lag", 0.5, "0.5 everywhere", 0.5, "1")) == "a constant change of lag by 0.5"


@pytest.mark.parametrize(("size", "matters"), [(0.01, False), (-0.01, False), (0.05, True)])
def test_a_gyro_may_have_its_usual_bias(size: float, matters: bool) -> None:
    left = Leftover("constant", "measured rate x", 1.0, "", size, "rad/s")
    assert left.matters == matters
    assert ("no more than gyros have" in measure(left)) != matters
    assert replace(left, unit="rad").matters


@pytest.mark.slow
def test_a_constant_without_a_name_is_left_over_with_its_size() -> None:
    found = diagnosed(windy=True)
    assert found.verdict == "UNEXPLAINED"
    assert found.leftover is not None
    assert (found.leftover.explained_by, found.leftover.channel, found.leftover.unit) == ("constant", "fx", "N")
    assert found.leftover.size == pytest.approx(WIND["fx"], rel=0.1)
    assert found.leftover.r2 > 0.9
    assert "constant disturbance along fx of 0.0" in found.summary


@pytest.mark.slow
def test_the_constant_is_proposed_as_a_term() -> None:
    proposal = diagnosed(windy=True).proposal
    assert proposal is not None
    assert proposal.channel == "fx"
    assert float(proposal.expression) == pytest.approx(WIND["fx"], rel=0.1)
    assert proposal.gain > 0.0


@pytest.mark.slow
def test_wind_of_every_flights_own_is_left_over_and_no_small_disturbance() -> None:
    winds = [(0.03, 0.0), (0.0, 0.03), (-0.02, 0.02), (0.01, -0.03), (-0.03, 0.0), (0.01, 0.01)]
    logs = [flown("wind", {"fx": fx, "fy": fy}, number, 220) for number, (fx, fy) in enumerate(winds)]
    for given in (logs, logs[::-1]):
        found = diagnose(CRAZYFLIE.nominal(), Dataset(given), exclude=OUT[1:])
        assert found.verdict == "UNEXPLAINED"
        assert {left.channel: left.explained_by for left in found.leftovers} == {"fx": "log", "fy": "log"}
        assert found.leftovers[0].r2 > 0.9
        along_x = next(left.term for left in found.leftovers if left.channel == "fx")
        (least, weakest), (most, strongest) = (end.split(" N in ") for end in along_x.split(" and "))
        assert (weakest, strongest) == (logs[4].name, logs[0].name)
        assert [float(least), float(most)] == pytest.approx([-0.03, 0.03], rel=0.15)


@pytest.mark.slow
def test_wind_of_every_flights_own_is_left_over_beside_a_simulator_that_flies_less_of_it() -> None:
    """The plain simulator flies eight seconds of each log: its segments are others than the logs'."""
    winds = [(0.03, 0.0), (0.0, 0.03), (-0.02, 0.02), (0.01, -0.03), (-0.03, 0.0), (0.01, 0.01)]
    logs = [flown("wind", {"fx": fx, "fy": fy}, number, 460) for number, (fx, fy) in enumerate(winds)]
    found = diagnose(CRAZYFLIE.nominal(), Dataset(logs), MujocoPlant(CRAZYFLIE), exclude=OUT[1:])
    assert {left.channel: left.explained_by for left in found.leftovers if left.matters} == {"fx": "log", "fy": "log"}


@pytest.mark.slow
def test_a_heavier_robot_in_half_of_few_logs_is_no_limit_of_the_thrust() -> None:
    """Thrust that is larger in those logs alone acts as if it ended where the plain robot's does."""
    logs = [flown("added_mass", {"value": 0.2 * CRAZYFLIE.mass * (number % 2)}, number, 300) for number in range(4)]
    assert diagnose(CRAZYFLIE.nominal(), Dataset(logs), exclude=OUT[:5]).verdict == "UNEXPLAINED"


@pytest.mark.slow
def test_trim_that_differs_from_run_to_run_is_no_constant() -> None:
    found = diagnosed(windy=False)
    assert found.leftover is None
    assert found.verdict == "NOTHING_MISSING"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "channel", "value"), [("yaw_bias", "measured heading", np.deg2rad(2.0)), ("offset:steer", "steer", 0.05)]
)
def test_a_cars_constants_are_those_that_were_put_in(key: str, channel: str, value: float) -> None:
    plain, changed = (_terms(((key, {"value": size}),) if size else ()) for size in (0.0, value))
    (before,), (after,) = (_constants(terms, channel) for terms in (plain, changed))
    assert _size(after) - _size(before) == pytest.approx(value, rel=0.1)
    assert after.term.channel.unit == "rad"
    assert after.chance(changed.problems.logs) < 1e-6


def test_what_one_constant_explains_is_not_counted_again() -> None:
    """Two forces are two: beside the first at its size only the second is left."""
    terms = _of(CRAZYFLIE, flights_with("wind", {"fx": 0.02, "fy": 0.015}))
    whitening = terms.problems.whitening
    (along,) = _constants(terms, "fx")
    assert _size(along) == pytest.approx(0.02, rel=0.15)
    beside = terms.with_term(along, whitening)
    (rest,) = _constants(beside, "fy")
    assert _size(rest) == pytest.approx(0.015, rel=0.15)
    assert along.term not in beside.pairs


def _constants(terms: Terms, channel: str) -> list[TermFit]:
    (along,) = (own for own in terms.channels if own.name == channel)
    return terms.judged(terms.problems.whitening, [Dependence(along, CONSTANT)])


def _size(constant: TermFit) -> float:
    return float(constant.step[constant.preceding] * constant.term.channel.size)


def _terms(effects: tuple[tuple[str, dict[str, float]], ...]) -> Terms:
    return _of(MUSHR, simulate_case(Case("mushr", effects, seed=11), rows=180))


def _of(robot: Robot, data: Dataset) -> Terms:
    library = Library.of(robot.nominal(), [])
    problem = Problem(library, data)
    spread, residual = Spread.of(problem, library.null), problem.residuals(library.null[None])[0]
    whitening = estimate(spread, residual, problem.segments.noise, problem.segments.channel, alike=True)
    return Terms.of(Selection(Problems(problem, whitening), [], library.null), spread, None)


def test_errors_far_beyond_noise_are_left_over_even_if_no_disturbance_describes_them() -> None:
    assert find_misfit(1.05) == ()
    (left,) = find_misfit(1.69)
    assert statement(left) == "an error 1.30 times that of noise and disturbances"
    assert measure(left) == "41 % of the squares"


def test_of_an_effect_it_is_said_what_unseen_logs_confirm_and_of_a_disturbance_how_much_it_explains() -> None:
    """Nothing else varies an effect: a share of its variance would always be one."""
    of_effect, disturbed = (Leftover("wz", channel, 0.97, "", motion=0.2) for channel in ("lag:steer", "fz"))
    assert measure(of_effect) == "confirmed to 97 %"
    assert measure(disturbed) == "R² 0.97"
