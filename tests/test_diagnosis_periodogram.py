"""What a force that swings is estimated by, on forces that are known: least squares, its scatter, its phases."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import torch
from noisy_flights import flights, flights_with
from torch import Tensor
from weighed_problems import weighed_problems

from sym2real.dataset import Dataset
from sym2real.diagnosis.estimate import swing
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.estimate.swing import Rows, Swing, find_swing, smallest_swings
from sym2real.diagnosis.predict.library import Library
from sym2real.effects.inputs import ANGLE
from sym2real.robots import CRAZYFLIE

OMEGA, PIECE, PIECES, SEGMENTS, LOGS = 7.0, 0.1, 5, 14, 3  # rad/s, s
PHASES = (0.3, -2.0, 1.1)


def known_rows(forces: Sequence[str] = ("fx", "fy"), seed: int = 0) -> Rows:
    """Pieces of three logs, the first of which is number one, that no force has moved."""
    rng, count = np.random.default_rng(seed), len(forces)
    log = np.repeat(np.arange(1, LOGS + 1), SEGMENTS)
    inside = torch.arange(SEGMENTS * PIECES, dtype=torch.float64).reshape(SEGMENTS, PIECES).repeat(LOGS, 1)
    root = torch.as_tensor(rng.standard_normal((len(log), count * PIECES, 2 * count * PIECES)))
    curvature = (root @ root.mT).reshape(len(log), count, PIECES, count, PIECES)
    motion = torch.as_tensor(rng.standard_normal((len(log), PIECES, 4)))
    return Rows((inside + 0.5) * PIECE, motion, curvature.new_zeros(len(log), count, PIECES), curvature, log)


def wave(rows: Rows, size: float = 1.0, omega: float = OMEGA) -> Tensor:
    """A swing with the phase of each log ``# (S, P)``."""
    return size * torch.sin(omega * rows.time + torch.tensor((0.0, *PHASES))[rows.log][:, None])


def pushed(rows: Rows, *forces: Tensor) -> Rows:
    """What the errors of a model are that lacks these forces: predicted less measured."""
    for place, force in enumerate(forces):
        rows = rows.with_force(place, -force)
    return rows


def left(rows: Rows, force: Tensor, shapes: Tensor) -> float:
    """Whitened squares of a force ``# (S, D, P)`` that shapes of time ``# (S, P, k)`` do not explain, log by log."""
    total, count = 0.0, force.shape[1]
    for log in np.unique(rows.log):
        whitened, columns = [], []
        for one in np.flatnonzero(rows.log == log):
            root = torch.linalg.cholesky(rows.curvature[one].flatten(2).flatten(0, 1)).mT
            whitened.append(root @ force[one].flatten())
            columns.append(root @ torch.block_diag(*[shapes[one]] * count))
        measured, matrix = torch.cat(whitened).numpy(), torch.cat(columns).numpy()
        best = np.linalg.lstsq(matrix, measured, rcond=None)[0]
        total += float(np.square(measured - matrix @ best).sum())
    return total


def test_a_peak_is_what_sine_and_cosine_explain_beside_a_constant_and_a_trend_in_every_log() -> None:
    rows, rng = known_rows(), np.random.default_rng(1)
    force = torch.as_tensor(rng.standard_normal((len(rows.log), 2, PIECES)))
    plain = torch.stack([torch.ones_like(rows.time), rows.time], dim=-1)
    omegas = np.array([3.0, OMEGA, 11.0])
    expected = []
    for omega in omegas:
        angle = omega * rows.time
        both = torch.cat([angle.sin()[..., None], angle.cos()[..., None], plain], dim=-1)
        expected.append(left(rows, force, plain) - left(rows, force, both))
    forced = pushed(rows, force[:, 0], force[:, 1])
    np.testing.assert_allclose(swing._falls(forced, omegas), expected, rtol=1e-6)
    steady = pushed(rows, torch.ones_like(rows.time), 0.4 * rows.time)
    assert np.abs(swing._falls(steady, omegas)).max() < 1e-6 * np.abs(swing._falls(forced, omegas)).max()


def test_a_frequency_scatters_as_its_deviation_says_and_about_the_true_one() -> None:
    rows, rng = known_rows(("fx",)), np.random.default_rng(2)
    forced = pushed(rows, wave(rows, 1.5))
    drawn = [
        swing._refined(replace(forced, gradient=forced.gradient + rows.of_noise(rng).gradient), OMEGA + 0.01, 0.05)
        for _ in range(150)
    ]
    omegas, deviations = np.array(drawn).T
    assert omegas.mean() == pytest.approx(OMEGA, abs=4 * omegas.std() / 150**0.5)
    assert deviations.mean() == pytest.approx(omegas.std(), rel=0.2)
    beside = np.linspace(OMEGA, OMEGA + 3 * np.pi / (SEGMENTS * PIECES * PIECE), 60)
    trough = float(beside[swing._falls(forced, beside).argmin()])
    assert swing._refined(forced, trough, 0.05) == (trough, 0.05)  # no peak, and nothing known
    assert swing._refined(forced, OMEGA - 0.2, 0.05)[0] == pytest.approx(OMEGA - 0.15)  # no further than is known


def test_sizes_and_phases_are_those_of_the_force() -> None:
    rows = known_rows()
    forced = pushed(rows, wave(rows, 0.6) + 2.0, wave(rows, -0.8) - 0.3 * rows.time)
    assert swing._size(forced, OMEGA) == pytest.approx(1.0, rel=1e-6)
    turned = np.array(PHASES) + np.pi  # along the axis that swings most
    phases = swing._phases(forced, OMEGA, LOGS + 2)
    assert phases[0] == phases[-1] == 0.0  # of logs without segments
    np.testing.assert_allclose(np.exp(1j * np.array(phases[1:-1])), np.exp(1j * turned), atol=1e-6)


def test_what_goes_with_the_motion_in_all_logs_alike_is_taken_off_and_nothing_else() -> None:
    rows = known_rows()
    matrix = torch.as_tensor(np.random.default_rng(3).standard_normal((2, 4)))
    with_path = torch.einsum("em,spm->esp", matrix, rows.motion)
    moved = pushed(rows, *with_path)
    assert float(moved.beside_motion().gradient.abs().max()) < 1e-6 * float(moved.gradient.abs().max())
    both = pushed(moved, wave(rows), wave(rows))
    alone = pushed(rows, wave(rows), wave(rows))
    torch.testing.assert_close(both.beside_motion().gradient, alone.beside_motion().gradient, rtol=0, atol=1e-6)
    assert swing._falls(both.beside_motion(), np.array([OMEGA]))[0] > 0.5 * swing._falls(alone, np.array([OMEGA]))[0]


def test_drawn_noise_has_the_curvature_for_its_covariance() -> None:
    rows, rng = known_rows(("fx",)), np.random.default_rng(4)
    drawn = torch.stack([rows.of_noise(rng).gradient[0, 0] for _ in range(1000)])
    covariance = rows.curvature[0, 0, :, 0]
    torch.testing.assert_close(drawn.T @ drawn / len(drawn), covariance, rtol=0, atol=0.15 * float(covariance.max()))


@cache
def problems(*, swings: bool) -> Problems:
    """Flights of 6 s, with a force that swings or without, as noise and small pushes alone weigh them."""
    hidden = {"fx": 0.012, "fy": 0.006, "omega": OMEGA}
    data = flights_with("periodic_force" if swings else "", hidden if swings else {}, steps=300)
    return weighed_problems(Library.of(CRAZYFLIE.nominal(), []), data)


def looser(known: Problems, times: float) -> Problems:
    """The same, with so many times the noise and the disturbances."""
    whitening = known.whitening
    weight, lost = whitening.weight / times**2, whitening.lost / times
    return replace(known, whitening=replace(whitening, weight=weight, lost=lost))


def test_a_swing_is_found_where_one_is_with_its_frequency_and_phases() -> None:
    known = problems(swings=True)
    found = find_swing(known, known.library.null, 0.01)
    assert found is not None
    assert abs(found.omega - OMEGA) < 4 * found.deviation
    assert found.deviation < 0.01 * OMEGA
    np.testing.assert_allclose(np.cos(found.phases), 1.0, atol=0.05)
    rows = swing._rows(known, known.library.null, ["fx", "fy", "fz"])
    assert swing._size(rows, found.omega) == pytest.approx(np.hypot(0.012, 0.006), rel=0.15)  # N
    again = find_swing(looser(known, 3.0), known.library.null, 0.01)
    assert again is not None
    assert again.omega == pytest.approx(found.omega)
    assert again.deviation == pytest.approx(3.0 * found.deviation)
    healthy = problems(swings=False)
    assert find_swing(healthy, healthy.library.null, 0.05) is None


def test_logs_that_hold_less_than_three_periods_or_ten_pieces_have_no_swing() -> None:
    single = weighed_problems(Library.of(CRAZYFLIE.nominal(), []), flights_with("", {}, count=1, steps=300))
    assert single.block_count < 10
    for few in (single, weighed_problems(single.library, Dataset(log.rows(0, 60) for log in flights()))):
        assert find_swing(few, few.library.null, 0.05) is None
        assert smallest_swings(few, 0.05) == (None, {})


def test_the_size_that_would_be_found_is_found_and_goes_with_the_noise() -> None:
    healthy = problems(swings=False)
    planned, sizes = smallest_swings(healthy, 1e-3)
    assert planned is not None
    assert planned.deviation == 0.0  # it is planned, and not estimated
    assert 2 * np.pi * 3 / 6 < planned.omega < 2 * np.pi * 0.25 / 0.1
    assert len(planned.phases) == len(healthy.data)
    assert sizes.keys() == {"fx", "fy", "fz"}
    _, noisy = smallest_swings(looser(healthy, 2.0), 1e-3)
    for name, size in sizes.items():
        assert noisy[name] == pytest.approx(2.0 * size)
    _, strict = smallest_swings(healthy, 1e-30)
    assert set(strict.values()) == {float("inf")}


def test_the_angle_stands_in_the_middle_of_every_step_from_each_log_s_own_start() -> None:
    logs = Dataset(replace(log, time=log.time + 100.0) for log in flights())
    swung = Swing(OMEGA, 0.1, (0.0, 0.5, 1.0, 1.5)).in_data(logs)
    for log, phase in zip(swung, (0.0, 0.5, 1.0, 1.5), strict=True):
        angle = log.extra[ANGLE]
        assert angle[0] == pytest.approx(phase + OMEGA * log.dt / 2)
        np.testing.assert_allclose(np.diff(angle), OMEGA * log.dt, rtol=1e-9)


@pytest.mark.parametrize(("times", "own"), [(2.9, False), (3.1, True)])
def test_a_path_is_the_robot_s_own_where_it_swings_by_three_times_what_such_a_force_could_do(
    times: float, *, own: bool
) -> None:
    """A free body follows a force of F by F/(m ω²); slow motion and where the log is do not count."""
    logs = []
    for log in flights():
        time, state = log.time - log.time[0], log.state.copy()
        for column, size in (("x", 0.03), ("y", 0.04), ("z", 0.0)):
            state[:, log.layouts.state.index(column)] = 2.0 - 0.3 * time + size * np.sin(OMEGA * time + size)
        logs.append(replace(log, state=state))
    known = weighed_problems(Library.of(CRAZYFLIE.nominal(), []), Dataset(logs))
    force = OMEGA**2 * 0.05 * CRAZYFLIE.mass / times
    assert swing._own_motion(known.problem, OMEGA, force) is own
    assert not swing._own_motion(known.problem, 2 * OMEGA, force)


def test_motion_is_place_and_velocity_in_the_middle_of_every_piece_about_their_means() -> None:
    """Of x = t²/2 and y = t the velocity of one and the place of the other are the time of the piece's middle."""
    logs = []
    for log in flights():
        time, state = log.time - log.time[0], log.state.copy()
        for column, place in (("x", time**2 / 2), ("y", time), ("z", np.ones(len(time)))):
            state[:, log.layouts.state.index(column)] = place
        logs.append(replace(log, state=state))
    known = weighed_problems(Library.of(CRAZYFLIE.nominal(), []), Dataset(logs))
    rows = swing._rows(known, known.library.null, ["fx"])
    for log in np.unique(rows.log):
        mine = torch.as_tensor(rows.log == log)
        time, zero = rows.time[mine] - rows.time[mine].mean(), torch.zeros_like(rows.time[mine])
        _, y, z, of_x, of_y, of_z = rows.motion[mine].unbind(-1)
        for found, expected in ((y, time), (of_x, time), (z, zero), (of_y, zero), (of_z, zero)):
            torch.testing.assert_close(found, expected, rtol=0.0, atol=1e-5)
