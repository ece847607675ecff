"""What may be done to logs without changing what a diagnosis should say of them."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from sym2real.dataset import Dataset
from sym2real.level_ground import Turn
from sym2real.trajectory import Trajectory

FARTHEST = 5.0  # m that a world's origin is moved by
SPLIT = (0.4, 0.6)  # part of a log that its first piece is
LATER = (20, 60)  # rows by which a log starts later

Change = Callable[[Dataset, np.random.Generator], Dataset]


def drawn_turn(rng: np.random.Generator) -> Turn:
    """Any direction, anywhere within :data:`FARTHEST`."""
    return Turn(rng.uniform(-np.pi, np.pi), *rng.uniform(-FARTHEST, FARTHEST, 2))


def turned(data: Dataset, rng: np.random.Generator) -> Dataset:
    """All worlds turned by one angle and moved."""
    turn = drawn_turn(rng)
    return Dataset(turn.of_log(log) for log in data)


def turned_each(data: Dataset, rng: np.random.Generator) -> Dataset:
    """Every log's world turned by an angle of its own; no case of what is tied to the world, as a wind is."""
    return Dataset(drawn_turn(rng).of_log(log) for log in data)


def split(data: Dataset, rng: np.random.Generator) -> Dataset:
    """Every log cut in two near its middle; stamps stay."""
    pieces = []
    for log in data:
        at = round(rng.uniform(*SPLIT) * len(log))
        pieces.append(replace(log.rows(0, at), name=f"{log.name} first"))
        pieces.append(replace(log.rows(at, len(log)), name=f"{log.name} second"))
    return Dataset(pieces)


def shuffled(data: Dataset, rng: np.random.Generator) -> Dataset:
    """The logs in another order."""
    return Dataset(data[int(place)] for place in rng.permutation(len(data)))


def later(data: Dataset, rng: np.random.Generator) -> Dataset:
    """Logs whose recording began some rows later; stamps stay."""
    return Dataset(log.rows(int(rng.integers(*LATER)), len(log)) for log in data)


def half_rate(data: Dataset, _: np.random.Generator) -> Dataset:
    """Every second row, with the command that was sent there."""
    return Dataset(every_second(log) for log in data)


def every_second(log: Trajectory) -> Trajectory:
    """Rows 0, 2, 4, …"""
    return taken(log, slice(None, None, 2))


def taken(log: Trajectory, rows: slice | np.ndarray) -> Trajectory:
    """These rows of a log, with their stamps."""
    parts = {name: getattr(log, name)[rows] for name in ("time", "state", "action", "inputs")}
    return replace(log, **parts, extra={name: values[rows] for name, values in log.extra.items()})


CHANGES: dict[str, Change] = {
    "turned": turned,
    "turned each": turned_each,
    "split": split,
    "shuffled": shuffled,
    "later": later,
    "half rate": half_rate,
}
