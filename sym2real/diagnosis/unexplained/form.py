"""Findings of another form: an effect in the place of one that the catalogue lacks fits it on average, not everywhere.

A tyre's relaxation length that stands for a servo's lag is the longer the faster the car drives. Parameters of the
right form are the same everywhere. So each parameter of what was found may vary, with the rank of a feature and its
square or with that of how much it does: J (ρ - ρ̄) beside the residual's derivatives J, as a term beside what was found.
What that saves on logs left out, and its test, are those of one effect more: had the catalogue an effect that varies
so, it would have been found. J. Hausman, "Specification tests in econometrics", Econometrica 46 (1978).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch

from sym2real.diagnosis.estimate.calibrate import Calibration
from sym2real.diagnosis.estimate.whitening import PIECES, Spread, Whitening
from sym2real.diagnosis.search.select import Selection
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.dependence import Terms
from sym2real.diagnosis.unexplained.disturbance_terms import CONSTANT, Side
from sym2real.diagnosis.unexplained.features import part_of_changes
from sym2real.diagnosis.unexplained.leftover import Leftover, split_in_words
from sym2real.trajectory import Array

STRENGTH = "how much it does"


def find_form(selection: Selection, spread: Spread, own: Calibration | None = None) -> tuple[Leftover, ...]:
    """The finding of which a parameter varies most; none where all may be the same everywhere.

    Args:
        selection: what was found.
        spread: shapes of the disturbances.
        own: the base against the plain simulator.
    """
    problems, fit = selection.problems, selection.fit
    if problems.block_count < SETTINGS.fewest_pieces or not selection.chosen:
        return ()
    terms = _varying(Terms.of(selection, spread, own), problems.whitening)
    judged = [
        (term.fall(problems.folds), candidate.name, term)
        for candidate in selection.chosen
        for place in selection.places(selection.chosen, candidate)
        for term in terms.judged(problems.whitening, [place], [name for name in terms.side.terms if _of(name, place)])
    ]
    worth = [entry for entry in judged if terms.beyond_chance(entry[-1], len(judged))]
    fall, effect, term = max(worth, key=lambda entry: entry[0], default=(0.0, "", None))
    if term is None or fall <= SETTINGS.gain_beside * selection.present.loss:
        return ()
    slot, library, shapes = fit.whole[term.channel], problems.problem.library, terms.side.terms[term.name]
    varied = (shapes @ term.step[term.found :]).mean(1)  # (S,)
    motion = part_of_changes(problems.problem.segments, terms.side.columns[..., 1 + term.channel] * varied[:, None])
    feature = terms.features.get(term.name)
    along = shapes[..., 0] if feature is None else torch.as_tensor(feature.values).reshape(-1, PIECES)
    name, unit = term.name if feature else STRENGTH, library.slots[slot].parameter.unit
    sizes = fit.values[slot] + library.scale[slot] * varied
    words = split_in_words([name], along.mean(1, keepdim=True).numpy(), sizes.numpy(), unit)[1]
    return (Leftover(name, effect, min(1.0, fall / term.most), words, motion=motion),)


def _of(name: str, place: int) -> bool:
    """Whether what a parameter may vary with is a feature, or how much that parameter does."""
    return not name.startswith(STRENGTH) or name == f"{STRENGTH} {place}"


def _varying(terms: Terms, whitening: Whitening) -> Terms:
    """Terms of parameters that vary, in place of those of disturbances."""
    named = (feature for feature in terms.features.values() if feature.name != CONSTANT and not feature.within)
    means = {feature.name: terms.side.terms[feature.name].mean((0, 1)) for feature in named}
    strengths = np.sort(_strength(terms.side, whitening), axis=0)

    def varied(side: Side, weighed: Whitening) -> Side:
        moves, ranks = side.columns[..., 1:], np.linspace(-1.0, 1.0, len(strengths))
        shapes = {name: (side.terms[name] - mean)[..., 1:3] for name, mean in means.items() if name in side.terms}
        for place, sizes in enumerate(_strength(side, weighed).T):
            rank = torch.as_tensor(np.interp(sizes, strengths[:, place], ranks))
            shapes[f"{STRENGTH} {place}"] = rank[:, None, None].expand(-1, PIECES, 1)
        return replace(side, shapes=(moves / PIECES)[..., None].expand(*moves.shape, PIECES), terms=shapes)

    own = None if terms.own is None else varied(terms.own, terms.own.spread.like(whitening))
    return replace(terms, side=varied(terms.side, whitening), own=own)


def _strength(side: Side, whitening: Whitening) -> Array:
    """What a parameter changes in every segment, in standard deviations ``# (S, A)``."""
    moves = side.columns[..., 1:]
    sizes: Array = (moves * whitening.inverse_times(moves)).sum(1).clamp_min(0.0).sqrt().numpy()
    return sizes
