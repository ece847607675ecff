"""Where a model fails, in terms a person uses: "where height is below 0.15 m the vertical error is 4.1× larger".

The error of a window is the norm of a channel's prediction error at its end. For every channel and feature a tree with
one feature, fitted to the logarithm of the error, cuts the feature's range into at most four pieces; the piece with
the largest error is the statement. It is made only when the tree predicts logs that it has not seen (grouped
cross-validation, R² > 0.15): a tree on the size of errors is weak evidence otherwise.
"""

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from sym2real.dataset import Logs
from sym2real.diagnosis.errors.by_window import WindowErrors, window_errors
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.kind import with_unit
from sym2real.json_objects import fields_of
from sym2real.logs.conditions import Region, training_range
from sym2real.protocols import DynamicsModel
from sym2real.symbolic import Equations
from sym2real.trajectory import Array
from sym2real.vocabulary import HEIGHT, JOINT_ANGLE, JOINT_DISPLACEMENT

MOST = 3
# Of a tree; smallest piece as a part of the windows, and in windows; folds of its cross-validation.
DEPTH, LEAF, FEWEST_IN_LEAF, FOLDS = 2, 0.05, 8, 5
IN_WORDS = {HEIGHT: "vertical position", "xy": "horizontal position"}
LENGTHS, ANGLES = (HEIGHT, "xy", "position", JOINT_DISPLACEMENT.name), ("attitude", "yaw", JOINT_ANGLE.name)
UNITS = {**dict.fromkeys(LENGTHS, "m"), **dict.fromkeys(ANGLES, "rad")}  # of other channels nobody knows


@dataclass(frozen=True)
class Where:
    """A region with larger errors.

    Args:
        statement: one sentence.
        channel: "z", "xy", "position", "attitude", "yaw", ….
        feature: what singles the region out.
        low, high: its range, in the feature's unit.
        ratio: root mean square error inside over outside.
        coverage: part of the windows inside.
        inside_training: whether the model's training reached there; None where nobody knows.
    """

    statement: str
    channel: str
    feature: str
    low: float
    high: float
    ratio: float
    coverage: float
    inside_training: bool | None = None


@dataclass(frozen=True)
class Segment:
    """A stretch of a log with a large error: times in s from the log's start, error in m, rad or the channel's own."""

    log: str
    start: float
    end: float
    channel: str
    error: float

    @property
    def statement(self) -> str:
        """One sentence a person reads."""
        what, unit = IN_WORDS.get(self.channel, self.channel), UNITS.get(self.channel, "")
        return f"{self.log} from {self.start:.1f} to {self.end:.1f} s: {what} off by {self.error:.2g} {unit}".rstrip()

    def to_dict(self) -> dict[str, Any]:
        """An entry of ``worst`` in what ``compare --json`` prints."""
        return {**fields_of(self), "unit": UNITS.get(self.channel, ""), "statement": self.statement}


def locate(model: Equations | DynamicsModel, data: Logs, region: Region | None = None) -> tuple[Where, ...]:
    """At most three statements on where the errors are larger, the clearest first.

    Args:
        model: predicts in float64, with the data's columns.
        data: logs.
        region: range of every column in training (:func:`~sym2real.symbolic.storage.training_region`).

    Raises:
        ShapeError: when no log is long enough for a window.
    """
    return where_of(window_errors(model, data), region)


def where_of(errors: WindowErrors, region: Region | None = None) -> tuple[Where, ...]:
    """Statements on errors at hand; see :func:`locate`."""
    targets = {name: np.log(values + errors.floor[name]) for name, values in errors.errors.items()}
    regions, used = list[Where](), set[str]()
    while len(regions) < MOST:
        unused = [(name, own) for name, own in errors.features.items() if name not in used and np.ptp(own) > 0]
        pairs = product(targets.items(), unused)
        scored = [(_unseen_r2(own, target, errors.group), channel, of) for (channel, target), (of, own) in pairs]
        best = max((r2 for r2, *_ in scored), default=0.0)
        if best <= SETTINGS.statement_r2:
            break
        alike = [entry for entry in scored if entry[0] >= max(best - SETTINGS.statement_alike, SETTINGS.statement_r2)]
        _, channel, feature = min(alike, key=lambda entry: (list(errors.units).index(entry[2]), -entry[0]))
        used.add(feature)
        regions += filter(None, [_statement(errors, channel, feature, targets[channel], region)])
        # What this feature explains, in any channel, is said.
        targets = {name: target - _explained(errors.features[feature], target) for name, target in targets.items()}
    return tuple(regions)


def _tree(rows: int) -> Any:
    from sklearn.tree import DecisionTreeRegressor  # noqa: PLC0415 — slow to import, and only needed here

    return DecisionTreeRegressor(max_depth=DEPTH, min_samples_leaf=max(FEWEST_IN_LEAF, round(LEAF * rows)))


def _explained(values: Array, target: Array) -> Array:
    return np.asarray(_tree(len(values)).fit(values[:, None], target).predict(values[:, None]))


def _unseen_r2(values: Array, target: Array, group: NDArray[np.int64]) -> float:
    """R² of a tree on groups that it has not seen."""
    from sklearn.metrics import r2_score  # noqa: PLC0415 — heavy, and only needed at the end
    from sklearn.model_selection import GroupKFold, cross_val_predict  # noqa: PLC0415

    groups = len(np.unique(group))
    if groups < 2 or len(values) < 2 * FEWEST_IN_LEAF or not np.ptp(target):
        return 0.0
    tree, apart = _tree(len(values)), GroupKFold(min(FOLDS, groups))
    return float(r2_score(target, cross_val_predict(tree, values[:, None], target, groups=group, cv=apart)))


def _statement(errors: WindowErrors, channel: str, feature: str, target: Array, region: Region | None) -> Where | None:
    values, size = errors.features[feature], errors.errors[channel]
    inside = _worst_range(values, target)
    if inside.all():
        return None
    ratio = float(np.sqrt(np.square(size[inside]).mean() / max(np.square(size[~inside]).mean(), 1e-300)))
    if ratio < SETTINGS.gap:
        return None
    low, high = float(values[inside].min()), float(values[inside].max())
    known = None if region is None else training_range(feature, region)
    trained = None if known is None else bool(known[0] <= np.median(values[inside]) <= known[1])
    coverage = float(inside.mean())
    words = _range_in_words(f"{feature} is", errors.units[feature], low, high, values)
    size_words = f"the {IN_WORDS.get(channel, channel)} error is {ratio:.1f}× larger"
    statement = f"where {words} {size_words}; {100 * coverage:.0f} % of the data"
    if trained is not None:
        statement += f"; {'inside' if trained else 'outside'} the training region"
    return Where(statement, channel, feature, low, high, ratio, coverage, trained)


def _worst_range(values: Array, target: Array) -> NDArray[np.bool_]:
    """Windows of the tree's worst piece and of its neighbours that are more like it than like the mean."""
    order = np.argsort(values, kind="stable")
    levels = _explained(values, target)[order]
    worst = float(levels.max())
    bad = 2 * levels >= worst + min(worst, float(target.mean()))  # the mean of equal numbers may be rounded up
    number, _ = label(bad)  # of the run of such windows that each is in
    inside = np.empty(len(values), dtype=bool)
    inside[order] = number == number[levels.argmax()]
    return inside


def _range_in_words(what: str, unit: str, low: float, high: float, values: Array) -> str:
    if low <= values.min():
        return f"{what} below {with_unit(high, unit, 2)}"
    if high >= values.max():
        return f"{what} above {with_unit(low, unit, 2)}"
    return f"{what} between {low:.2g} and {with_unit(high, unit, 2)}"


def worst_segments(errors: WindowErrors, count: int = MOST) -> tuple[Segment, ...]:
    """The windows whose errors stand out most from the noise of their channel, the worst first; none overlap.

    Args:
        errors: of all windows.
        count: most of them.
    """
    chosen = list(errors.errors)
    ratios = np.stack([errors.errors[name] / errors.floor[name] for name in chosen])  # (channels, windows)
    segments, taken = list[Segment](), list[tuple[int, float, float]]()
    for place in np.argsort(-ratios, axis=None):
        channel, index = chosen[place // ratios.shape[1]], int(place % ratios.shape[1])
        log, start, end = int(errors.log[index]), float(errors.start[index]), float(errors.end[index])
        # By number: logs may have one name, or none.
        if all(other != log or end <= first or start >= last for other, first, last in taken):
            taken.append((log, start, end))
            segments.append(Segment(errors.names[log], start, end, channel, float(errors.errors[channel][index])))
        if len(segments) == count:
            break
    return tuple(segments)
