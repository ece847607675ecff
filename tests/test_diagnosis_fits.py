"""Fits within bounds, what they leave of logs that took no part, and the fit of everything that may begin late."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import torch
from motor_flights import equations, motor_flights, with_speeds
from noisy_flights import flights_with
from scipy.optimize import lsq_linear
from standard_set import Case, simulate_case
from weighed_problems import weighed_problems

from sym2real.diagnosis.estimate.calibrate import calibrated
from sym2real.diagnosis.estimate.fit import Fit, Hypothesis, Problems, nuisance_of
from sym2real.diagnosis.estimate.full_model import full_fit
from sym2real.diagnosis.estimate.preparation import whiten
from sym2real.diagnosis.estimate.simulator import flown_along
from sym2real.diagnosis.estimate.whitening import Spread
from sym2real.diagnosis.predict.candidate import Candidate, candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.effects import effect
from sym2real.least_squares import solve_within
from sym2real.plants import MujocoPlant
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.symbolic import symbol

WIND = {"fx": 0.02, "fy": -0.01}


@cache
def problems(*keys: str, added: float = 0.0) -> tuple[Problems, tuple[Candidate, ...]]:
    """Flights in a wind, or with a mass more, and what may explain them."""
    base = CRAZYFLIE.nominal()
    data = flights_with("added_mass", {"value": added}) if added else flights_with("wind", WIND)
    library = Library.of(base, [effect(key, base) for key in keys])
    return weighed_problems(library, data), candidates(library, data)


def wind_fit() -> tuple[Problems, Fit]:
    weighed, (wind,) = problems("wind")
    (fit,) = weighed.fit([Hypothesis(wind.free, weighed.library.null)])
    return weighed, fit


def test_a_fit_is_where_no_step_leads_lower() -> None:
    weighed, fit = wind_fit()
    assert fit.values.tolist()[:2] == pytest.approx(list(WIND.values()), rel=0.1)
    assert float(weighed.best_step(fit).abs().max()) < 1e-3
    for part in (-1e-2, 1e-2):
        beside = fit.values + part * weighed.library.scale
        assert float(weighed.totals([beside])) > fit.total
    assert weighed.fit([Hypothesis(fit.free, weighed.library.null)])[0] is fit  # asked again


@pytest.mark.parametrize("unknowns", [2, 4, 8])
def test_a_step_within_bounds_is_that_of_another_method(unknowns: int) -> None:
    """Nearly all of SciPy's bounded-variable least squares; cut at the bounds alone, most steps lose what they save."""
    rng, cut, ours = np.random.default_rng(unknowns), list[float](), list[float]()
    for _ in range(50):
        root, wanted = rng.normal(size=(unknowns + 2, unknowns)), 2.0 * rng.normal(size=unknowns + 2)
        high = rng.uniform(0.05, 1.0, unknowns)
        low = -high * rng.uniform(0.0, 1.0, unknowns)
        matrix, vector = root.T @ root, root.T @ wanted
        tensors = (torch.as_tensor(part) for part in (matrix[None], vector[None], low, high))
        found = solve_within(*tensors)[0].numpy()
        assert np.all((low <= found) & (found <= high))

        def saved(step: np.ndarray, matrix: np.ndarray = matrix, vector: np.ndarray = vector) -> float:
            return float(vector @ step - step @ matrix @ step / 2)

        most = saved(lsq_linear(root, wanted, (low, high), method="bvls").x)
        ours.append(saved(found) / most)
        cut.append(saved(np.clip(np.linalg.solve(matrix, vector), low, high)) / most)
    assert max(ours) < 1.0 + 1e-6
    assert np.mean(ours) > 0.98
    assert np.mean(cut) < np.mean(ours) - 0.05 or unknowns == 2


def test_what_is_held_out_is_the_loss_of_a_fold_under_the_values_of_the_others() -> None:
    """To first order in the step that the others ask for a force is linear."""
    weighed, fit = wind_fit()
    by_fold = weighed.by_fold(fit)
    for fold, loss in enumerate(weighed.held_out(fit).tolist()):
        others = torch.as_tensor(weighed.folds != fold)
        values = weighed.moved(fit, weighed.best_step(fit.of_segments(others)))
        losses = weighed.whitening.loss(weighed.problem.residuals(values[None]))[0]
        assert loss == pytest.approx(float(losses[~others].sum()), rel=1e-3)
        assert loss > float(by_fold.loss[fold])
    assert float(weighed.held_out_segments(fit).sum()) == pytest.approx(float(weighed.held_out(fit).sum()))


def test_no_step_leads_beyond_a_bound_and_what_the_data_do_not_tell_stays() -> None:
    weighed, fit = wind_fit()
    low, high = (bound[list(fit.free)] for bound in weighed.library.bounds)
    far = torch.full((len(fit.free),), 1e9, dtype=torch.float64)
    assert torch.equal(weighed.moved(fit, far)[list(fit.free)], high)
    assert torch.equal(weighed.moved(fit, -far)[list(fit.free)], low)
    step = weighed.best_step(replace(fit, gradient=-1e9 * torch.ones_like(fit.gradient)))
    scale = weighed.library.scale[list(fit.free)]
    torch.testing.assert_close(fit.values[list(fit.free)] + step * scale, high)
    widths = ((high - low) / scale).square()
    told = fit.curvature.sum(0).diagonal() * widths
    for factor, moves in ((0.99, False), (1.01, True)):  # over its bounds it changes one square
        faint = replace(fit, curvature=fit.curvature * factor / told.max())
        assert bool(weighed.identifiable(faint).any()) is moves
        assert torch.equal(weighed.moved(faint, far), fit.values) is not moves


@pytest.mark.parametrize(("rise", "part"), [(0.05, 1.0), (0.5, 0.4), (5.0, 0.1), (50.0, 0.0)])
def test_a_step_is_as_long_as_what_all_segments_were_to_lose_holds_to_a_tenth(rise: float, part: float) -> None:
    """Nothing, they say; in truth the loss rises by so much, with the step's square."""
    weighed, fit = wind_fit()
    curvature = fit.curvature.sum(0)
    step = torch.zeros(len(curvature), dtype=torch.float64)
    step[0] = (rise * fit.total / curvature[0, 0]) ** 0.5
    gradient = torch.zeros_like(fit.gradient)
    gradient[0] = -curvature @ step
    # Just identifiable: over its bounds the loss of hundreds changes by one.
    low, high = (bound[list(fit.free)] for bound in weighed.library.bounds)
    told = curvature.diagonal() * ((high - low) / weighed.library.scale[list(fit.free)]).square()
    flat = replace(fit, gradient=0 * fit.gradient, curvature=1.01 * fit.curvature / told.min())
    bounded = weighed.best_step(replace(fit, gradient=gradient))
    torch.testing.assert_close(bounded, step, rtol=1e-6, atol=1e-9)
    taken = weighed.sure_step(replace(fit, gradient=gradient), flat)
    torch.testing.assert_close(taken, part * step, rtol=1e-6, atol=1e-9)


def test_nuisance_is_free_about_what_is_known_of_the_base() -> None:
    library = problems("rate_loop_gain", "wind")[0].library
    free = nuisance_of(library, library.null)
    assert free.keys() == {*library.indices("rate_loop_gain")}
    about_another = nuisance_of(library, 2.0 * library.null)
    for slot, (low, high) in free.items():
        assert low == pytest.approx(1 / high)
        assert about_another[slot] == pytest.approx((2 * low, 2 * high))


@pytest.mark.parametrize("added", [0.003, 0.0])
def test_the_fit_of_everything_tries_an_effect_without_a_null_from_its_starts(added: float) -> None:
    """A mass that acts from a threshold on, were there one: taken where it saves much, and not where it does not."""
    weighed, tried = problems("added_mass", "wind", added=added)
    mass, wind = tried
    late = replace(mass, starts=(0.001, 0.004), needs_start=True)
    null = weighed.library.null
    first = full_fit(weighed, [late, wind], null)
    assert first[mass.slots].tolist() == pytest.approx([added], abs=2e-4)
    assert (first[mass.slots].tolist() == [0.0]) is (added == 0.0)
    again = full_fit(weighed, [late, wind], null, first)
    assert again[mass.slots].tolist() == pytest.approx([added], abs=2e-4)
    without = full_fit(weighed, [late, wind], null, full_fit(weighed, [wind], null))
    assert without[mass.slots].tolist() == [0.0]  # what was not taken is not taken up again
    np.testing.assert_allclose(full_fit(weighed, [], null), null)


def test_of_what_a_base_gets_wrong_in_the_simulator_that_is_said_which_explains_it() -> None:
    """One that steers 0.05 rad aside: an offset, and next to nothing of what else competes."""
    base, drives = MUSHR.nominal().substitute({"steer": symbol("steer") + 0.05}), simulate_case(Case("mushr"), 2, 200)
    library = Library.of(base, [effect(key, base) for key in ("gain:steer", "offset:steer", "gain:speed")])
    flown, _ = flown_along(base, MujocoPlant(MUSHR), drives)
    assert flown is not None
    weighed, tried = weighed_problems(library, drives), candidates(library, drives)
    values = calibrated(library, tried, flown, weighed.whitening).values
    found = dict(zip((slot.effect for slot in library.slots), values.tolist(), strict=True))
    assert found["offset:steer"] == pytest.approx(-0.05, rel=0.1)
    assert found["gain:steer"] == pytest.approx(1.0, abs=0.03)
    late = [replace(one, needs_start=True) for one in tried]
    assert torch.equal(calibrated(library, late, flown, weighed.whitening).values, library.null)


def test_where_a_base_is_far_off_disturbances_do_what_they_do_to_the_model_that_fits() -> None:
    """Inertia 25 times too small: that model turns over, and what it predicts of a start or a push is no robot's."""
    data = with_speeds(motor_flights(every=1, seconds=2.0, dither=0.03, names=("circle", "hover")))
    base = equations(unit="rad/s", every=1, inertia=1 / 25)
    library = Library.of(base, [effect("torque_scale", base)])
    found = whiten(Problem(library, data), candidates(library, data))
    assert found.values.tolist() == pytest.approx([1 / 25] * 3, rel=0.05)
    null, fitted = (Spread.of(found.problem, values) for values in (library.null, found.values))
    for name in ("start", "disturbances"):
        own, of_base, of_model = (getattr(spread, name) for spread in (found.spread, null, fitted))
        assert float((own - of_model).abs().max()) < 0.02 * float((own - of_base).abs().max())
