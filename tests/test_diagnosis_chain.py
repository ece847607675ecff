"""The whole diagnosis on simulated flights with a known effect, and its parts against independent calculations."""

from __future__ import annotations

import pytest
import torch
from noisy_flights import LEFT_OUT, flights, flights_with

from sym2real import rotation
from sym2real.dataset import Dataset
from sym2real.diagnosis import Diagnosis, Gate, diagnose
from sym2real.diagnosis.data.segments import cut
from sym2real.diagnosis.estimate.whitening import Spread, estimate
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.effects import effect
from sym2real.least_squares import root_plus_identity
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic import symbol

# Wind, linear drag, mass, centre of mass, delay, mounting tilt and rotors compete.
OTHERS = (*LEFT_OUT, "rate_loop_gain")


def diagnosed(data: Dataset) -> Diagnosis:
    return diagnose(CRAZYFLIE.nominal(), data, exclude=OTHERS)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "values", "tolerance"),
    [
        ("wind", {"fx": 0.008, "fy": -0.004}, 0.08),
        ("com_offset", {"rx": 0.001}, 0.08),
        ("delay", {"value": 0.04}, 0.08),
        ("rotor_loss", {"rotor": 2.0, "value": 0.1}, 0.08),
    ],
)
def test_the_effect_is_named_with_its_value_and_adding_it_lowers_the_error(
    key: str, values: dict[str, float], tolerance: float
) -> None:
    found = diagnosed(flights_with(key, values))
    assert found.verdict == "EFFECT"
    assert [one.effect for one in found.findings] == [key]
    for name, value in values.items():
        assert found.findings[0].values[name] == pytest.approx(value, rel=tolerance)
    first, last = found.ladder[0].horizons[0.8], found.ladder[-1].horizons[0.8]
    falls = [last[channel].value / first[channel].value for channel in ("position", "attitude")]
    assert min(falls) < 0.7
    equations = found.apply(CRAZYFLIE.nominal())
    assert equations.filters or equations.text() != CRAZYFLIE.nominal().text()


@pytest.mark.slow
def test_nothing_is_found_where_nothing_is_missing() -> None:
    found = diagnosed(flights())
    assert found.findings == ()
    assert found.verdict == "NOTHING_MISSING"
    assert found.gate == Gate()  # nothing that predictions could bear out
    assert found.misfit[1] == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("size", [1.0, 1e4, 1e10, 1e18])
def test_the_root_beside_one_exists_however_far_a_base_runs_away(size: float) -> None:
    """Sensitivities that grow along one direction: the sum of their squares is singular but for rounding."""
    draws = torch.randn(60, 300, 12, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    columns = size * (draws[..., :1] + 1e-9 * draws)
    squares = columns.mT @ columns
    root = root_plus_identity(squares)
    whole = squares + torch.eye(12, dtype=torch.float64)
    torch.testing.assert_close(root @ root.mT, whole, rtol=1e-9, atol=1e-10 * float(whole.max()))


def test_whitening_recovers_the_variances_that_made_the_residual() -> None:
    library = Library.of(CRAZYFLIE.nominal(), [effect("wind", CRAZYFLIE.nominal())])
    problem = Problem(library, flights())
    spread = Spread.of(problem, library.null)
    generator = torch.Generator().manual_seed(0)
    noise = torch.tensor(problem.segments.noise).clone()
    made = torch.randn(spread.start.shape[:2], generator=generator, dtype=torch.float64)
    made *= noise.repeat(problem.segments.length)
    strength = torch.tensor([3.0, 2.0, 1.0, 1.0, 2.0, 1.0], dtype=torch.float64)
    pushes = torch.randn(len(made), 6, 5, generator=generator, dtype=torch.float64) * strength[:, None]
    made += torch.einsum("srdp,sdp->sr", spread.disturbances, pushes)
    found = estimate(spread, made, 2 * problem.segments.noise, problem.segments.channel)
    assert float(found.loss(made[None]).sum()) / found.freedom == pytest.approx(1.0, abs=0.05)
    for name, size, wanted in zip(spread.names, spread.sizes, strength, strict=True):
        assert found.disturbances[name] == pytest.approx(float(size * wanted), rel=0.35)


def test_predictions_with_an_effect_are_those_of_the_composed_equations() -> None:
    base = CRAZYFLIE.nominal()
    library = Library.of(base, [effect(key, base) for key in ("wind", "delay", "mounting_tilt")])
    problem = Problem(library, flights())
    values = library.null
    values[list(library.indices("wind"))] = torch.tensor([0.01, 0.0, -0.005], dtype=torch.float64)
    alone = Library.of(base.substitute({"fx": symbol("fx") + 0.01, "fz": symbol("fz") - 0.005}), [])
    direct = Problem(alone, flights())
    expected = direct.residuals(alone.null[None])
    torch.testing.assert_close(problem.residuals(values[None]), expected, rtol=1e-9, atol=1e-9)


def test_a_segments_first_row_is_where_its_prediction_starts() -> None:
    data = flights()
    segments = cut(data)
    for log, row, start in zip(segments.log, segments.row, segments.start, strict=True):
        measured = torch.as_tensor(data[log].state[row])
        away = data.layouts.state.difference(start, measured)[:3]
        assert float(away.abs().max()) < 5e-3
        turn = rotation.tilt(rotation.multiply(rotation.conjugate(start[3:7]), measured[3:7]))
        assert float(turn) < 0.05
