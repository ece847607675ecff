"""Logs as a careless user or a broken sensor writes them."""

from collections.abc import Mapping

from sym2real.dataset import Dataset


def times(data: Dataset, factors: Mapping[str, float]) -> Dataset:
    """Logs with columns of state and action in other units, or with another sign."""
    return Dataset(log.with_columns({name: by * log.column(name) for name, by in factors.items()}) for log in data)
