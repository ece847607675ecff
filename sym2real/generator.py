"""Torch's generator of random numbers with a seed."""

from typing import SupportsInt

import torch


def generator_of(seed: SupportsInt) -> torch.Generator:
    """On the CPU; the seed may be an integer of NumPy's, which torch itself refuses.

    Examples:
        >>> generator_of(np.int64(3)).initial_seed()
        3
    """
    return torch.Generator().manual_seed(int(seed))
