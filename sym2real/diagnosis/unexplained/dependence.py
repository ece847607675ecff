"""Disturbances that depend on something measured though no effect of the library says so, judged as effects are.

The disturbances' variances take an effect that nobody named for a disturbance of its size, and shrink the most likely
disturbances towards zero, so that little of them seems to depend on anything. Here a disturbance that is a smooth
function of one feature, or of what was sent a moment ago, joins the parameters that were found, by generalised least
squares on the residuals themselves; so does a constant, because beside a gain that was found in the place
of an offset it is only seen where both are fitted. A promising one is taken out of the residuals, the variances are
estimated anew without it, and under these it must lower held-out errors and differ from none beyond chance, as an
effect must. What the base itself contributes to its score in the plain simulator does not count (see ``calibrate.py``).

An effect in the place of one that the catalogue lacks fits it on average, not everywhere: a tyre's relaxation length
that stands for a servo's lag is the longer the faster the car drives. So parameters that were found compete as well.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product

import torch

from sym2real.diagnosis.estimate.calibrate import Calibration, by_log
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.estimate.quadratic import Fit
from sym2real.diagnosis.estimate.whitening import Spread, Whitening, estimate
from sym2real.diagnosis.search.intervals import WITHIN_A_STEP
from sym2real.diagnosis.search.select import Selection
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.disturbance_terms import (
    CONSTANT,
    Feature,
    Side,
    TermFit,
    features_in,
    name_of_earlier,
)
from sym2real.diagnosis.unexplained.features import part_of_changes
from sym2real.diagnosis.unexplained.leftover import Leftover, split_in_words, unit_of
from sym2real.effects.kind import with_unit
from sym2real.logs.conditions import WHERE

# Part of the loss that a term must save before variances are estimated without it, and how many get that far.
PROMISING, MOST_TERMS = 0.003, 3
# Times that the variances are estimated without a term, each time fitted under the last ones.
ROUNDS = 2


@dataclass(frozen=True, eq=False)
class Terms:
    """All terms beside the result of a search.

    Args:
        features: of the logs, by name.
        side: the logs at the best fit.
        own: the plain simulator's data at the base's own origin; None without a simulator.
        problems: the logs, under a whitening that explains what terms would.
        fit: of what was found.
    """

    features: dict[str, Feature]
    side: Side
    own: Side | None
    problems: Problems
    fit: Fit

    @classmethod
    def of(cls, selection: Selection, spread: Spread, own: Calibration | None) -> Terms:
        """Arguments as of :func:`find_dependence`."""
        problems, fit = selection.problems, selection.fit
        features = features_in(problems.problem)
        side = Side.of(problems.problem, spread, fit.values, fit, features)
        flown = None if own is None else Side.of(own.problem, own.spread, own.values, fit, features)
        return cls(features, side, flown, problems, fit)

    @property
    def pairs(self) -> list[tuple[int, str]]:
        """Channels, each with what it may depend on: parameters that were found with ranks of features alone."""
        ranked = {name for name, feature in self.features.items() if feature.columns and not feature.within}
        count, everything = len(self.side.spread.names), self.side.shapes.shape[2]
        return [pair for pair in product(range(everything), self.side.terms) if pair[0] < count or pair[1] in ranked]

    def judged(self, whitening: Whitening, pairs: Iterable[tuple[int, str]]) -> list[TermFit]:
        """Channels that depend each on a feature, under a whitening."""
        here = self.side.products(whitening)
        there = None if self.own is None else self.own.products(self.own.spread.like(whitening))
        terms, preceding = [], self.side.columns.shape[-1] - 1
        for channel, name in pairs:
            gradient, curvature = self.side.joined(here, channel, name)
            if self.own is not None and there is not None and name in self.own.terms:
                base = self.own.joined(there, channel, name)[0]
                gradient = gradient - whitening.trust[:, None] * by_log(base, self.own.logs, self.side.logs)
            terms.append(TermFit(channel, name, preceding, gradient, curvature))
        return terms

    def promising(self) -> list[TermFit]:
        """Terms that save much even under variances that explain what they would, the best first."""
        whitening, folds = self.problems.whitening, self.problems.folds
        everything = self.judged(whitening, self.pairs)
        least = PROMISING * self.loss(whitening)
        falls = sorted(((judged.fall(folds), judged) for judged in everything), key=lambda pair: -pair[0])
        best = [judged for fall, judged in falls[:MOST_TERMS] if fall > least]
        return sorted(best, key=lambda judged: judged.name.startswith(WHERE))  # the first of those as good is taken

    def alone(self, judged: TermFit) -> tuple[TermFit, Whitening]:
        """A term under variances that are estimated without it."""
        whitening, segments = self.problems.whitening, self.problems.problem.segments
        for _ in range(ROUNDS):
            rest = self.side.after(judged.channel, judged.name, judged.step)
            whitening = estimate(self.side.spread, rest, segments.noise, segments.channel)
            (judged,) = self.judged(whitening, [(judged.channel, judged.name)])
        return judged, whitening

    def loss(self, whitening: Whitening) -> float:
        """Whitened squares without a term."""
        return float(whitening.loss(self.side.columns[None, ..., 0]).sum())

    def accepted(self, judged: TermFit) -> tuple[float, TermFit, Whitening] | None:
        """A term that lowers held-out errors by enough and is beyond chance, by blocks of 1.5 s and by whole logs.

        Returns:
            the relative fall of the held-out loss, and the term under the variances without it, and these.
        """
        (judged, whitening), problems = self.alone(judged), self.problems
        gain = judged.fall(problems.folds) / self.loss(whitening)
        needed = SETTINGS.gain_beside if self.features[judged.name].within else SETTINGS.term_gain
        if (
            gain <= needed
            or self._hidden_in_a_step(judged)
            or (judged.name == CONSTANT and judged.inflation > SETTINGS.far**2)  # as of an offset beside another
            or judged.chance(problems.blocks) >= SETTINGS.false_alarms_of_each(len(self.pairs))
        ):
            return None
        by_trim = problems.log_count >= SETTINGS.fewest_logs and judged.chance(problems.logs) > SETTINGS.level
        return None if by_trim else (gain, judged, whitening)

    def _hidden_in_a_step(self, judged: TermFit) -> bool:
        """Whether a command's dependence on what it was is less than nobody knows of when in a step it acts."""
        channel, _, _, size = self._channel(judged.channel)
        if judged.name != name_of_earlier(channel):
            return False
        hidden = WITHIN_A_STEP * float(self.features[judged.name].values[:, 0].std())
        return size * float(self._varied(judged).std()) < hidden

    def _varied(self, judged: TermFit) -> torch.Tensor:
        """What a term makes of its channel, in steps of that ``# (S, pieces)``."""
        return self.side.term(judged.channel, judged.name) @ judged.step[judged.preceding :]

    def leftover(self, judged: TermFit, whitening: Whitening) -> Leftover:
        """What an accepted term says: of a disturbance how large it is, of a parameter what its effect is."""
        segments, confirmed = self.problems.problem.segments, min(1.0, judged.fall(self.problems.folds) / judged.most)
        name, unit, level, size = self._channel(judged.channel)
        varied = self._varied(judged)
        motion = part_of_changes(segments, torch.einsum("srp,sp->sr", self.side.shapes[:, :, judged.channel], varied))
        values = (level + size * varied).flatten().numpy()
        if judged.name == CONSTANT:
            value = float(values[0])
            return Leftover(CONSTANT, name, confirmed, f"{with_unit(value, unit)} everywhere", value, unit, motion)
        # Of a parameter nothing else varies.
        share = float(values.var() / (values.var() + whitening.disturbances.get(name, 0.0) ** 2))
        feature = self.features[judged.name]
        words = split_in_words(feature.columns, feature.values, values, unit)[1]
        return Leftover(judged.name, name, share * confirmed, words, motion=motion)

    def _channel(self, number: int) -> tuple[str, str, float, float]:
        """Name and unit of what a term is of, its value without the term, and the size of a step."""
        spread, problem, count = self.side.spread, self.problems.problem, len(self.side.spread.names)
        if number < count:
            return spread.names[number], unit_of(problem, spread.names[number]), 0.0, float(spread.sizes[number])
        slot = self.fit.free[number - count]
        known, scale = problem.library.slots[slot], problem.library.scale[slot]
        return known.effect, known.parameter.unit, float(self.fit.values[slot]), float(scale)


def find_dependence(selection: Selection, spread: Spread, own: Calibration | None = None) -> tuple[Leftover, ...]:
    """The disturbance, or parameter that was found, whose dependence lowers held-out errors most; none within chance.

    Args:
        selection: what was found.
        spread: shapes of the disturbances.
        own: the base against the plain simulator.
    """
    terms = Terms.of(selection, spread, own)
    promising = terms.promising()
    if not promising:
        return ()
    # A constant that does nearly as much is the simpler answer; a parameter's is what was found.
    constants = dict.fromkeys((term.channel, CONSTANT) for term in promising if term.channel < len(spread.names))
    judged = [terms.accepted(term) for term in (*terms.judged(terms.problems.whitening, constants), *promising)]
    accepted = [term for term in judged if term is not None]
    enough = SETTINGS.nearly * max((gain for gain, _, _ in accepted), default=0.0)
    return next(((terms.leftover(term, variances),) for gain, term, variances in accepted if gain >= enough), ())
