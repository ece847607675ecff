"""Pushes that depend on something measured though no effect of the library says so, judged as effects are.

The disturbances' variances take an effect that nobody named for a disturbance of its size, and most likely pushes are
shrunk towards zero by them, so that little of them seems to depend on anything. Here a push that is a smooth function
of one feature, or of what was sent a moment ago, joins the parameters that were found, by generalised least squares on
the residuals themselves; so does a constant, because beside a gain that was found in the place of an offset it is only
seen where both are fitted. A promising one is taken out of the residuals, the variances are estimated anew without it,
and under these it must lower held-out errors and differ from none beyond chance, as an effect must. What the base
itself contributes to its score in the plain simulator does not count (see ``cleaned.py``).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from itertools import product

from sym2real.diagnosis.estimate.calibrate import Calibration, by_log
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.estimate.significance import FALSE_ALARMS, FEWEST_BLOCKS, FEWEST_LOGS
from sym2real.diagnosis.estimate.whitening import Spread, Whitening, estimate
from sym2real.diagnosis.search.select import GAIN, Selection
from sym2real.diagnosis.unexplained.constant import CONSTANT
from sym2real.diagnosis.unexplained.leftover import Leftover, split_in_words, unit_of
from sym2real.diagnosis.unexplained.push_terms import Feature, Judged, Side, features_in

# Part of the loss that a term must save before variances are estimated without it, and how many get that far.
PROMISING, MOST_TERMS = 0.003, 3
# Times that the variances are estimated without a term, each time fitted under the last ones.
ROUNDS = 2
# Relative fall of the held-out loss that a term needs, and the part of the best one's that makes a simpler one do. Trim
# that differs from log to log is a function of whatever does so too: null sets show falls of 0.8 %, right findings
# leave 1.2 % (grip, whose form is a little wrong). What was sent a moment ago needs as much as any first finding.
GAIN_ACROSS, NEARLY = 0.015, 0.9
# Small chance of a false alarm by whole logs, on which three or four coefficients leave few degrees of freedom.
BY_LOGS = 0.05


@dataclass(frozen=True, eq=False)
class Accepted:
    """A term that is there.

    Args:
        term: under the variances that are estimated without it.
        whitening: these.
        gain: relative fall of the held-out loss.
        confirmed: part of its fall that logs not seen confirm.
    """

    term: Judged
    whitening: Whitening
    gain: float
    confirmed: float


@dataclass(frozen=True, eq=False)
class Terms:
    """All terms beside the result of a search.

    Args:
        features: of the logs, by name.
        side: the logs at the best fit.
        own: the plain simulator's data at the base's own origin; None without a simulator.
        problems: the logs, under a whitening that explains what terms would.
    """

    features: dict[str, Feature]
    side: Side
    own: Side | None
    problems: Problems

    @classmethod
    def of(cls, selection: Selection, spread: Spread, own: Calibration | None) -> Terms:
        """Arguments as of :func:`find_dependence`."""
        problems, fit = selection.problems, selection.fit
        features = features_in(problems.problem)
        side = Side.of(problems.problem, spread, fit.values, fit.whole, features)
        flown = None if own is None else Side.of(own.problem, own.spread, own.origin, fit.whole, features)
        return cls(features, side, flown, problems)

    def judged(self, whitening: Whitening, channels: Iterable[int], names: Collection[str]) -> list[Judged]:
        """Pushes of some channels that depend on some features, under a whitening."""
        here = self.side.moments(whitening)
        there = None if self.own is None else self.own.moments(self.own.spread.like(whitening))
        found = []
        for channel, name in product(channels, names):
            gradient, curvature = here.joined(channel, self.side.terms[name])
            if self.own is not None and there is not None and name in self.own.terms:
                base = there.joined(channel, self.own.terms[name])[0]
                gradient = gradient - whitening.trust[:, None] * by_log(base, self.own.logs, self.side.logs)
            found.append(Judged(channel, name, here.found, gradient, curvature))
        return found

    def promising(self) -> list[Judged]:
        """Terms that save much even under variances that explain what they would, the best first."""
        whitening, folds = self.problems.whitening, self.problems.folds
        everything = self.judged(whitening, range(len(self.side.spread.names)), self.side.terms)
        least = PROMISING * self.loss(whitening)
        falls = [one.fall(folds) for one in everything]
        order = sorted(range(len(falls)), key=lambda place: -falls[place])
        return [everything[place] for place in order[:MOST_TERMS] if falls[place] > least]

    def alone(self, one: Judged) -> tuple[Judged, Whitening]:
        """A term under variances that are estimated without it."""
        whitening, segments = self.problems.whitening, self.problems.problem.segments
        for _ in range(ROUNDS):
            rest = self.side.after(one.channel, one.name, one.step)
            whitening = estimate(self.side.spread, rest, segments.noise, segments.channel)
            (one,) = self.judged(whitening, [one.channel], [one.name])
        return one, whitening

    def loss(self, whitening: Whitening) -> float:
        """Whitened squares without a term."""
        return float(whitening.loss(self.side.columns[None, ..., 0]).sum())

    def beyond_chance(self, one: Judged) -> bool:
        """Whether a term differs from none beyond chance, by blocks of a second and by whole logs."""
        tried = len(self.side.terms) * len(self.side.spread.names)
        if one.chance(self.problems.blocks) >= FALSE_ALARMS / tried:
            return False
        return self.problems.log_count < FEWEST_LOGS or one.chance(self.problems.logs) <= BY_LOGS

    def accepted(self, one: Judged) -> Accepted | None:
        """A term that lowers held-out errors by enough and is beyond chance; None otherwise."""
        one, whitening = self.alone(one)
        fall = one.fall(self.problems.folds)
        gain = fall / self.loss(whitening)
        if gain <= (GAIN if self.features[one.name].within else GAIN_ACROSS) or not self.beyond_chance(one):
            return None
        return Accepted(one, whitening, gain, min(1.0, fall / one.most))

    def leftover(self, found: Accepted, unit: str) -> Leftover:
        """What an accepted term says, its channel's unit given."""
        one, channel = found.term, self.side.spread.names[found.term.channel]
        size = float(self.side.spread.sizes[one.channel])
        push = (self.side.terms[one.name] @ one.step[one.found :]).flatten().numpy() * size
        if one.name == CONSTANT:
            value = float(push[0])
            return Leftover(CONSTANT, channel, found.confirmed, f"{value:.3g} {unit} everywhere", value, unit)
        share = float(push.var() / (push.var() + found.whitening.pushes[channel] ** 2))
        feature = self.features[one.name]
        words = split_in_words(feature.columns, feature.values, push, unit)[1]
        return Leftover(one.name, channel, share * found.confirmed, words)


def find_dependence(selection: Selection, spread: Spread, own: Calibration | None = None) -> tuple[Leftover, ...]:
    """The push that depends on something and lowers held-out errors most; none where no such push is beyond chance.

    Args:
        selection: what was found.
        spread: shapes of the pushes.
        own: the base against the plain simulator.
    """
    if selection.problems.block_count < FEWEST_BLOCKS:
        return ()
    terms = Terms.of(selection, spread, own)
    promising = terms.promising()
    if not promising:
        return ()
    # A constant that does nearly as much is the simpler answer.
    channels = {one.channel for one in promising}
    constants = terms.judged(selection.problems.whitening, channels, [CONSTANT])
    judged = [terms.accepted(one) for one in (*constants, *promising)]
    found = [one for one in judged if one is not None]
    if not found:
        return ()
    enough = NEARLY * max(one.gain for one in found)
    best = next(one for one in found if one.gain >= enough)
    return (terms.leftover(best, unit_of(selection.problems.problem, spread.names[best.term.channel])),)
