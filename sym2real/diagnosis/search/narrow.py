"""Effects that move few of the measured directions, put beside what a search has chosen."""

from collections.abc import Iterator
from copy import copy
from functools import partial

from sym2real.diagnosis.estimate.significance import least_gain
from sym2real.diagnosis.search.near import Near
from sym2real.diagnosis.search.needed import Predicted
from sym2real.diagnosis.search.select import PROMISING, EffectSet, Selection, parameter_set
from sym2real.diagnosis.search.settled import refuted
from sym2real.diagnosis.settings import SETTINGS


def join_narrow(predicted: Predicted) -> None:
    """Put effects that move few of the measured directions beside what was chosen, where logs are not few.

    Such an effect pays less than others, so an error must surely be a tenth larger without it or whole logs establish
    it, no error may be larger with it, and the sets around must refute none: it could displace another one.
    """
    selection = predicted.selection
    while (larger := next(filter(partial(_stands, predicted), _narrow(selection)), None)) is not None:
        selection.put(larger.chosen, larger.fit)


def _stands(predicted: Predicted, larger: EffectSet) -> bool:
    selection = copy(predicted.selection)
    selection.put(larger.chosen, larger.fit)
    # Its own place refutes most of them, and all places take ten times as long.
    alone = predicted.bears_out(larger) and not Near.at(selection, larger.candidate).unlikely()
    return alone and refuted(Near.of(selection)) is None


def _narrow(selection: Selection) -> Iterator[EffectSet]:
    """Sets with one effect more that takes its part off the loss of what it moves, best first.

    During the search all effects have one price: which of two alternatives explains more is no matter of directions. A
    lag below the base's own is reported as none, and is none.
    """
    problems, count = selection.problems, len(selection.chosen) + 1
    if problems.log_count < SETTINGS.fewest_logs or count > SETTINGS.most_findings:
        return
    reference, screened = selection.screening(selection.present)
    most = (1 - PROMISING * SETTINGS.gain_of(count) / len(problems.whitening.sensor)) * reference
    smooth = [(other, start) for loss, other, start in screened if loss < most and not other.needs_start]
    for larger in selection.refitted(selection.chosen, smooth):
        reported, slots = parameter_set(selection, larger.chosen, larger.fit.values), larger.candidate.slots
        least = least_gain(problems, larger.candidate, larger.fit.values, count)
        there = bool((reported != problems.library.null)[slots].any())
        if there and larger.loss < (1 - least) * selection.present.loss and selection.holds(larger):
            yield larger
