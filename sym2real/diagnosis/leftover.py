"""What is left after the effects that were found: pushes that the data still ask for, and what they depend on.

The push over every fifth of a segment is its most likely value given the residual, d = Q JᵀC⁻¹r; less the log's mean.
A random forest that predicts pushes of logs it has not seen (R² > 0.1) shows an effect that the library does not
have; a small tree on the signed push says where.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from sym2real import rotation
from sym2real.diagnosis.sensitivity import Problem
from sym2real.diagnosis.whitening import PIECES, Spread, Whitening
from sym2real.trajectory import Array, Trajectory

DEPENDS = 0.10
TREES, LEAF, FOLDS = 20, 8, 4
FEWEST = 60


@dataclass(frozen=True)
class Leftover:
    """A push that depends on something.

    Args:
        explained_by: the feature it depends on most.
        channel: direction of the push.
        r2: share of its variance that logs not seen confirm.
        term: where the push changes, in words.
    """

    explained_by: str
    channel: str
    r2: float
    term: str

    def to_dict(self) -> dict[str, Any]:
        return dict(vars(self))


def find_leftover(
    problem: Problem, spread: Spread, whitening: Whitening, values: torch.Tensor, own: Collection[str] = ()
) -> Leftover | None:
    """The strongest dependence of what is left at a parameter set ``# (P,)``; None where there is none.

    Args:
        problem, spread, whitening: of the logs.
        values: parameter set of the result.
        own: channels in which the base misses something of the plain simulator already; they are not looked at.
    """
    pushes = most_likely_pushes(problem, spread, whitening, values)  # (S·pieces, D)
    names, features = features_of(problem)
    logs = np.repeat(problem.segments.log, PIECES)
    for log in np.unique(logs):
        pushes[logs == log] -= pushes[logs == log].mean(axis=0)
    if len(pushes) < FEWEST:
        return None
    groups = logs if len(np.unique(logs)) > 2 else logs * 100 + np.arange(len(logs)) * 4 // len(logs)
    scored = [
        (cross_validated(features, target, groups), place)
        for place, target in enumerate(pushes.T)
        if spread.names[place] not in own
    ]
    r2, place = max(scored, default=(0.0, 0))
    if r2 <= DEPENDS:
        return None
    feature, term = _tree(names, features, pushes[:, place])
    return Leftover(feature, spread.names[place], r2, term)


def most_likely_pushes(problem: Problem, spread: Spread, whitening: Whitening, values: torch.Tensor) -> Array:
    """Pushes in their unit ``# (S·pieces, D)``."""
    residual = problem.residuals(values[None])[0]
    weighted = whitening.inverse_times(residual[..., None])  # (S, R, 1)
    power = torch.tensor([whitening.pushes[name] for name in spread.names], dtype=torch.float64)
    likely = (spread.pushes.flatten(-2).mT @ weighted)[..., 0].reshape(len(residual), len(spread.names), PIECES)
    # The model's push would have to change by minus what makes prediction less measurement.
    likely = -likely * ((power / spread.sizes) ** 2 * spread.sizes)[:, None]
    pushes: Array = likely.permute(0, 2, 1).reshape(-1, len(spread.names)).numpy()
    return pushes


def features_of(problem: Problem) -> tuple[list[str], Array]:
    """Names, and means over every piece of every segment ``# (S·pieces, features)``."""
    segments = problem.segments
    tables = [_features(trajectory) for trajectory in problem.data]
    names = list(tables[0])
    columns = [np.stack([table[name] for name in names], axis=1) for table in tables]
    edges = np.linspace(0, segments.length - 1, PIECES + 1).round().astype(int)
    rows = [
        columns[log][row + first : row + last].mean(axis=0)
        for log, row in zip(segments.log, segments.row, strict=True)
        for first, last in pairwise(edges)
    ]
    return names, np.stack(rows)


def _features(trajectory: Trajectory) -> dict[str, Array]:
    layout = trajectory.layouts.state
    found: dict[str, Array] = {"time": trajectory.time - trajectory.time[0]}
    if "z" in layout:
        found["height"] = trajectory.column("z")
    velocity = np.stack([_smooth(trajectory.column(c)) for c in ("vx", "vy", "vz") if c in layout], axis=1)
    found["speed"] = np.linalg.norm(velocity, axis=1)
    found |= {f"velocity {axis}": column for axis, column in zip("xyz", velocity.T, strict=False)}
    if layout.has_field("heading"):
        sine, cosine = trajectory.column("sin_yaw"), trajectory.column("cos_yaw")
        found["forward speed"] = velocity[:, 0] * cosine + velocity[:, 1] * sine
    if layout.has_field("attitude"):
        attitude = torch.as_tensor(trajectory.state[:, layout.slice("attitude")])
        body = rotation.rotate(rotation.conjugate(attitude), torch.as_tensor(velocity)).numpy()
        found |= {f"body velocity {axis}": column for axis, column in zip("xyz", body.T, strict=True)}
        found["tilt"] = rotation.tilt(attitude).numpy()
    found |= {name: trajectory.column(name) for name in ("wx", "wy", "wz", "vbat") if name in _names(trajectory)}
    for name in trajectory.layouts.action:
        command = trajectory.column(name)
        found[name] = command
        found[f"change of {name}"] = np.gradient(_smooth(command))
    return found


def _names(trajectory: Trajectory) -> set[str]:
    return {*trajectory.layouts.state, *trajectory.layouts.inputs, *trajectory.extra}


def _smooth(column: Array) -> Array:
    smoothed: Array = np.convolve(np.pad(column, 2, mode="edge"), np.ones(5) / 5, "valid")
    return smoothed


def cross_validated(features: Array, target: Array, groups: NDArray[np.int64]) -> float:
    """R² of a random forest on groups that it has not seen."""
    from sklearn.ensemble import RandomForestRegressor  # noqa: PLC0415 — heavy, and only needed at the end
    from sklearn.model_selection import GroupKFold, cross_val_predict  # noqa: PLC0415

    folds = GroupKFold(min(FOLDS, len(np.unique(groups))))
    forest = RandomForestRegressor(TREES, min_samples_leaf=LEAF, max_features=0.33, random_state=0)
    predicted = cross_val_predict(forest, features, target, groups=groups, cv=folds)
    return float(1.0 - np.square(target - predicted).sum() / max(np.square(target - target.mean()).sum(), 1e-300))


def _tree(names: list[str], features: Array, target: Array) -> tuple[str, str]:
    """The feature of the first split of a tree on the signed push, and the split in words."""
    from sklearn.tree import DecisionTreeRegressor  # noqa: PLC0415

    tree = DecisionTreeRegressor(max_depth=1, min_samples_leaf=len(target) // 20).fit(features, target).tree_
    feature, threshold = names[tree.feature[0]], tree.threshold[0]
    low, high = (float(tree.value[child].item()) for child in (tree.children_left[0], tree.children_right[0]))
    return feature, f"{low:.3g} where {feature} is below {threshold:.3g}, {high:.3g} above"
