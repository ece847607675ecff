"""What the base itself gets wrong in the plain simulator is not the robot's, unless the logs contradict that."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
import torch
from noisy_flights import flights_with
from weighed_problems import weighed_problems

from sym2real.dataset import Dataset
from sym2real.diagnosis.estimate import calibrate
from sym2real.diagnosis.estimate.calibrate import Calibration, by_log, cleaned
from sym2real.diagnosis.estimate.fit import Fit, Hypothesis, Problems
from sym2real.diagnosis.estimate.preparation import CONTRADICTED, Prepared, uncalibrated
from sym2real.diagnosis.estimate.simulator import SWITCHED_OFF, flown_along
from sym2real.diagnosis.estimate.whitening import Spread
from sym2real.diagnosis.pipeline import prepare
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.question import Question
from sym2real.diagnosis.score.finding import findings_of
from sym2real.diagnosis.search.beam import search
from sym2real.diagnosis.search.select import Selection
from sym2real.effects import applicable, effect
from sym2real.experiments.noisy_runs import noisy_runs
from sym2real.plants import MujocoPlant
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.stages import Stages
from sym2real.symbolic import Equations, symbol
from sym2real.tasks import make_task

OWN = 0.002  # N, constant force that a wrong base has
SILENT = Stages(lambda _: None)


def test_scores_of_a_log_are_its_segments_mean_and_of_one_that_was_not_flown_the_mean_of_logs() -> None:
    gradient = torch.tensor([[1.0, 0.0], [3.0, 2.0], [10.0, 4.0]])
    found = by_log(gradient, ["a", "a", "b"], ["b", "not flown", "a"])
    assert found.tolist() == [[10.0, 4.0], [6.0, 2.5], [2.0, 1.0]]


@cache
def wind_beside(own: float) -> tuple[Problems, Fit, Calibration]:
    """A wind fitted beside a base with a force of its own, and that base in the plain simulator."""
    base = CRAZYFLIE.nominal().substitute({"fx": symbol("fx") + own})
    data = flights_with("wind", {"fx": 0.02, "fy": 0.01}, count=2, steps=150)
    library = Library.of(base, [effect("wind", base)])
    problems = weighed_problems(library, data)
    (fit,) = problems.fit([Hypothesis(tuple(range(len(library.slots))), library.null)])
    flown, _ = flown_along(base, MujocoPlant(CRAZYFLIE), data)
    assert flown is not None
    there = Problem(library, flown)
    spread = Spread.of(there, library.null)
    return problems, fit, Calibration(there, spread, spread.like(problems.whitening), library.null)


def test_a_force_of_the_base_s_own_is_taken_off_the_robot_s() -> None:
    (_, seen, _), (problems, fit, own) = wind_beside(0.0), wind_beside(OWN)
    assert float(fit.values[0]) == pytest.approx(float(seen.values[0]) - OWN, rel=0.01)
    clean = cleaned(problems, fit, own)
    right = cleaned(*wind_beside(0.0))
    torch.testing.assert_close(clean.values, right.values, rtol=0.005, atol=1e-5)
    assert float(clean.gradient.sum(0).abs().max()) < 1e-3 * float(clean.gradient.abs().sum())
    assert cleaned(problems, fit, None) is fit


def test_a_base_that_errs_in_the_simulator_by_more_than_the_logs_show_is_not_believed() -> None:
    problems, fit, _ = wind_beside(0.0)
    assert cleaned(problems, fit, wind_beside(-0.1)[2]) is fit


def test_an_effect_that_begins_at_a_threshold_has_no_score_where_it_does_nothing() -> None:
    _, fit, own = wind_beside(OWN)
    assert float(own.scores(fit.free, ["hover 0"]).abs().min()) > 0.0
    library = own.problem.library
    (wind,) = library.effects.values()
    late = replace(wind, of=replace(wind.of, searching=replace(wind.of.searching, from_null=False)))
    begins = replace(library, effects={"wind": late})
    own = replace(own, problem=Problem(begins, own.problem.data, own.problem.segments))
    assert float(own.scores(fit.free, ["hover 0"]).abs().max()) == 0.0


@cache
def drives(*hidden: str, value: float = 1.0) -> Dataset:
    tasks = [make_task(name, MUSHR) for name in ("circle", "reverse_circle")]
    return noisy_runs(MUSHR, tasks, [(key, {"value": value}) for key in hidden], count=2, rows=240, seed=3)


def ready(model: Equations, logs: Dataset, key: str = "offset:steer", *, calibrate: bool = True) -> Prepared:
    """Drives against a model, where one effect competes."""
    exclude = [known.key for known in applicable(model) if known.key != key]
    return prepare(Question(model, logs, MujocoPlant(MUSHR), calibrate=calibrate, exclude=exclude), SILENT)


def test_a_base_that_is_not_calibrated_is_said_to_be_so_and_counts_from_nothing() -> None:
    off = ready(MUSHR.nominal(), drives(), calibrate=False)
    assert SWITCHED_OFF in off.notes
    assert off.flown is off.calibration is None
    assert not off.calibrated
    on = ready(MUSHR.nominal(), drives())
    assert SWITCHED_OFF not in on.notes
    assert on.calibration is not None
    known = replace(on, origin=on.origin + 0.01)
    assert known.calibrated
    as_it_is = uncalibrated(known)
    assert as_it_is.calibration is None
    assert not as_it_is.calibrated
    assert as_it_is.notes == (*known.notes, CONTRADICTED)


@pytest.mark.parametrize(("hidden", "refined"), [((), True), (("gain:speed",), False)], ids=["healthy", "slow"])
def test_the_base_is_refined_where_that_makes_the_logs_likelier(hidden: tuple[str, ...], *, refined: bool) -> None:
    """One that is wrong for the simulator, and right for a car whose speed is less than what was sent."""
    wrong = MUSHR.nominal().substitute({"speed": 0.9 * symbol("speed")})
    found = ready(wrong, drives(*hidden, value=0.9))
    assert (found.searched is not found.library) is refined


def test_what_logs_contradict_of_a_calibration_is_dropped() -> None:
    """Healthy drives, a calibration that says the base steers 0.05 rad aside, and no effect that could undo it."""
    known = ready(MUSHR.nominal(), drives())
    (offset,) = known.candidates
    false = known.origin.clone()
    false[offset.slots] += 0.05
    found = search(replace(known, origin=false, candidates=()), SILENT)
    assert found.prepared.calibration is None
    assert found.selection.chosen == []
    kept = search(known, SILENT)
    assert kept.prepared is known
    assert kept.selection.chosen == []


def test_what_is_found_beside_a_calibrated_base_is_held_against_all_that_the_base_as_it_is_could_explain() -> None:
    """A calibration that names nothing, by next to nothing of its own, where the logs ask for an effect."""
    known = ready(MUSHR.nominal(), drives("offset:steer", value=0.05))
    found = search(replace(known, origin=known.origin + 1e-9, candidates=()), SILENT)
    assert found.prepared.calibration is None
    assert [member.name for member in found.selection.chosen] == ["offset:steer"]


def test_what_would_explain_all_that_is_left_is_suspect_where_it_is_not_beyond_chance() -> None:
    known = ready(MUSHR.nominal(), drives("offset:steer", value=0.05))
    found = search(known, SILENT)
    assert [one.name for one in found.selection.chosen] == ["offset:steer"]
    assert found.suspects() == {}
    for small in (found.selection.chosen, []):
        found.selection.small = tuple(small)
        (said,) = findings_of(found)
        assert said.small is bool(small)
        assert said.values["value"] == pytest.approx(0.05, rel=0.1)
    selection = Selection(known.problems, known.candidates, known.origin)
    assert selection.chosen == []
    alone = replace(found, selection=selection)
    assert alone.suspects() == {}  # it is beyond chance, and would be found
    selection.tested = 10**300
    selection._significant.clear()
    ((key, part),) = alone.suspects().items()
    assert key == "offset:steer"
    assert 0.9 < part <= 1.0


def test_a_constant_of_a_base_may_be_anything_from_none_to_twice_itself() -> None:
    """And one that is nearly zero something small of either sign."""
    base = MUSHR.nominal().substitute({"speed": 0.93 * symbol("speed") + 1e-5})
    constants = {slot.parameter.null: slot.parameter for slot in calibrate._of_constants(base).slots}
    for value in (0.93, 1e-5):
        nearest = min(constants, key=lambda null: abs(abs(null) - value))
        assert abs(nearest) == pytest.approx(value, rel=0.1)
        low, high = constants[nearest].low, constants[nearest].high
        reach = max(value, 1e-3)
        assert (low, high) == pytest.approx((nearest - reach, nearest + reach), abs=1e-3 * reach)
