"""Values and intervals of findings: what the base's own errors contribute is taken away, and trim is heeded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from noisy_flights import flights_with
from standard_set import Case, simulate_case
from weighed_problems import weighed_problems

from sym2real.dataset import Dataset
from sym2real.diagnosis import Estimate, diagnose
from sym2real.diagnosis.adding import try_effect
from sym2real.diagnosis.data.segments import COMPARED, cut
from sym2real.diagnosis.estimate import calibrate
from sym2real.diagnosis.estimate.calibrate import refined
from sym2real.diagnosis.estimate.fit import Fit, Hypothesis, Problems
from sym2real.diagnosis.estimate.preparation import whiten
from sym2real.diagnosis.estimate.significance import half_widths
from sym2real.diagnosis.estimate.simulator import flown_along
from sym2real.diagnosis.predict.candidate import candidates, library_for
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.search.intervals import averaged_ends, estimates, unresolved
from sym2real.diagnosis.search.select import Selection, reported
from sym2real.effects import effect
from sym2real.effects.kind import NOT_NEGATIVE, Parameter
from sym2real.experiments.models import cached_base
from sym2real.plants import MujocoPlant
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.robots.nominal_car import car
from sym2real.symbolic import Equations, symbol
from sym2real.trajectory import Trajectory

SPEED = 1.5  # m/s
LOGS, ROWS, OWN = 8, 130, 0.002  # N, constant force that the wrong base has


@pytest.fixture(scope="module")
def drives() -> Dataset:
    return simulate_case(Case("mushr"), LOGS, ROWS)


def _fit(base: Equations, data: Dataset, key: str) -> tuple[Problems, Fit, calibrate.Calibration]:
    """One effect fitted, with a calibration that knows no effect of the base's own."""
    library = Library.of(base, [effect(key, base)])
    problem = Problem(library, data)
    whitened = whiten(problem, candidates(library, data))
    problems = Problems(whitened.problem, whitened.whitening)
    free = tuple(range(len(library.slots)))
    (fit,) = problems.fit([Hypothesis(free, library.null)], 4)
    flown, _ = flown_along(base, MujocoPlant(CRAZYFLIE), data)
    assert flown is not None
    return problems, fit, calibrate.calibrated(library, [], flown, whitened.whitening)


@pytest.mark.slow
def test_a_disturbance_that_the_base_alone_has_is_not_the_robots() -> None:
    right = CRAZYFLIE.nominal()
    wrong = right.substitute({"fx": symbol("fx") + OWN})
    data = simulate_case(Case("crazyflie", (("wind", {"fx": 0.02, "fy": 0.01}),), 3), LOGS, ROWS)
    values = []
    for base in (right, wrong):
        problems, fit, own = _fit(base, data, "wind")
        values += [float(fit.values[0]), float(calibrate.cleaned(problems, fit, own).values[0])]
    assert values[2] == pytest.approx(values[0] - OWN, rel=0.01)
    assert values[3] == pytest.approx(values[1], rel=0.005)
    assert calibrate.cleaned(problems, fit, None) is fit


def test_the_second_that_leads_to_a_crash_calibrates_nothing() -> None:
    """What a robot does as it tips over is nothing that a base describes; here one is flown into the ground."""
    (log,), fell = flights_with("", {}, count=1), np.linspace(1.0, -0.35, 220)
    state = log.state.copy()
    state[:, log.layouts.state.index("z")] = fell
    fallen = replace(log, state=state, action=0.9 * log.action, extra={})  # so does what is sent again
    flown, _ = flown_along(CRAZYFLIE.nominal(), MujocoPlant(CRAZYFLIE), Dataset([fallen]))
    assert flown is not None
    assert 100 <= len(flown[0]) < 170
    assert flown[0].column("z")[-1] > 0.15


def test_what_nothing_tells_of_a_base_is_none() -> None:
    """A car that rolls without slip has no speed to the side: how strong a drag there would be, no drive says."""
    base, drives = MUSHR.nominal(), simulate_case(Case("mushr", (), 3), 4, 200)
    library = Library.of(base, [effect(key, base) for key in ("linear_drag", "wind")])
    tried = candidates(library, drives)
    flown, _ = flown_along(base, MujocoPlant(MUSHR), drives)
    assert flown is not None
    own = calibrate.calibrated(library, tried, flown, whiten(Problem(library, drives), tried).whitening)
    ahead, aside = ((own.values - library.null) / library.scale).tolist()[:2]
    assert 0.1 < ahead < 2.0  # its tyres creep
    assert abs(aside) < 0.1


def test_intervals_hold_a_value_that_trim_scatters_from_run_to_run(drives: Dataset) -> None:
    base = MUSHR.nominal()
    library = library_for(base, drives, ("*",), ("gain:speed", "offset:steer"))
    problem = Problem(library, drives)
    whitened = whiten(problem, ())
    problems, free = Problems(whitened.problem, whitened.whitening), (0, 1)
    (fit,) = problems.quadratics([Hypothesis(free, library.null)])
    generator = torch.Generator().manual_seed(0)
    log, whole, inside = torch.as_tensor(problem.segments.log), fit.curvature.sum(0), []
    for _ in range(300):
        # Every run has its own value, and every segment its noise, whose variance is the curvature.
        own = 3.0 * torch.linalg.inv(whole).diagonal().sqrt() * torch.randn(LOGS, 2, generator=generator).double()
        noise = torch.randn(len(log), 2, 1, generator=generator).double()
        scores = (torch.linalg.cholesky(fit.curvature + 1e-9 * whole) @ noise)[..., 0]
        scores -= torch.einsum("sab,sb->sa", fit.curvature, own[log])
        step = torch.linalg.solve(whole, -scores.sum(0))
        drawn = replace(fit, gradient=scores + torch.einsum("sab,b->sa", fit.curvature, step))
        inside.append(step.abs() <= half_widths(problems, drawn))
    assert torch.stack(inside).double().mean(0).min() > 0.93


def test_a_refined_base_keeps_its_velocities(drives: Dataset) -> None:
    wrong = MUSHR.nominal().substitute({"speed": 0.93 * symbol("speed")})
    flown, _ = flown_along(wrong, MujocoPlant(MUSHR), drives)
    assert flown is not None
    segments, missed = cut(flown, (*COMPARED, "velocity")), []
    for base in (wrong, refined(Library.of(wrong, []), flown, drives)):
        problem = Problem(Library.of(base, []), flown, segments)
        errors = problem.residuals(problem.library.null[None]).reshape(-1, len(segments.compared))
        places = [i for i, n in enumerate(segments.channel) if segments.layout.fields[n].name == "velocity"]
        missed.append(float(errors[:, places].square().mean().sqrt()))
    assert missed[1] < 0.7 * missed[0]  # from positions alone it would double


@pytest.mark.slow
def test_a_lag_is_known_to_no_less_than_a_sixth_of_a_step_and_its_interval_holds_it() -> None:
    drives = simulate_case(Case("mushr", (("lag:steer", {"value": 0.05}),), seed=3), 4, 200)
    tried = try_effect(cached_base(MUSHR), "lag:steer", drives, MujocoPlant(MUSHR))  # which has the servo's own time
    found = tried.finding.parameters["value"]
    assert found.high - found.low >= 2 * MUSHR.dt / 6
    assert found.low <= 0.05 <= found.high


def test_what_a_step_hides_of_a_late_turn_goes_by_way_or_speed(drives: Dataset) -> None:
    library = Library.of(MUSHR.nominal(), [effect(key, MUSHR) for key in ("relaxation_length", "yaw_inertia", "wind")])
    problem, speed = (
        Problem(library, drives),
        np.median(np.linalg.norm(np.hstack([_velocity(log) for log in drives]), axis=0)),
    )
    hidden = {
        (slot.effect, slot.parameter.name): unresolved(problem, index) for index, slot in enumerate(library.slots)
    }
    assert hidden.pop(("relaxation_length", "value")) == pytest.approx(MUSHR.dt / 6 * speed)
    assert hidden.pop(("yaw_inertia", "value")) == pytest.approx(MUSHR.dt / 6 / speed)
    assert {*hidden.values()} == {0.0}


@pytest.mark.parametrize(
    ("key", "value", "most"),
    [
        ("offset:steer", 0.05, 0.05),
        ("gain:steer", 0.98, 0.02),
        ("gain:steer", 1.5, 0.5),
        ("gain:steer", 0.25, 0.25),  # of what is left of it, which is less than what it lacks
    ],
)
def test_an_interval_without_noise_is_three_hundredths_of_what_an_effect_changes(
    drives: Dataset, key: str, value: float, most: float
) -> None:
    library = Library.of(MUSHR.nominal(), [effect(key, MUSHR)])
    selection = Selection(weighed_problems(library, drives), candidates(library, drives), library.null)
    (only,) = selection.candidates
    values = torch.tensor([value], dtype=torch.float64)
    (fit,) = selection.problems.quadratics([Hypothesis(only.free, values)])
    found = estimates(selection, only, replace(fit, gradient=0 * fit.gradient), None)["value"]
    assert found.value == pytest.approx(value)
    assert found.high - found.low == pytest.approx(2 * 0.03 * most)


def _velocity(log: Trajectory) -> np.ndarray:
    return np.stack([log.column("vx"), log.column("vy")])


@pytest.mark.parametrize(("value", "unit", "text"), [(0.00512, "kg", "0.00512 kg"), (1.0, "1", "1"), (0.3, "", "0.3")])
def test_a_value_is_said_with_its_unit_and_without_the_unit_one(value: float, unit: str, text: str) -> None:
    assert Estimate(value, value, value, unit).text == text


def _late_bicycle(seed: int, wheelbase: float, late: float, size: float = 0.3, jitter: float = 0.4) -> Trajectory:
    """Steering that acts some s after it was sent, at uneven stamps; integrated every ms."""
    rng = np.random.default_rng(seed)
    stamps = MUSHR.dt * (1.0 + np.arange(300) + rng.uniform(-jitter, jitter, 300))
    steer = size * np.sin(np.cumsum(rng.uniform(0.02, 0.15, 300))) + 0.03 * rng.standard_normal(300)
    fine = np.arange(0.0, stamps[-1], 1e-3)
    sent = steer[np.clip(np.searchsorted(stamps, fine - late, side="right") - 1, 0, None)]
    rate = SPEED * np.tan(sent) / wheelbase
    yaw = np.concatenate([[0.0], np.cumsum(rate * 1e-3)[:-1]])
    place = [np.concatenate([[0.0], np.cumsum(SPEED * way(yaw) * 1e-3)[:-1]]) for way in (np.cos, np.sin)]
    rows = np.searchsorted(fine, stamps[:-1])
    state = np.stack([*place, np.sin(yaw), np.cos(yaw), SPEED * np.cos(yaw), SPEED * np.sin(yaw), rate], axis=1)[rows]
    action = np.stack([steer[:-1], np.full(299, SPEED)], axis=1)
    noisy = MUSHR.layouts.state.normalise(torch.as_tensor(state + 0.002 * rng.standard_normal(state.shape))).numpy()
    return Trajectory(stamps[:-1], noisy, action, np.zeros((299, MUSHR.layouts.inputs.size)), MUSHR.layouts)


def test_the_interval_of_a_delay_holds_it_where_commands_change_within_steps() -> None:
    """Rows at uneven stamps are brought to even ones: commands then begin up to half a step off."""
    late, wheelbase = 0.17, 0.3
    logs = [_late_bicycle(seed, wheelbase, late) for seed in range(4)]
    tried = try_effect(car(wheelbase), ["delay:steer"], logs)
    (found,) = tried.findings
    value = found.parameters["value"]
    assert value.low <= late <= value.high
    assert value.high - value.low < 1.3 * MUSHR.dt
    assert value.low >= 0.0
    share = found.parameters.get("mean_share")
    assert share is None or 0.0 <= share.low <= share.high <= 1.0


@pytest.mark.parametrize(
    ("size", "named", "value", "group"),
    [(0.4, "wheelbase", 1.2, {"wheelbase"}), (0.12, "gain:steer", 1 / 1.2, {"gain:steer", "wheelbase", "understeer"})],
)
def test_a_wrong_wheelbase_is_a_steering_gain_as_long_as_angles_are_small(
    size: float, named: str, value: float, group: set[str]
) -> None:
    logs = Dataset([_late_bicycle(seed, 0.3, 0.0, size, 0.0) for seed in range(4)])
    found = diagnose(car(0.25), logs).findings[0]
    assert (found.effect, {*found.group}) == (named, group)  # at one speed tyres do as much
    assert found.values["value"] == pytest.approx(value, rel=0.02)


@pytest.mark.parametrize(
    ("estimate", "said"),
    [
        (Estimate(0.09834, 0.09474, 0.10194, "N"), "0.0983 ± 0.0036 N"),
        (Estimate(123.4, 111.4, 135.4, "m/s"), "123 ± 12 m/s"),
        (Estimate(1.02, 0.97, 1.07, "1"), "1.020 ± 0.050"),
        (Estimate(2.13, 0.41, 6.3, "rad/s"), "2.1 (0.4 … 6.3) rad/s"),
        (Estimate(0.995, 0.298, 0.997, "1"), "0.9950 (0.2980 … 0.9970)"),  # a mass that surely is not the described
        (Estimate(0.5, -np.inf, np.inf, "N"), "0.5 N"),
        (Estimate(0.0, 0.0, 15.0, "N", determined=False), "undetermined"),
        (Estimate(0.5, 0.5, 0.5, "N"), "0.5 N"),
    ],
)
def test_a_sentence_gives_two_digits_of_what_is_unsure(estimate: Estimate, said: str) -> None:
    assert estimate.with_half_width == said


@pytest.mark.parametrize("weights", [(1.0,), (0.98, 0.02), (0.8, 0.2), (0.4, 0.5, 0.1)])
def test_an_interval_holds_what_draws_from_all_sets_say_but_a_fortieth_at_either_end(
    weights: tuple[float, ...],
) -> None:
    shifts = np.array([0.0, 1.5, -4.0])[: len(weights)]
    low, high = averaged_ends(3.0, 0.5, torch.tensor(shifts), torch.tensor(weights, dtype=torch.float64))
    rng = np.random.default_rng(1)
    drawn = 3.0 + rng.choice(shifts, 400_000, p=weights) + rng.normal(0.0, 0.5 / 1.96, 400_000)
    least, most = np.quantile(drawn, [0.025, 0.975])
    np.testing.assert_allclose([low, high], [min(least, 2.5), max(most, 3.5)], atol=0.02)


def test_a_value_without_a_width_of_its_own_is_as_unsure_as_sets_differ() -> None:
    assert averaged_ends(3.0, 0.0, torch.tensor([0.0, 1.5, -4.0]), torch.tensor([0.6, 0.3, 0.1])) == (-1.0, 4.5)


def test_an_interval_holds_that_of_the_value_that_is_given_however_little_its_set_weighs() -> None:
    ends = averaged_ends(3.0, 0.5, torch.tensor([0.0, 2.0]), torch.tensor([0.001, 0.999]))
    assert ends == (2.5, pytest.approx(5.5, abs=0.01))


def test_what_calibration_says_of_the_base_is_taken_away_from_values() -> None:
    gain = Parameter("value", "1", null=1.0, low=0.2, high=3.0, scale=0.1)
    force = Parameter("value", "N", null=0.0, low=-1.0, high=1.0, scale=0.1)
    delay = Parameter("value", "s", null=0.0, low=0.0, high=1.0, scale=0.1, domain=NOT_NEGATIVE)
    turns = Parameter("value", "rad/s", null=7.0, low=1.0, high=9.0, scale=0.1)
    assert reported(1.2, 0.8, gain) == pytest.approx(1.5)  # a factor of a factor
    assert reported(1.2, -0.8, gain) == 1.2  # a base that turns the sign about says nothing of the size
    assert reported(0.3, 0.1, force) == pytest.approx(0.2)
    assert reported(0.3, 0.1, delay) == pytest.approx(0.2)
    assert reported(0.1, 0.3, delay) == 0.0  # nothing arrives before it was sent
    assert reported(8.0, 7.5, turns) == 8.0
