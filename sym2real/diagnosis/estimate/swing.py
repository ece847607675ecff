"""A force that swings: its frequency and its phase in every log, settled before the search, which estimates its size.

The likelihood of a frequency has as many peaks as a log has periods, so that no fit finds it from its null. What a
full model leaves is therefore looked at frequency by frequency: a sine and a cosine of each force, constant over
the pieces of a segment, beside a constant and a trend, by generalised least squares on the whitened residuals,

    r + J (S sin ωt + C cos ωt + b₀ + b₁ t),        fall of the whitened squares by S and C, per log,

a Lomb–Scargle periodogram in the metric of the fit (N. Lomb, Astrophys. Space Sci. 39 (1976) 447–462; with constant:
M. Zechmeister, M. Kürster, A&A 496 (2009) 577–584). The highest peak counts if the sine that three quarters of a log
give lowers the loss of the last quarter's blocks beyond chance, for all the frequencies that were looked at.

What the robot itself does periodically looks periodic in everything that a model misses: at one frequency that is a
matrix times the position x and the velocity ẋ. So where the paths (of half the logs, because a swing is in all of them)
swing by far more than such a force could move a free body, ω² |x| m > 3 |F|, what such a matrix, the same in all logs,
makes of these is taken off first, and a swing must go another way.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np
import torch
from numpy.typing import NDArray
from scipy import stats
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.preparation import present
from sym2real.diagnosis.data.segments import summed
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.estimate.whitening import PIECES, disturbances
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.inputs import ANGLE
from sym2real.effects.wrench import uses
from sym2real.least_squares import solve
from sym2real.trajectory import Array
from sym2real.vocabulary import FORCE, POSITION

# Periods that the longest log must hold, and the fastest swing in periods per piece of a segment.
PERIODS, FASTEST = 3.0, 0.25
# Steps of a frequency in units of 1/duration, and finer ones about the peak.
OVERSAMPLED, FINE = 3, 10
QUARTERS = 4
# Frequencies that are held in memory at a time, each with a matrix per segment: all of a long flight take gigabytes.
AT_A_TIME = 64
# Frequencies at which a plan has a force swing, and how many times larger than one of a known wave it is made.
PLANNED, LARGER = 3, np.geomspace(1.0, 100.0, 28)


@dataclass(frozen=True)
class Swing:
    """A frequency, and where in its period every log begins.

    Args:
        omega, deviation: rad/s, and its standard deviation.
        phases: of every log at its first row, rad.
    """

    omega: float
    deviation: float
    phases: tuple[float, ...]

    def in_data(self, data: Dataset) -> Dataset:
        """The logs with the angle of the swing in the middle of every step as a column."""
        angles = [self.omega * (log.time - log.time[0] + log.dt / 2) for log in data]
        parts = zip(data, angles, self.phases, strict=True)
        return Dataset(replace(log, extra={**log.extra, ANGLE: angle + phase}) for log, angle, phase in parts)


@dataclass(frozen=True, eq=False)
class Rows:
    """Forces on pieces of segments, whitened.

    Args:
        time: middle of each piece since its log's start, s ``# (S, P)``.
        motion: position and velocity there, m and m/s ``# (S, P, 2·k)``.
        gradient, curvature: of half the whitened squares by the force on each piece ``# (S, D, P), (S, D, P, D, P)``.
        log: of every segment ``# (S,)``.
    """

    time: Tensor
    motion: Tensor
    gradient: Tensor
    curvature: Tensor
    log: NDArray[np.int64]

    def of_noise(self, rng: np.random.Generator) -> Rows:
        """The same with noise alone: the covariance of a gradient is the curvature."""
        values, vectors = torch.linalg.eigh(self.curvature.flatten(3).flatten(1, 2))  # (S, D·P)
        drawn = torch.as_tensor(rng.standard_normal(values.shape)) * values.clamp_min(0.0).sqrt()
        return replace(self, gradient=(vectors @ drawn[..., None]).reshape(self.gradient.shape))

    def beside_motion(self) -> Rows:
        """The same without the forces that are a matrix, of all logs, times position and velocity."""
        half = torch.einsum("sdpeq,sqm->sdpem", self.curvature, self.motion)
        gradient = torch.einsum("sdp,spm->dm", self.gradient, self.motion)
        curvature = torch.einsum("sdpem,spk->dkem", half, self.motion).flatten(2).flatten(0, 1)
        matrix = -solve(curvature, gradient.flatten()).reshape(gradient.shape)
        return replace(self, gradient=self.gradient + torch.einsum("sdpem,em->sdp", half, matrix))

    def with_force(self, place: int, force: Tensor) -> Rows:
        """With a force along one axis on every piece besides, N ``# (S, P)``."""
        moved = torch.einsum("sdpq,sq->sdp", self.curvature[:, :, :, place], force)
        return replace(self, gradient=self.gradient + moved)

    def normal(self, omegas: Sequence[float]) -> tuple[Tensor, Tensor]:
        """Gradient and curvature by sine, cosine, constant and trend of each force, at every frequency.

        ``# (F, S, 4·D), (F, S, 4·D, 4·D)``
        """
        angle = self.time.new_tensor(omegas)[:, None, None] * self.time
        scaled = (self.time / self.time.max()).expand_as(angle)
        shapes = torch.stack([angle.sin(), angle.cos(), torch.ones_like(angle), scaled], dim=-1)  # (F, S, P, 4)
        gradient = torch.einsum("sdp,fspk->fskd", self.gradient, shapes).flatten(2)
        half = torch.einsum("sdpeq,fsql->fsdpel", self.curvature, shapes)
        return gradient, torch.einsum("fspk,fsdpel->fskdle", shapes, half).reshape(*gradient.shape, gradient.shape[-1])

    def by_log(self, omegas: Sequence[float]) -> tuple[Tensor, Tensor]:
        """The same, added up over the segments of each log that has any ``# (F, L, 4·D), (F, L, 4·D, 4·D)``."""
        place = np.unique(self.log, return_inverse=True)[1]
        gradient, curvature = (summed(part.transpose(0, 1), place).transpose(0, 1) for part in self.normal(omegas))
        return gradient, curvature


def find_swing(problems: Problems, values: Tensor, chance: float) -> Swing | None:
    """The swing that the residuals hold beyond chance, if there is one.

    Args:
        problems: data and their whitening; the equations have forces among their inputs.
        values: parameter set of a fit that leaves little ``# (P,)``.
        chance: of a false alarm, shared among the frequencies.
    """
    problem, names = problems.problem, _forces(problems)
    if not names:
        return None
    rows, (grid, step) = _rows(problems, values, names), _frequencies(problem)
    beside = rows.beside_motion()
    own = np.array([_own_motion(problem, omega, _size(rows, omega)) for omega in grid])
    highest = np.where(own, _falls(beside, grid), _falls(rows, grid)).argmax()
    rows = beside if own[max(0, highest - 1) : highest + 2].any() else rows
    fine = grid[highest] + step * np.arange(-FINE, FINE + 1) / FINE
    omega, deviation = _refined(rows, float(fine[_falls(rows, fine).argmax()]), step / FINE)
    looks = max(1, len(grid) // OVERSAMPLED)
    if _chance(rows, problems, omega) > chance / looks:
        return None
    return Swing(omega, deviation, _phases(rows, omega, len(problem.data)))


def smallest_swings(problems: Problems, chance: float) -> tuple[Swing | None, dict[str, float]]:
    """A swing of a middle frequency, and the amplitude of each force, N, that :func:`find_swing` finds at most others.

    Infinite where none is found, however large. Every log has a phase of its own, and noise of the covariance.

    Args:
        problems, chance: as of :func:`find_swing`.
    """
    problem, names = problems.problem, _forces(problems)
    if not names:
        return None, {}
    rng, (grid, _) = np.random.default_rng(0), _frequencies(problem)
    known = _rows(problems, problem.library.null, names)
    phases, limit = rng.uniform(-np.pi, np.pi, len(problem.data)), chance / max(1, len(grid) // OVERSAMPLED)
    omegas = np.linspace(grid[0], grid[-1], PLANNED + 2)[1:-1]

    def smallest(place: int, omega: float) -> float:
        """Amplitude of one force at one frequency, N."""
        wave = torch.sin(omega * known.time + torch.as_tensor(phases[known.log])[:, None])
        rows, own = known.of_noise(rng), known.curvature[:, place, :, place]
        sizes = LARGER / max(1e-300, float(torch.einsum("spq,sp,sq->", own, wave, wave))) ** 0.5

        def seen(size: float) -> bool:
            forced = rows.with_force(place, size * wave)
            beside = forced.beside_motion() if _own_motion(problem, omega, size) else forced
            return _chance(beside, problems, omega) <= limit

        at = bisect_left(sizes, True, key=seen)
        return float(sizes[at]) if at < len(sizes) else inf

    sizes = {name: float(np.median([smallest(place, w) for w in omegas])) for place, name in enumerate(names)}
    return Swing(float(np.median(omegas)), 0.0, tuple(phases.tolist())), sizes


def _forces(problems: Problems) -> list[str]:
    """Inputs that may swing; none in logs too short to tell, or to hold a frequency."""
    enough = problems.block_count >= SETTINGS.fewest_pieces and len(_frequencies(problems.problem)[0]) > 0
    return [name for name in FORCE.columns if enough and uses(problems.library.equations, name)]


def _rows(problems: Problems, values: Tensor, names: list[str]) -> Rows:
    problem, whitening = problems.problem, problems.whitening
    sizes = dict(disturbances(problem.library.equations))
    sized = [(name, sizes.get(name, 0.01)) for name in names]
    jacobian = problem.disturbance_jacobian(values, sized, PIECES)  # (S, R, D, P)
    jacobian = jacobian / jacobian.new_tensor([size for _, size in sized])[:, None]
    residual = problem.residuals(values[None])[0]
    products = whitening.products(torch.cat([residual[..., None], jacobian.flatten(-2)], dim=-1))
    segments, dt = problem.segments, problem.data.dt
    edges = segments.edges(PIECES)
    middle = (segments.row[:, None] + (edges[1:] + edges[:-1])[None] / 2) * dt
    shape = (len(residual), len(names), PIECES)
    gradient, curvature = products[:, 0, 1:].reshape(shape), products[:, 1:, 1:].reshape(*shape, *shape[1:])
    return Rows(torch.as_tensor(middle), _motion(problem, edges), gradient, curvature, segments.log)


def _motion(problem: Problem, edges: NDArray[np.int64]) -> Tensor:
    """Position and velocity in the middle of every piece, about their log's mean ``# (S, P, 2·k)``."""
    segments, data = problem.segments, problem.data
    places = data.layouts.state.indices(present(data, POSITION.columns))
    path = torch.as_tensor(np.concatenate([log.state[:, places] for log in data]))
    first = np.cumsum([0, *(len(log) for log in data)])[segments.log] + segments.row
    at, steps = path[torch.as_tensor(first[:, None] + edges)], torch.as_tensor(np.diff(edges))[:, None]
    motion = torch.cat([(at[:, 1:] + at[:, :-1]) / 2, (at[:, 1:] - at[:, :-1]) / (steps * data.dt)], dim=-1)
    for log in np.unique(segments.log):
        own = torch.as_tensor(segments.log == log)
        motion[own] -= motion[own].mean((0, 1))
    return motion


def _frequencies(problem: Problem) -> tuple[Array, float]:
    """Candidates, and how far they are apart, rad/s."""
    dt = problem.data.dt
    longest = max(len(log) for log in problem.data) * dt
    piece = (problem.segments.length - 1) * dt / PIECES
    first, last, step = (2 * np.pi * part for part in (PERIODS / longest, FASTEST / piece, 1 / longest / OVERSAMPLED))
    return np.arange(first, last, step), step


def _falls(rows: Rows, omegas: Array) -> Array:
    """Of the whitened squares by sine and cosine beyond constant and trend, over all logs ``# (F,)``."""
    waves, falls = 2 * rows.gradient.shape[1], list[Tensor]()
    for part in np.split(omegas, range(AT_A_TIME, len(omegas), AT_A_TIME)):
        gradient, curvature = rows.by_log(part.tolist())
        rest, inner = gradient[..., waves:], curvature[..., waves:, waves:]
        falls.append((gradient * solve(curvature, gradient)).sum((1, 2)) - (rest * solve(inner, rest)).sum((1, 2)))
    return torch.cat(falls).numpy()


def _waves(rows: Rows, omega: float) -> Tensor:
    """Sine's and cosine's coefficients of every log in N ``# (logs, 2, D)``."""
    gradient, curvature = rows.by_log([omega])
    waves = -solve(curvature, gradient)[0]
    return waves.reshape(len(waves), -1, rows.gradient.shape[1])[:, :2]


def _size(rows: Rows, omega: float) -> float:
    """Root mean square over logs of the swing's amplitude, N."""
    return float(_waves(rows, omega).square().sum((1, 2)).mean().sqrt())


def _phases(rows: Rows, omega: float, logs: int) -> tuple[float, ...]:
    """Of every log, along the direction that the logs share; zero for logs without segments."""
    waves = _waves(rows, omega)
    along = torch.linalg.eigh(torch.einsum("lkd,lke->de", waves, waves))[1][:, -1]
    along = along * along[along.abs().argmax()].sign()
    sine, cosine = (waves @ along).unbind(1)
    phases = dict(zip(np.unique(rows.log).tolist(), torch.atan2(cosine, sine).tolist(), strict=True))
    return tuple(phases.get(log, 0.0) for log in range(logs))


def _own_motion(problem: Problem, omega: float, force: float) -> bool:
    """Whether the robot's path swings by more at this frequency than such a force could move a free body."""
    squares, data, mass = list[float](), problem.data, problem.library.equations.numbers.get("mass", 1.0)
    places = data.layouts.state.indices(present(data, POSITION.columns))
    for log in data:
        time = log.time - log.time[0]
        shapes = np.stack([np.sin(omega * time), np.cos(omega * time), np.ones(len(time)), time], axis=1)
        # A window, because slow motion is large beside this one and its side lobes would hide it.
        window = np.hanning(len(time))[:, None]
        waves = np.linalg.lstsq(window * shapes, window * log.state[:, places], rcond=None)[0][:2]
        squares.append(np.square(waves).sum())
    return float(omega**2 * np.sqrt(np.median(squares)) * mass) > SETTINGS.far * force


def _chance(rows: Rows, problems: Problems, omega: float) -> float:
    """Probability that quarters of logs tell each other so much by chance: signed ranks of gains of blocks."""
    gradient, curvature = (row[0] for row in rows.normal([omega]))
    waves, gains = 2 * rows.gradient.shape[1], gradient.new_zeros(len(gradient))
    for log in np.unique(rows.log):
        mine = np.flatnonzero(rows.log == log)
        for part in np.array_split(mine, QUARTERS):
            rest = torch.as_tensor(np.setdiff1d(mine, part))
            if not len(part) or not len(rest):
                continue
            g, h = gradient[rest].sum(0), curvature[rest].sum(0)
            plain = torch.cat([g.new_zeros(waves), -solve(h[waves:, waves:], g[waves:])])
            own = gradient[part], curvature[part]
            gains[part] = _changes(*own, plain) - _changes(*own, -solve(h, g))
    by_block = summed(gains, problems.blocks)
    if not bool(by_block.any()):
        return 1.0
    return float(stats.wilcoxon(by_block.numpy(), alternative="greater").pvalue)


def _changes(gradient: Tensor, curvature: Tensor, step: Tensor) -> Tensor:
    """Of the whitened squares of every segment by a step ``# (S,)``."""
    return 2 * gradient @ step + torch.einsum("a,sab,b->s", step, curvature, step)


def _refined(rows: Rows, omega: float, step: float) -> tuple[float, float]:
    """Where a parabola through the falls about a peak has its own, and the standard deviation of that."""
    below, here, above = _falls(rows, omega + step * np.array([-1.0, 0.0, 1.0])).tolist()
    curvature = 2 * here - below - above
    if curvature <= 0:
        return omega, step
    return omega + step * float(np.clip((above - below) / (2 * curvature), -1.0, 1.0)), step * (2.0 / curvature) ** 0.5
