"""Disturbances that depend on something measured though no effect of the library says so, judged as effects are.

The disturbances' variances take an effect that nobody named for a disturbance of its size, and shrink the most likely
disturbances towards zero, so that little of them seems to depend on anything. Here a disturbance that is a smooth
function of one feature, or of what was sent a moment ago, joins the parameters that were found, by generalised least
squares on the residuals themselves; so does a constant, because beside a gain that was found in the place
of an offset it is only seen where both are fitted. A promising one is taken out of the residuals, the variances are
estimated anew without it, and under these it must lower held-out errors and differ from none beyond chance, as an
effect must. What the base itself contributes to its score in the plain simulator does not count (see ``calibrate.py``).
What is taken stays beside what is looked for next, and what is the same everywhere goes first where it is most of it.

What a disturbance depends on stands before it as well as behind it. A random disturbance, which the robot and its
controller answer, explains what follows, and little that went before explains it: C. Sims, "Money, income, and
causality", Am. Econ. Review 62 (1972).

An effect in the place of one that the catalogue lacks fits it on average, not everywhere: a tyre's relaxation length
that stands for a servo's lag is the longer the faster the car drives. So parameters that were found compete as well.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from operator import itemgetter

from torch import Tensor

from sym2real.diagnosis.estimate.calibrate import Calibration, by_log
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.estimate.whitening import Spread, Whitening, estimate
from sym2real.diagnosis.search.intervals import WITHIN_A_STEP
from sym2real.diagnosis.search.select import Selection
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.channels import TURNED, Channel, channels_of
from sym2real.diagnosis.unexplained.disturbance_terms import CONSTANT, Dependence, Feature, Side, TermFit, ranked
from sym2real.diagnosis.unexplained.features import part_of_changes
from sym2real.diagnosis.unexplained.leftover import Leftover, split_in_words
from sym2real.effects.kind import with_unit
from sym2real.least_squares import inflation, solve
from sym2real.logs.conditions import WHERE

# Terms for which variances are estimated without them.
MOST_TERMS = 3
# Times that the variances are estimated without a term, each time fitted under the last ones.
ROUNDS = 2
# Disturbances that are told beside each other.
MOST_LEFT = 4


@dataclass(frozen=True, eq=False)
class Terms:
    """All terms beside the result of a search.

    Args:
        features: of the logs, by name.
        channels: what may depend on them.
        side: the logs at the best fit.
        own: the plain simulator's data at the base's own origin; None without a simulator.
        problems: the logs, under a whitening that explains what terms would.
        beside: terms that were taken.
    """

    features: dict[str, Feature]
    channels: list[Channel]
    side: Side
    own: Side | None
    problems: Problems
    beside: tuple[Dependence, ...] = ()

    @classmethod
    def of(cls, selection: Selection, spread: Spread, own: Calibration | None) -> Terms:
        """Beside what was found.

        Args:
            selection: what was found.
            spread: shapes of the disturbances.
            own: the base against the plain simulator.
        """
        problems, fit = selection.problems, selection.fit
        side = Side.of(problems.problem, spread, fit.values, fit)
        flown = None if own is None else Side.of(own.problem, own.spread, own.values, fit, side.features)
        return cls(side.features, channels_of(problems.problem, spread, fit), side, flown, problems)

    @property
    def pairs(self) -> list[Dependence]:
        """Channels, each with what it may depend on and was not taken.

        What measurements are off by is constant, and parameters that were found depend on ranks of features alone.
        """
        may = {"disturbance": list(self.side.terms[0]), "measured": [CONSTANT]}
        may["fitted"] = [name for name in self.side.terms[0] if ranked(name)]
        pairs = (Dependence(along, name) for along in self.channels for name in may[along.kind])
        # The constant is the first term's of a channel.
        levels = [Dependence(own.channel, CONSTANT) for own in self.beside if ranked(own.name)]
        return [pair for pair in pairs if pair not in (*self.beside, *levels)]

    def judged(self, whitening: Whitening, pairs: Iterable[Dependence]) -> list[TermFit]:
        """Channels that depend each on a feature, under a whitening."""
        here, there = self.products(whitening)
        preceding, judged = self.side.columns.shape[-1] - 1 + self.side.basis(self.beside)[1].shape[-1], []
        for pair in pairs:
            terms = (*self.beside, pair)
            gradient, curvature = self.side.joined(here, terms)
            if self.own is not None and there is not None and all(map(self.own.has, terms)):
                base, _ = self.own.joined(there, terms)
                names = self.own.problem.log_names, self.side.problem.log_names
                gradient = gradient - whitening.trust[:, None] * by_log(base, *names)
            judged.append(TermFit(terms, preceding, gradient, curvature))
        return judged

    def products(self, whitening: Whitening) -> tuple[Tensor, Tensor | None]:
        """Those of the logs under their whitening, and of the plain simulator's data under one like it."""
        own = self.own
        return self.side.products(whitening), None if own is None else own.products(own.spread.like(whitening))

    def promising(self) -> list[TermFit]:
        """Terms that go beyond chance even where variances explain what they would, the best first, or a simpler one.

        A constant is simpler, where it is most of what depends on something; so is what is nearly as good and depends
        neither on where the robot is nor on where it points.
        """
        whitening, folds = self.problems.whitening, self.problems.folds
        falls = [(judged.fall(folds), judged) for judged in self.judged(whitening, self.pairs)]
        ordered = sorted(falls, key=partial(_order, *max(falls, key=itemgetter(0)))) if falls else []
        likely = (judged for fall, judged in ordered if fall > 0.0 and self._likely(judged))
        return list(islice(likely, MOST_TERMS))

    def _likely(self, judged: TermFit) -> bool:
        """Whether a term goes beyond chance, and neither a step nor what was found hides it."""
        if judged.chance(self.problems.blocks) >= SETTINGS.false_alarms or self._hidden_in_a_step(judged):
            return False
        # Of a constant beside an offset that was found nobody knows which of the two it is.
        return judged.term.name != CONSTANT or float(inflation(judged.curvature.sum(0))[-1]) <= SETTINGS.far**2

    def alone(self, judged: TermFit) -> tuple[TermFit, Whitening]:
        """A term under variances that are estimated without it."""
        whitening, segments = self.problems.whitening, self.problems.problem.segments
        for _ in range(ROUNDS):
            rest = self.side.after(judged.terms, judged.step)
            whitening = estimate(self.side.spread, rest, segments.noise, segments.channel)
            (judged,) = self.judged(whitening, [judged.term])
        return judged, whitening

    def loss(self, whitening: Whitening) -> float:
        """Whitened squares with the terms that were taken, and no other."""
        whole = float(whitening.loss(self.side.columns[None, ..., 0]).sum())
        if not self.beside:
            return whole
        gradient, curvature = (part.sum(0) for part in self.side.joined(self.side.products(whitening), self.beside))
        return whole - float(gradient @ solve(curvature, gradient))

    def accepted(self, judged: TermFit) -> tuple[TermFit, Whitening] | None:
        """A term that is beyond chance, by blocks of 1.5 s and by whole logs.

        Returns:
            the term under the variances without it, and these.
        """
        (judged, whitening), problems = self.alone(judged), self.problems
        by_blocks = judged.chance(problems.blocks) < SETTINGS.false_alarms_of_each(len(self.pairs))
        if not by_blocks or judged.fall(problems.folds) <= 0.0:
            return None
        if judged.term.name != CONSTANT and self._answered(judged, whitening):
            return None
        by_trim = problems.log_count >= SETTINGS.fewest_logs and judged.chance(problems.logs) > SETTINGS.level
        return None if by_trim else (judged, whitening)

    def _answered(self, judged: TermFit, whitening: Whitening) -> bool:
        """Whether what is measured behind a disturbance explains more of it, and what is before little."""
        moved, folds = [judged.term._replace(move=move) for move in (1, -1)], self.problems.folds
        behind, before = (other.fall(folds) for other in self.judged(whitening, moved))
        return judged.fall(folds) < behind and before < SETTINGS.mostly * behind

    def _hidden_in_a_step(self, judged: TermFit) -> bool:
        """Whether a command's dependence on what it was is less than nobody knows of when in a step it acts."""
        # A constant has no column, and hides nothing.
        term, hidden = judged.term, WITHIN_A_STEP * float(self.features[judged.term.name].values.std(0)[:1].sum())
        return term.of_its_past and term.channel.size * float(self._varied(judged).std()) < hidden

    def _varied(self, judged: TermFit) -> Tensor:
        """What a term makes of its channel, in steps of that ``# (S, pieces)``."""
        return self.side.shapes_of(judged.term, judged.terms[:-1]) @ judged.step[judged.preceding :]

    def best(self) -> tuple[TermFit, Whitening] | None:
        """The first promising term that is accepted, under variances without it; None without any."""
        return next(filter(None, map(self.accepted, self.promising())), None)

    def with_term(self, judged: TermFit, whitening: Whitening) -> Terms:
        """What else there is beside a term that was taken."""
        return replace(self, problems=replace(self.problems, whitening=whitening), beside=judged.terms)

    def leftover(self, judged: TermFit, whitening: Whitening) -> Leftover:
        """What an accepted term says: of a disturbance how large it is, of a parameter what its effect is."""
        segments, fall, step = self.problems.problem.segments, judged.fall(self.problems.folds), judged.step
        (channel, name, _), confirmed = judged.term, min(1.0, fall / judged.most)
        enough = SETTINGS.gain_beside if self.features[name].within else SETTINGS.term_gain
        left = Leftover(name, channel.name, confirmed, "", faint=fall <= enough * self.loss(whitening))
        if channel.kind != "measured":
            alone = self.side.by_terms(judged.terms)[..., judged.preceding - len(step) :] @ step[judged.preceding :]
            left = replace(left, motion=part_of_changes(segments, alone))
        values = (channel.level + channel.size * self._varied(judged)).flatten().numpy()
        if name == CONSTANT:
            value, unit = float(values[0]), channel.unit
            return replace(left, term=f"{with_unit(value, unit)} everywhere", size=value, unit=unit)
        # Of a parameter nothing else varies.
        other = whitening.disturbances.get(channel.name.removesuffix(TURNED), 0.0)
        share, feature = float(values.var() / (values.var() + other**2)), self.features[name]
        words = split_in_words(feature.columns, feature.values, values, channel.unit)
        return replace(left, r2=share * confirmed, term=words)


def _order(most: float, best: TermFit, pair: tuple[float, TermFit]) -> tuple[bool, bool, float]:
    """Of a term with its fall: first the best one's constant, then those as good, then the others."""
    fall, (channel, name, _) = pair[0], pair[1].term
    constant = (channel, name) == (best.term.channel, CONSTANT) and fall >= SETTINGS.mostly * most
    alike = fall >= SETTINGS.nearly * most and not name.startswith(WHERE) and channel.axis is None
    return not constant, not alike, -fall


def find_dependences(terms: Terms) -> tuple[Leftover, ...]:
    """What depends on something, or is off by a constant, one after the other; none within chance.

    A parameter that was found and depends on something is of another form.
    """
    leftovers = dict[tuple[str, str], Leftover]()  # several parameters of an effect may vary with the same
    for _ in range(MOST_LEFT):
        if (best := terms.best()) is None:
            break
        leftover, terms = terms.leftover(*best), terms.with_term(*best)
        leftovers.setdefault((leftover.channel, leftover.explained_by), leftover)
        if leftover.faint:
            break
    return tuple(leftovers.values())
