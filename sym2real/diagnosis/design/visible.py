"""What a plan says: the smallest effect that logs show, what it is taken for, and from which size on it matters.

A model that lacks an effect of size β predicts channel c with the mean square error f² + β²s²: f is the floor that
noise and disturbances make for any model (see ``errors/floor.py``), s² the mean square of the prediction's derivative
by β at the window's end. The effect matters where a tenth of that error goes with it, which is what the gate asks of
findings: β² ≥ (1/0.9² - 1) f²/s² in the channel and at the horizon that show it best.

It changes the whitened residuals by r. Another effect with the derivatives J, fitted to that, leaves ‖r - Jθ‖². Where
that is less than 0.04 of ‖r‖² (a correlation of 0.98) the two cannot be distinguished; else they are separable from
that size on where it is what any finding needs. A delay and a lag are the same to first order, so of these J is the
change at the size that is to be expected.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import torch
from torch import Tensor

from sym2real.diagnosis.data.windows import channel_name, judged
from sym2real.diagnosis.errors.floor import MOST_WINDOWS, Floor, SensorNoise, floor_of_explained
from sym2real.diagnosis.errors.rungs import HeldOut, windows_of
from sym2real.diagnosis.estimate.fit import Free, Problems
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.search.needed import judged_horizons
from sym2real.diagnosis.settings import SETTINGS
from sym2real.json_objects import fields_of
from sym2real.least_squares import solve
from sym2real.upward import upward

# Mean square of what an effect changes, over the floor's, of which a tenth of the error goes with the effect.
MATTERS = 1 / (1 - SETTINGS.worth_saying) ** 2 - 1


class Others(NamedTuple):
    """What other effects do of a change of the residuals.

    Args:
        like: those that leave next to nothing of it.
        nearest: the one of all others that leaves least; empty where there is none.
        left: the part of its whitened squares that this one leaves.
    """

    like: tuple[str, ...] = ()
    nearest: str = ""
    left: float = 1.0

    @classmethod
    def of(cls, parts: Mapping[str, float]) -> Others:
        """Of the part that every other effect leaves."""
        order = sorted((part, name) for name, part in parts.items())
        like = tuple(name for part, name in order if part < 1.0 - SETTINGS.inseparable)
        left, nearest = (*order[len(like) :], (1.0, ""))[0]
        return cls(like, nearest, left)


@dataclass(frozen=True, eq=False)
class Changes:
    """What effects that act from zero on do to the residuals of a manoeuvre.

    Args:
        problems: the manoeuvre and its noise.
        columns: change of the residuals by every parameter, per scale ``# (S, R, A)``.
        places: columns of every effect.
    """

    problems: Problems
    columns: Tensor
    places: Mapping[str, list[int]]

    @classmethod
    def of(cls, problems: Problems, smooth: Sequence[Candidate]) -> Changes:
        """Of a robot that lacks nothing."""
        problem, null, scale = problems.problem, problems.library.null, problems.library.scale
        free = [slot for own in smooth for slot in own.free]
        columns = problem.linearised(null[None], [free])[0][..., 1:]
        for own in (own for own in smooth if own.starts):
            slot = own.free[0]
            nothing, expected = problem.residuals(torch.stack([null, own.started(null, float((null + scale)[slot]))]))
            columns[..., free.index(slot)] = expected - nothing
        return cls(problems, columns, {own.name: [free.index(slot) for slot in own.free] for own in smooth})

    def others(self, changes: Tensor, but: str = "") -> tuple[Tensor, list[Others]]:
        """Whitened squares of changes of the residuals ``# (S, R, L)``, and what every effect but one does of each."""
        count = changes.shape[-1]
        products = self.problems.whitening.products(torch.cat([changes, self.columns], dim=-1)).sum(0)
        whole, left = products.diagonal()[:count], dict[str, list[float]]()
        for name in (name for name in self.places if name != but):
            places = [count + place for place in self.places[name]]
            part = products[:count, places]
            explained = (part * solve(products[places][:, places], part.mT).mT).sum(1)
            left[name] = (1.0 - explained / whole.clamp_min(1e-300)).tolist()
        return whole, [Others.of({name: parts[change] for name, parts in left.items()}) for change in range(count)]


@dataclass(frozen=True, eq=False)
class Predictions:
    """Windows as long as those by which findings are judged, and the floor of their errors.

    Args:
        problem: predictions of the windows.
        floor: at every horizon that is judged.
    """

    problem: Problem
    floor: Sequence[Floor]

    @classmethod
    def of(cls, problems: Problems, noise: SensorNoise | None) -> Predictions | None:
        """Of the logs of a problem, with noise of the sensors or that which the logs show; None of short logs."""
        library, data = problems.library, problems.data
        held = HeldOut(library, data)
        if not (horizons := judged_horizons(held)):
            return None
        windows = windows_of(data, round(max(horizons) / data.dt)).some(MOST_WINDOWS)
        floor = floor_of_explained(held, library.null, problems.whitening, horizons, noise=noise)
        return cls(Problem(library, data, windows), floor)

    def of_parameters(self, free: Free) -> Tensor:
        """Size of every parameter from which on it matters, in units of its scale ``# (A,)``."""
        slopes = self.problem.linearised(self.problem.library.null[None], [free])[0][..., 1:]
        return (MATTERS / self._over_floor(slopes)).sqrt()

    def matter(self, sets: Tensor) -> Tensor:
        """Which of some parameter sets ``# (B, P)`` matter beside none ``# (B,)``."""
        residuals = self.problem.residuals(torch.cat([self.problem.library.null[None], sets]))
        return self._over_floor((residuals[1:] - residuals[0]).permute(1, 2, 0)) > MATTERS

    def _over_floor(self, changes: Tensor) -> Tensor:
        """Mean squares of changed predictions ``# (W, R, B)`` over the floor's, where they are largest ``# (B,)``."""
        windows, dt = self.problem.segments, self.problem.data.dt
        squares = changes.square().mean(0).reshape(windows.length, len(windows.compared), -1)
        channel = torch.tensor(windows.channel)
        numbers = {channel_name(field): number for number, field in enumerate(windows.layout.fields)}
        ratios = [
            squares[round(level.horizon / dt), channel == numbers[name]].sum(0) / max(level.errors[name][0], 1e-12) ** 2
            for level in self.floor
            for name in judged(level.errors)
        ]
        return torch.stack(ratios).amax(0).clamp_min(1e-300)


@dataclass(frozen=True)
class AssumedNoise:
    """Noise and disturbances of a robot that has not flown yet.

    Args:
        sensors: standard deviation by state field: m, rad, rad/s.
        disturbances: standard deviation of each, constant over a fifth of a segment, by column.
    """

    sensors: Mapping[str, float]
    disturbances: Mapping[str, float]


@dataclass(frozen=True)
class Visible:
    """What a manoeuvre shows of one parameter.

    Args:
        effect, parameter, unit: which.
        smallest: deviation from the null value that would be found, for limits the value itself; None where none
            within the parameter's bounds would.
        separable: deviation from which on no other effect explains so much of it that it would be taken for that; those
            in ``like`` and ``always`` aside.
        matters: deviation from which on a tenth of a prediction's error goes with the effect, for limits the value
            itself; None where that is beyond the parameter's bounds, or where logs are too short to predict.
        nearest: the effect that explains most of it at the smallest size.
        like: effects that this manoeuvre cannot tell from it.
        always: effects that no manoeuvre tells from it.
        shown_by: the manoeuvre that shows it.
    """

    effect: str
    parameter: str
    unit: str
    smallest: float | None
    separable: float | None
    matters: float | None
    nearest: str
    like: tuple[str, ...]
    always: tuple[str, ...]
    shown_by: str


@dataclass(frozen=True)
class Plan:
    """What manoeuvres would show.

    Args:
        visible: a row per parameter, in the order of the catalogue.
        seconds: of data.
        blocks: independent pieces of it; fewer than ten allow provisional findings only.
        notes: remarks on the model.
    """

    visible: tuple[Visible, ...]
    seconds: float
    blocks: int
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        seen = [visible for visible in self.visible if visible.smallest is not None]
        return f"<Plan: {len(seen)} of {len(self.visible)} parameters visible in {self.seconds:.0f} s>"

    def _repr_html_(self) -> str:
        return str(upward("plan_html")(self))

    @property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """Pairs of effects that the manoeuvres leave inseparable, each once."""
        inseparable = {tuple(sorted((visible.effect, other))) for visible in self.visible for other in visible.like}
        return tuple(sorted((first, second) for first, second in inseparable))

    def to_dict(self) -> dict[str, Any]:
        """The object that ``sym2real plan --json`` prints."""
        return {**fields_of(self), "inseparable": [list(pair) for pair in self.pairs]}
