"""One thread for what is many small sums: more of them wait for each other, and sum in another order."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

import torch
from threadpoolctl import threadpool_limits

_outside = ContextVar[int | None]("torch's threads outside of one_thread", default=None)


@contextmanager
def one_thread() -> Iterator[None]:
    """Sums in one order, whatever number of threads torch and NumPy may use: the same seed gives the same bits."""
    before, mark = torch.get_num_threads(), _outside.set(available_threads())
    torch.set_num_threads(1)
    try:
        with threadpool_limits(1):
            yield
    finally:
        torch.set_num_threads(before)
        _outside.reset(mark)


def available_threads() -> int:
    """As many as torch has, or had before :func:`one_thread`: for what gives the same bits on any number of them."""
    return _outside.get() or torch.get_num_threads()
