"""How far a log disagrees with itself and with a model, quantity by quantity, over short stretches.

A model's single steps hold both: that velocity moves the position and rates turn the attitude, and what commands do.
Over a stretch of a log the sum of what they predict, each from the measured row, must be what was measured; both
without the log's mean, since wind, trim or a tilted board make constants. As sums, nothing noisy is differentiated.

An attitude or a heading is also held against its measured rates, and a position against its velocity, whatever the
model says: it may turn and move them by commands. Where these arrive late, both are late together, which no sensor is;
where they are a speed in another unit, a car would go right with a velocity that is mirrored.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import torch
from scipy.stats import wilcoxon

from sym2real import rotation
from sym2real.dataset import Dataset
from sym2real.effects.along_logs import from_row_to_row, with_filtered_commands
from sym2real.effects.inputs import with_inputs
from sym2real.effects.visible import VisibleModel
from sym2real.layout import Layout
from sym2real.logs.agreement import RATES
from sym2real.logs.pose import attitude
from sym2real.symbolic import Equations
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import ATTITUDE, HEADING, POSITION, VELOCITY

STRETCH, FEWEST_ROWS = 0.4, 4  # s; rows
SHIFTED = 6  # rows by which columns may be late or early: at the ends of a log nobody knows what they held there
TURNED = "turn about {} by its rate"
LEVEL = 2  # the first components of a world vector lie level, whichever way its axes are turned


@dataclass(frozen=True, eq=False)
class Balance:
    """Measured and predicted change of every quantity over stretches.

    Args:
        names, fields: of the quantities, and of the state's fields that they are part of.
        measured, predicted: of each, by component ``# (stretches, components)``.
        data: the logs.
        rows: of a stretch.
    """

    names: tuple[str, ...]
    fields: tuple[str, ...]
    measured: tuple[Array, ...]
    predicted: tuple[Array, ...]
    data: Dataset
    rows: int

    def of_field(self, field: str) -> tuple[Array, Array]:
        """Measured and predicted change of a field's components ``# (stretches, components)``, in their order."""
        return self.of_quantities([place for place, of in enumerate(self.fields) if of == field])

    def of_quantities(self, places: Sequence[int]) -> tuple[Array, Array]:
        """The same of some quantities."""
        none, parts = np.zeros((len(self.losses), 0)), (self.measured, self.predicted)
        measured, predicted = (np.concatenate([none, *(part[place] for place in places)], axis=1) for part in parts)
        return measured, predicted

    @property
    def arms(self) -> Array:
        """Way of a point one metre ahead and of one to the left, level, as the robot turns ``# (stretches, 2, 2)``."""
        turns = [np.diff(_axes(log), axis=0) for log in self.data]
        return _summed(_stretches(turns, self.rows), [len(own) // self.rows for own in turns]).reshape(-1, 2, 2)

    @cached_property
    def losses(self) -> Array:
        """Squares missed over those of both changes, a quantity's mean of which is between 0 and 2 ``# (s, q)``."""
        return np.stack([self.missed(place, np.mean) for place in range(len(self.names))], axis=1)

    def parts(self, count: int) -> list[Balance]:
        """Of so many versions of the same logs, one behind the other: each version's."""
        measured, predicted = ([np.split(part, count) for part in parts] for parts in (self.measured, self.predicted))
        pairs = zip(zip(*measured, strict=True), zip(*predicted, strict=True), strict=True)
        return [replace(self, measured=own, predicted=other) for own, other in pairs]

    def missed(self, place: int, usual: Callable[[Array], Any] = np.median) -> Array:
        """Squares missed of a quantity over the median of both changes, which no single one makes ``# (s,)``."""
        measured, predicted = self.measured[place], self.predicted[place]
        size = float(usual((np.square(measured) + np.square(predicted)).sum(1)))
        return np.asarray(np.square(measured - predicted).sum(1) / max(size, 1e-300))


class Balances:
    """Balances of logs under one model."""

    def __init__(self, model: Equations, predict: VisibleModel) -> None:
        self.model, self._predict = model, predict

    @classmethod
    def of(cls, model: Equations, data: Dataset) -> Balances | None:
        """None where the logs have other columns than the model."""
        per_row = from_row_to_row(model, data)
        return None if per_row is None else cls(model, per_row[0])

    @staticmethod
    def stretch(dt: float) -> int:
        """Rows of a stretch."""
        return max(FEWEST_ROWS, round(STRETCH / dt))

    def inside(self, data: Dataset) -> Balance:
        """The balance without the ends of logs that are long enough, which shifts of columns make up."""
        least = 2 * SHIFTED + self.stretch(data.dt)
        return self(Dataset(log.rows(SHIFTED, len(log) - SHIFTED) if len(log) > least else log for log in data))

    def __call__(self, data: Dataset) -> Balance:
        """The balance of the logs as they stand."""
        known = with_filtered_commands(self.model, with_inputs(self.model.layouts.inputs, data))
        rows = self.stretch(data.dt)
        steps = [(log.state[:-1], log.state[1:], log.action[:-1], log.step_inputs[:-1]) for log in known]
        counts, layout = [(len(log) - 1) // rows for log in known], known.layouts.state
        now, then, sent, inputs = (torch.as_tensor(_stretches(own, rows)) for own in zip(*steps, strict=True))
        later = self._predict.after_each(now, sent, inputs)
        measured, predicted = (_summed(layout.difference(end, now).numpy(), counts) for end in (then, later))
        quantities = _quantities(data.layouts.state)
        rates = _summed(_stretches([_rates(log)[:-1] for log in known], rows) * data.dt, counts)
        turns = _turned(measured, layout, dict(zip(_rated(known[0]), rates.T[..., None], strict=True)))
        if layout.has_field(POSITION.name) and layout.has_field(VELOCITY.name):
            way = _summed(now[..., layout.slice(VELOCITY.name)].numpy() * data.dt, counts)
            ways = {"level position": way[:, :LEVEL], "upright position": way[:, LEVEL:]}
            turns |= {f"{of} by velocity": (measured[:, quantities[of][1]], ways[of]) for of in ways if ways[of].size}
        entries = [(name, field, measured[:, at], predicted[:, at]) for name, (field, at) in quantities.items()]
        entries += [(name, "", angle, rate) for name, (angle, rate) in turns.items()]
        names, fields, changes, others = zip(*entries, strict=True)
        return Balance(names, fields, changes, others, known, rows)


def _rated(log: Trajectory) -> list[str]:
    """The rates that were measured, whether a model has them as states or not."""
    return [rate for rate in RATES if rate in log.layouts.state or (rate in log.extra and rate in log.sources)]


def _rates(log: Trajectory) -> Array:
    """Their values ``# (rows, k)``."""
    return np.concatenate([np.zeros((len(log), 0)), *(log.column(rate)[:, None] for rate in _rated(log))], axis=1)


def _turned(changes: Array, layout: Layout, sums: Mapping[str, Array]) -> dict[str, tuple[Array, Array]]:
    """Quantity → turn over stretches, and its rate's ``# (stretches, 1)`` each; nothing without both."""
    rates = {ATTITUDE.name: RATES, HEADING.name: RATES[-1:]}
    fields = zip((field.name for field in layout.fields), layout.tangent_places, strict=True)
    turns = [turn for name, places in fields if name in rates for turn in zip(places, rates[name], strict=True)]
    return {TURNED.format(rate[-1]): (changes[:, [place]], sums[rate]) for place, rate in turns if rate in sums}


def _stretches(logs: Sequence[Array], rows: int) -> Array:
    """Logs one behind the other in whole stretches of so many rows ``# (stretches, rows, k)``."""
    whole = (own[: len(own) // rows * rows] for own in logs)
    return np.concatenate([own.reshape(len(own) // rows, rows, own.shape[1]) for own in whole])


def _summed(changes: Array, counts: Sequence[int]) -> Array:
    """Sums over stretches without each log's mean ``# (stretches, tangent)``; ``counts`` of each log."""
    sums = np.split(changes.sum(1), np.cumsum(counts)[:-1])
    return np.concatenate([own - own.mean(0) if len(own) else own for own in sums])


def _quantities(layout: Layout) -> dict[str, tuple[str, list[int]]]:
    """Quantity → field, places in the tangent: world vectors level and upright, all else one by one.

    What has no frame goes by its columns: joints and their rates.
    """
    quantities: dict[str, tuple[str, list[int]]] = {}
    for field, places in zip(layout.fields, map(list, layout.tangent_places), strict=True):
        if field.frame == "world" and field.kind == "vector":
            own = {f"level {field.name}": places[:LEVEL], f"upright {field.name}": places[LEVEL:]}
        elif not field.frame and field.kind == "vector":
            own = {column: [place] for column, place in zip(field.columns, places, strict=True)}
        elif len(places) == 1:
            own = {field.name: places}
        else:
            own = {f"{field.name} about {axis}": [place] for axis, place in zip("xyz", places, strict=False)}
        quantities |= {name: (field.name, components) for name, components in own.items() if components}
    return quantities


def chance(before: Array, after: Array) -> float:
    """How likely stretches would miss so many fewer squares by chance (Wilcoxon's signed ranks, 1945)."""
    return float(wilcoxon(before, after, alternative="greater", zero_method="zsplit").pvalue)


def without_drag(balance: Balance) -> Array:
    """Losses ``# (q,)`` where a force along the velocity takes what it can: it turns accelerations, as a frame does."""
    pace = balance.predicted[balance.names.index("level position")] if "level position" in balance.names else None
    return balance.losses.mean(0) if pace is None else _without(balance, ("level velocity",), [pace])


def missed_beside_drag(balance: Balance) -> Array:
    """Squares missed of the level velocity where what slows the robot takes what it can ``# (s,)``.

    On a circle that moves the velocity ahead, as nothing late does; it would hide that.
    """
    place, moved = (balance.names.index(f"level {field}") for field in (VELOCITY.name, POSITION.name))
    left, pace = balance.measured[place] - balance.predicted[place], balance.predicted[moved]
    slowed = min(0.0, float((left * pace).sum() / np.square(pace).sum()))
    return np.asarray(np.square(left - slowed * pace).sum(1))


def without_arm(balance: Balance) -> Array:
    """Losses ``# (q,)`` where a sensor off the centre takes what it can: it moves sideways in turns, as if late."""
    moved = ("level position", "level velocity", "level position by velocity")
    return _without(balance, moved, [*np.moveaxis(balance.arms, 1, 0)])


def _without(balance: Balance, quantities: Collection[str], parts: Sequence[Array]) -> Array:
    """Losses where in each of these quantities a multiple of every part is taken off, by least squares."""
    losses: Array = balance.losses.mean(0)
    design = np.stack([part.ravel() for part in parts], axis=1)
    for place, name in enumerate(balance.names):
        if name in quantities:
            measured, predicted = balance.measured[place], balance.predicted[place]
            left = (measured - predicted).ravel()
            left -= design @ np.linalg.lstsq(design, left, rcond=None)[0]
            losses[place] = float(left @ left) / max(float((np.square(measured) + np.square(predicted)).sum()), 1e-300)
    return losses


def _axes(log: Trajectory) -> Array:
    """Level parts of the axes ahead and to the left ``# (rows, 4)``; zero where nobody knows where they point."""
    if not any(log.layouts.state.has_field(name) for name in ("attitude", "heading")):
        return np.zeros((len(log), 4))
    turned = rotation.to_matrix(attitude(log)).numpy()
    return np.concatenate([turned[:, :2, 0], turned[:, :2, 1]], axis=1)
