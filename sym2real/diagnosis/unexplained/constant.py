"""A constant disturbance of every log's own: wind on several days, a load in some flights.

It is held against its change from the first half of logs to the second, by the analysis of variance in one way
(R. Fisher, "Statistical Methods for Research Workers", 1925, chapter 7). A disturbance's constant in a log is estimated
by generalised least squares on the whitened residuals, d = -Σ JᵀC⁻¹r / Σ JᵀC⁻¹J. The residuals are those of the best
fit, to whose parameters they are orthogonal: what a finding explains already is not counted again.
"""

import numpy as np
import torch
from scipy import stats
from torch import Tensor

from sym2real.diagnosis.data.segments import summed
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.channels import Channel
from sym2real.diagnosis.unexplained.dependence import Terms
from sym2real.diagnosis.unexplained.disturbance_terms import CONSTANT, Dependence, Side
from sym2real.diagnosis.unexplained.features import part_of_changes
from sym2real.diagnosis.unexplained.leftover import LOG, Leftover
from sym2real.effects.kind import with_unit
from sym2real.trajectory import Array


def find_differing(terms: Terms) -> tuple[Leftover, ...]:
    """Disturbances nearly all of whose squares are between logs, and that matter; the one that moves most first.

    A channel in which the base is off as much in the plain simulator shows its own fault.
    """
    problems, leftovers = terms.problems, list[Leftover]()
    if problems.log_count < SETTINGS.fewest_logs:
        return ()
    segments, data = problems.problem.segments, problems.data
    logs, place_of = np.unique(segments.log, return_inverse=True)
    channels = [channel for channel in terms.channels if channel.kind == "disturbance" and channel.axis is None]
    here, there = terms.products(problems.whitening)
    for channel in channels:
        constant = Dependence(channel, CONSTANT)
        chance, share, sizes = _by_log(terms.side, here, channel)
        apart, of_base = sizes - sizes.mean(), 0.0
        if terms.own is not None and there is not None:
            of_base = _by_log(terms.own, there, channel)[2].std()
        sure = chance < SETTINGS.false_alarms_of_each(len(channels)) and share > SETTINGS.nearly
        if sure and of_base <= SETTINGS.mostly * apart.std():
            moved = terms.side.by_terms([constant])[..., 0] * torch.as_tensor(apart[place_of] / channel.size)[:, None]
            ends = [(sizes[at], data[int(logs[at])].name) for at in (apart.argmin(), apart.argmax())]
            words = " and ".join(f"{with_unit(size, channel.unit)} in {log}" for size, log in ends)
            leftovers.append(Leftover(LOG, channel.name, float(share), words, motion=part_of_changes(segments, moved)))
    return tuple(sorted((entry for entry in leftovers if entry.matters), key=lambda entry: -(entry.motion or 0.0)))


def _by_log(side: Side, products: Tensor, channel: Channel) -> tuple[float, float, Array]:
    """Chance that logs differ so, the part ω² of squares that is between them, and the constants ``# (logs,)``.

    Within a log its halves differ, as by gusts that last for seconds.
    """
    logs, numbers = np.unique(side.problem.segments.log, return_inverse=True)[1], np.arange(len(products))
    middle = np.array([np.median(numbers[logs == log]) for log in range(logs.max() + 1)])
    halves = np.unique(2 * logs + (numbers > middle[logs]), return_inverse=True)[1]
    gradient, curvature = side.joined(products, [Dependence(channel, CONSTANT)])
    parts = gradient[:, -1], curvature[:, -1, -1]
    sums = [[summed(part, by) for part in parts] for by in (np.zeros_like(logs), logs, halves)]
    whole, by_log, by_half = (float((force.square() / hold.clamp_min(1e-300)).sum()) for force, hold in sums)
    freedom = logs.max(), max(1, halves.max() - logs.max())
    between, unit = by_log - whole, max(by_half - by_log, 1e-300) / freedom[1]
    share = (between - freedom[0] * unit) / (by_half - whole + unit)
    sizes = -channel.size * sums[1][0] / sums[1][1].clamp_min(1e-300)
    return float(stats.f.sf(between / freedom[0] / unit, *freedom)), share, sizes.numpy()
