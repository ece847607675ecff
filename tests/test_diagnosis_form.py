"""An effect in the place of one that the catalogue lacks is said to vary; one that is there is the same everywhere."""

from __future__ import annotations

from functools import cache

import pytest
from standard_set import Case, simulate_case

from sym2real.diagnosis.estimate.fit import Hypothesis, Problems
from sym2real.diagnosis.estimate.whitening import Spread, estimate
from sym2real.diagnosis.predict.candidate import candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.search.select import Selection
from sym2real.diagnosis.unexplained.dependence import Terms, find_dependences
from sym2real.diagnosis.unexplained.leftover import Leftover
from sym2real.effects import effect
from sym2real.report.leftover import statement
from sym2real.robots import ROBOTS


@cache
def said_of(found: str, key: str, value: float) -> Leftover | None:
    """What is said of an effect that was found in short drives in MuJoCo with another one, or with itself.

    The car's tyres slip, which its equations lack; that is free in every fit. In shorter drives a lag that is taken
    for a limit leaves little.
    """
    data = simulate_case(Case("mushr", ((key, {"value": value}),), seed=11), rows=420)
    equations, slips = ROBOTS["mushr"].nominal(), ["lateral_slip", "lever_arm"]
    library = Library.of(equations, [effect(name, equations) for name in (*slips, found)])
    problem = Problem(library, data)
    spread, segments = Spread.of(problem, library.null), problem.segments
    low, high = library.bounds
    nuisance = {slot: (float(low[slot]), float(high[slot])) for name in slips for slot in library.indices(name)}
    whitening = estimate(spread, problem.residuals(library.null[None])[0], segments.noise, segments.channel)
    (chosen,) = (candidate for candidate in candidates(library, data) if candidate.name == found)
    starts = [chosen.started(library.null, level) for level in chosen.starts] or [library.null]
    for _ in range(2):
        problems = Problems(problem, whitening, nuisance)
        fit = min(problems.fit([Hypothesis(chosen.free, start) for start in starts], 8), key=lambda one: one.total)
        whitening = estimate(spread, problem.residuals(fit.values[None])[0], segments.noise, segments.channel)
        starts = [fit.values]
    selection = Selection(Problems(problem, whitening, nuisance), [chosen], library.null)
    selection.put([chosen], selection.problems.fit([Hypothesis(chosen.free, fit.values)], 8)[0])
    left = find_dependences(Terms.of(selection, spread, None))
    return next((leftover for leftover in left if leftover.matters), None)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "value"), [("lag:steer", 0.1), ("gain:steer", 0.85), ("lag:speed", 0.3), ("rolling_resistance", 0.5)]
)
def test_an_effect_that_is_there_is_the_same_everywhere(key: str, value: float) -> None:
    assert said_of(key, key, value) is None


@pytest.mark.slow
def test_a_length_in_place_of_a_time_goes_with_the_speed() -> None:
    """A servo that lags by 0.1 s relaxes over 0.1 m at 1 m/s, and over 0.2 m at 2 m/s."""
    left = said_of("relaxation_length", "lag:steer", 0.1)
    assert left is not None
    assert statement(left) in {f"a change of relaxation_length that depends on {of}speed" for of in ("", "forward ")}
    assert left.term.startswith("0.") and " m where " in left.term


@pytest.mark.slow
def test_a_limit_in_place_of_a_lag_leaves_something() -> None:
    """A speed that follows within 0.3 s is no acceleration limit: it changes faster the more it is off."""
    left = said_of("rate_limit:speed", "lag:speed", 0.3)
    assert left is not None
