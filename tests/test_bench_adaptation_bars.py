"""What the bars of the adaptation study call surely worse."""

from __future__ import annotations

import numpy as np
from adaptation_bars import surely_above


def test_worse_is_said_only_beyond_the_paired_interval() -> None:
    shared = np.random.default_rng(2).standard_normal((3, 5))
    assert surely_above(1.05 + shared, 1.0 + shared)  # paired: the common part does not hide the difference
    assert not surely_above(1.0 + 0.1 * shared, 1.0 - 0.0 * shared + 0.05)
    assert not surely_above(1.0 + shared, 1.05 + shared)
