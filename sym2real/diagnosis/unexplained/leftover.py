"""What is left after the effects that were found: disturbances that the data still ask for, and what they depend on.

The disturbance over every fifth of a segment is its most likely value given the residual, d = Q JᵀC⁻¹r, less the
log's mean (which ``constant.py`` looks at). A random forest that predicts disturbances of logs it has not seen
(R² > 0.1) shows an effect that the library does not have; a small tree on the signed disturbance says where.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from sym2real.diagnosis.data.segments import unseen_r2
from sym2real.diagnosis.estimate.whitening import PIECES, Whitened
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.features import (
    TURNED,
    axes_of,
    features_of,
    part_of_disturbances,
    within,
)
from sym2real.effects.kind import with_unit
from sym2real.logs.conditions import WHERE
from sym2real.symbolic.mass_normalised import unit_for
from sym2real.trajectory import Array

TREES, LEAF, FOLDS = 20, 8, 4
# Whitened squares per degree of freedom of an answer that leaves something out: null data leave 1.07 at most.
MISFIT = "misfit"
# What a disturbance depends on that each log has of its own.
LOG = "log"


@dataclass(frozen=True)
class Leftover:
    """A disturbance that depends on something, or is the same everywhere: an entry of ``leftovers`` in docs/method.md.

    Args:
        explained_by: the feature it depends on most, "constant", "log" where each has its own, or "misfit" where no
            disturbance is left.
        channel: direction of the disturbance; of a misfit what is predicted so badly, empty for all.
        r2: share of its variance (of its squares, where it is constant) that logs not seen confirm; of its squares that
            are between logs; of a misfit's squares that noise and disturbances do not make.
        term: where the disturbance changes, in words.
        size, unit: of a constant disturbance, as the model lacks it.
        motion: part of the robot's motion that it makes (``features.py``); None of a measurement that is off.
        instead: key of an effect that explains more than the channel's, which was found, in the part of the logs that
            ``explained_by`` names (``part_of_logs.py``); ``r2`` is then how much more.
    """

    explained_by: str
    channel: str
    r2: float
    term: str
    size: float | None = None
    unit: str = ""
    motion: float | None = None
    instead: str = ""

    @property
    def unseen(self) -> bool:
        """Whether its share is one of logs that were not seen."""
        return self.explained_by not in (MISFIT, LOG) and not self.instead

    @property
    def matters(self) -> bool:
        """Whether predictions need it."""
        return self.motion is None or self.motion >= SETTINGS.negligible


@dataclass(frozen=True, eq=False)
class Rest:
    """What is left of a data set at a parameter set.

    Args:
        names, units, sizes: of the disturbances, level forces in world axes and in the robot's; what counts as one.
        disturbances: less the log's mean ``# (pieces, D)``.
        motion: part of the robot's motion that each makes.
        features: their names.
        values: features of every piece ``# (pieces, F)``.
        around: the same of the piece before, and of the one behind.
        groups: pieces that are left out together ``# (pieces,)``.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    sizes: tuple[float, ...]
    disturbances: Array
    motion: tuple[float, ...]
    features: list[str]
    values: Array
    around: tuple[Array, Array]
    groups: NDArray[np.int64]

    @classmethod
    def of(cls, whitened: Whitened) -> Rest:
        """What the parameter set leaves of a data set."""
        problem, spread = whitened.problem, whitened.spread
        features, (before, values, behind) = features_of(problem)
        names, axes = axes_of(problem, spread.names)
        logs = np.repeat(problem.segments.log, PIECES)
        disturbances = within(np.einsum("pd,cpd->pc", most_likely_disturbances(whitened), axes), logs)
        groups = logs if len(np.unique(logs)) > 2 else logs * 100 + np.arange(len(logs)) * 4 // len(logs)
        units = tuple(unit_of(problem, name.partition(" ")[0]) for name in names)
        along = zip(axes, disturbances.T, strict=True)
        motion = tuple(part_of_disturbances(problem.segments, spread, axis * size[:, None]) for axis, size in along)
        sizes = tuple((axes[:, 0] @ spread.sizes.numpy()).tolist())
        return cls(names, units, sizes, disturbances, motion, features, values, (before, behind), groups)

    def explained(self, channel: str) -> tuple[float, float]:
        """R² of a disturbance on pieces not seen, and the size of what is so explained in its unit."""
        r2 = self._confirmed(channel, self.values)
        return r2, float(np.sqrt(max(r2, 0.0)) * self.disturbances[:, self.names.index(channel)].std())

    def answered(self, channel: str, r2: float) -> bool:
        """Whether a disturbance is what the robot and its controller answer, instead of depending on what they do.

        What a disturbance depends on stands before it as well as behind it. A random disturbance explains what follows,
        and little that went before explains it: C. Sims, "Money, income, and causality", Am. Econ. Review 62 (1972).

        Args:
            channel: of the disturbance.
            r2: of :meth:`explained`.
        """
        before, behind = (self._confirmed(channel, values) for values in self.around)
        return r2 < behind and before < SETTINGS.mostly * behind

    def _confirmed(self, channel: str, values: Array) -> float:
        return float(cross_validated(values, self.disturbances[:, [self.names.index(channel)]], self.groups)[0])

    def suspects(self) -> list[str]:
        """Channels that may depend on something, the likeliest first: one forest for all of them says so."""
        shares = cross_validated(self.values, self.disturbances / (self.disturbances.std(axis=0) + 1e-300), self.groups)
        return [self.names[place] for place in np.argsort(-shares) if shares[place] > SETTINGS.suspect]


def find_misfit(squares: float, motion: float | None = None) -> tuple[Leftover, ...]:
    """A misfit that neither noise nor disturbances describe; none where the data are explained.

    Args:
        squares: whitened, per degree of freedom.
        motion: part of the robot's motion that the errors make, noise included.
    """
    if squares <= SETTINGS.misfit:
        return ()
    share, words = 1.0 - 1.0 / squares, f"{squares:.2f} whitened squares per degree of freedom"
    return (Leftover(MISFIT, "", share, words, motion=motion and float(np.sqrt(share)) * motion),)


def find_leftovers(rest: Rest, own: Whitened | None = None) -> tuple[Leftover, ...]:
    """What is left and depends on something, the strongest first.

    Args:
        rest: of the logs.
        own: the base against the plain simulator: a channel in which it misses as much there shows its own fault and is
            passed over.
    """
    if len(rest.disturbances) < SETTINGS.disturbance_pieces:
        return ()
    rest_of, leftovers = cache(Rest.of), []
    scored = ((*rest.explained(channel), channel) for channel in rest.suspects())
    for r2, size, channel in _in_one_frame([entry for entry in scored if entry[0] > SETTINGS.worth_saying]):
        place = rest.names.index(channel)
        if size < SETTINGS.negligible * rest.sizes[place] or rest.answered(channel, r2):
            continue
        if own is not None and rest_of(own).explained(channel)[1] > SETTINGS.mostly * size:
            continue
        feature, term = split_in_words(rest.features, rest.values, rest.disturbances[:, place], rest.units[place])
        leftovers.append(Leftover(feature, channel, r2, term, motion=float(np.sqrt(r2)) * rest.motion[place]))
    return tuple(leftovers)


def _in_one_frame(scored: list[tuple[float, float, str]]) -> list[tuple[float, float, str]]:
    """R², size and channel, the strongest first, level forces in world axes unless more is explained in the robot's."""
    turned = [entry for entry in scored if entry[2].endswith(TURNED)]
    level = [entry for entry in scored if entry[2] in [name.removesuffix(TURNED) for _, _, name in turned]]
    best, in_world = (max((r2 for r2, _, _ in entries), default=0.0) for entries in (turned, level))
    worse = turned if in_world >= SETTINGS.nearly * best else level
    return sorted((entry for entry in scored if entry not in worse), reverse=True)


def most_likely_disturbances(whitened: Whitened) -> Array:
    """Disturbances in their unit ``# (S·pieces, D)``."""
    residual, spread, whitening = whitened.residuals, whitened.spread, whitened.whitening
    weighted = whitening.inverse_times(residual[..., None])  # (S, R, 1)
    power = torch.tensor([whitening.disturbances[name] for name in spread.names], dtype=torch.float64)
    likely = (spread.disturbances.flatten(-2).mT @ weighted)[..., 0].reshape(len(residual), len(spread.names), PIECES)
    # The model's disturbance would have to change by minus what makes prediction less measurement.
    likely = -likely * ((power / spread.sizes) ** 2 * spread.sizes)[:, None]
    return likely.permute(0, 2, 1).reshape(-1, len(spread.names)).numpy()


def cross_validated(features: Array, targets: Array, groups: NDArray[np.int64]) -> Array:
    """R² of each target ``# (pieces, D)`` by a random forest on groups that it has not seen ``# (D,)``."""
    from sklearn.ensemble import RandomForestRegressor  # noqa: PLC0415 — heavy, and only needed at the end

    forest = RandomForestRegressor(TREES, min_samples_leaf=LEAF, max_features=0.33, random_state=0)
    return unseen_r2(forest, features, targets, groups, FOLDS)


def unit_of(problem: Problem, name: str) -> str:
    """Unit of a disturbance."""
    equations, layouts = problem.library.equations, problem.library.equations.layouts
    return unit_for(equations, (layouts.inputs if name in layouts.inputs else layouts.action).units[name])


def split_in_words(names: Sequence[str], features: Array, target: Array, unit: str) -> tuple[str, str]:
    """The feature of the first split of a tree on the signed disturbance, and the split in words.

    Where the robot is explains only what nothing else does nearly as well.
    """
    anywhere = [place for place, name in enumerate(names) if not name.startswith(WHERE)] or [0]
    by_all, by_others = (_split(features[:, places], target) for places in ([*range(len(names))], anywhere))
    nearly = by_others.impurity[0] - _left(by_others) >= SETTINGS.nearly * (by_all.impurity[0] - _left(by_all))
    tree, feature = (by_others, names[anywhere[by_others.feature[0]]]) if nearly else (by_all, names[by_all.feature[0]])
    low, high = (float(tree.value[child].item()) for child in (tree.children_left[0], tree.children_right[0]))
    below = f"{with_unit(low, unit)} where {feature} is below {tree.threshold[0]:.3g}"
    return feature, f"{below}, {with_unit(high, unit)} above"


def _split(features: Array, target: Array) -> Any:
    from sklearn.tree import DecisionTreeRegressor  # noqa: PLC0415

    stump = DecisionTreeRegressor(max_depth=1, min_samples_leaf=len(target) // 20, random_state=0)
    return stump.fit(features, target).tree_


def _left(tree: Any) -> float:
    """Variance that a single split leaves."""
    return float(tree.n_node_samples[1:] @ tree.impurity[1:] / tree.n_node_samples[0])
