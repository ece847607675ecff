"""Logs as CSV files, for tests."""

from collections.abc import Mapping
from pathlib import Path

import pandas as pd
from numpy.typing import ArrayLike


def saved(folder: Path, columns: Mapping[str, ArrayLike] | pd.DataFrame, name: str = "log.csv") -> Path:
    """The file of columns ``# (rows,)`` by their names, every number to its last digit."""
    pd.DataFrame(columns).to_csv(folder / name, index=False)
    return folder / name
