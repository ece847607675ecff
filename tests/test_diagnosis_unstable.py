"""A robot that falls over within a segment: what its start is off by grows a hundred times before the segment ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sym2real import Layout, Layouts, Trajectory, diagnose
from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import cut, segment_length
from sym2real.diagnosis.pipeline import prepare
from sym2real.diagnosis.predict.instability import steady_length, unstable_rate
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.question import Question
from sym2real.stages import Stages
from sym2real.symbolic import Equations

STEP, FALL = 0.01, 10.0  # s, 1/s: e-folding of a tenth of a second
LAYOUTS = Layouts(Layout.of(["lean", "lean_rate"]), Layout.of(["push"]))
MODEL = Equations.parse(
    LAYOUTS,
    {
        # Euler's midpoint.
        "lean": "lean + dt*(lean_rate + dt/2*(fall**2*sin(lean) + push))",
        "lean_rate": "lean_rate + dt*(fall**2*sin(lean + dt/2*lean_rate) + push)",
    },
    dt=STEP,
    parameters={"dt": STEP, "fall": FALL},
)


def balanced(seed: int, rows: int = 800, fall: float = FALL) -> Trajectory:
    """A pendulum held upright by a controller that sees noise, as SciPy's integrator moves it."""
    rng, state, states, pushes = np.random.default_rng(seed), np.array([0.05, 0.0]), [], []
    wanted = 0.0
    for _ in range(rows):
        measured = state + rng.standard_normal(2) * (0.002, 0.02)
        wanted += STEP * (rng.standard_normal() * 3.0 - wanted) / 0.3
        push = -3.0 * FALL**2 * (measured[0] - 0.1 * wanted) - 3.0 * FALL * measured[1] + 5.0 * rng.standard_normal()
        states.append(measured)
        pushes.append([push])
        moved = solve_ivp(lambda _, s, u=push: (s[1], fall**2 * np.sin(s[0]) + u), (0.0, STEP), state, rtol=1e-9)
        state = moved.y[:, -1]
    return Trajectory.from_arrays(np.array(states), np.array(pushes), LAYOUTS, dt=STEP, name=f"log {seed}")


def test_nothing_is_missing_in_logs_of_a_healthy_one() -> None:
    found = diagnose(MODEL, Dataset([balanced(seed) for seed in range(4)]))
    assert (found.verdict, found.findings) == ("NOTHING_MISSING", ())
    assert found.misfit[0] == pytest.approx(1.0, abs=0.05)


def test_a_number_that_is_wrong_is_told_from_a_gain() -> None:
    """From the base no way leads to it over half a second: errors of a start grow 150 times in that."""
    (finding,) = diagnose(MODEL, Dataset([balanced(seed, fall=1.1 * FALL) for seed in range(4)])).findings
    assert (finding.effect, finding.values["factor"]) == ("parameter:fall", pytest.approx(1.1, abs=0.003))


def test_segments_end_before_errors_of_a_start_have_grown_far() -> None:
    """Hung the other way round the robot swings, and nothing grows."""
    library, upright = Library.of(MODEL, []), balanced(0)
    hanging = replace(upright, state=upright.state + np.array([np.pi, 0.0]))
    assert unstable_rate(library, Dataset([upright])) == pytest.approx(FALL, rel=0.02)
    assert unstable_rate(library, Dataset([hanging])) < 0.1 * FALL
    assert steady_length(library, Dataset([upright])) == pytest.approx(2.0 / FALL / STEP, abs=1)
    assert steady_length(library, Dataset([hanging])) == segment_length(LAYOUTS.state, STEP)
    assert prepare(Question(MODEL, upright), Stages(lambda _: None)).whitening.length < 25


def test_all_that_a_robot_of_one_s_own_measures_is_compared() -> None:
    """Its rates have noise of their own; that is no reason to leave its coordinates out."""
    segments = cut(Dataset([balanced(0)]))
    assert [segments.layout.fields[number].name for number in segments.channel] == ["lean", "lean_rate"]
