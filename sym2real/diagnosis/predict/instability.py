"""How long segments of a robot may be that falls over: errors of their starts grow, and nothing stops them."""

import numpy as np
import torch

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import SETTLING, WARM_UP, segment_length, segments_at
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem

# Natural logarithm of how far errors of a start may grow: at 2.5 fits of simulated arms still end where they should, at
# 3.5 no more. Fewest rows all the same, and about how many rows are looked at.
GROWTH, FEWEST_ROWS, LOOKED_AT = 2.0, 12, 200


def steady_length(library: Library, data: Dataset) -> int:
    """Rows of a segment, fewer than usual where errors of its start would grow more than sevenfold.

    Further ahead the likelihood has peaks beside that of the truth, and no derivative leads from one to another.
    """
    usual = segment_length(data.layouts.state, data.dt)
    return min(usual, max(FEWEST_ROWS, int(GROWTH / max(unstable_rate(library, data) * data.dt, 1e-12))))


def unstable_rate(library: Library, data: Dataset) -> float:
    """Real part of the fastest pole that is unstable in 1/s, 0 where none is: its mean along logs.

    Of the model without effects, linearised about what was measured over one step.
    """
    apart = max(1, sum(map(len, data)) // LOOKED_AT)
    rows = [np.arange(SETTLING + WARM_UP, len(log) - 2, apart) for log in data]
    log = np.repeat(np.arange(len(data)), [len(own) for own in rows])
    layout = data.layouts.state
    steps = segments_at(data, log, np.concatenate(rows), 2, [field.name for field in layout.fields])
    following = Problem(library, data, steps).start_jacobian(library.null)[:, -layout.tangent_size :]
    poles = torch.linalg.eigvals(following[following.isfinite().flatten(1).all(1)]).abs().amax(1)
    return float(poles.log().clamp_min(0.0).mean()) / data.dt if len(poles) else 0.0
