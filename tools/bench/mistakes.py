"""Mistakes of a user: what they do to a healthy log, and how an answer names them.

Those that are made with each robot are in mistakes_list.py.

A mistake is a function of a log's columns and of the seed's generator of random numbers. It is named by an effect of
:attr:`Mistake.keys` (patterns), or by a sentence that :attr:`Mistake.words` (a regular expression) is found in.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from fnmatch import fnmatch

import numpy as np
import torch

from sym2real import rotation
from sym2real.dataset import Dataset
from sym2real.trajectory import Array, Trajectory

Columns = Mapping[str, Array]
Rng = np.random.Generator
Apply = Callable[[Columns, Rng], Columns]
QUATERNION = ("qw", "qx", "qy", "qz")
DEGREES = 180.0 / np.pi
LATE, EARLY = r"\b(late|behind|delayed)\b", r"\b(early|ahead)\b"
COMMANDED = r"(command|thrust|steer|speed|_cmd)\w*\b.*"
# A command that was written before it was sent looks like a delay; one that was written after it like none.
WRITTEN_LATE, WRITTEN_EARLY = COMMANDED + LATE, COMMANDED + EARLY
ORDER = r"\b(swapped|exchanged|interchanged|another order|other order)\b"
STALE = r"\b(repeats?|repeated|stale|duplicates?|frozen|stands? still)\b"
JUMP = r"\b(jumps?|outliers?|spikes?)\b"


@dataclass(frozen=True)
class Mistake:
    """One thing that goes wrong when a log is written.

    Args:
        name: in plain words.
        apply: new values of the columns that it changes, from all ``# (rows,)``; the same draw for every log.
        words: what a sentence that names it has in it.
        keys: patterns of effects that are it.
    """

    name: str
    apply: Apply
    words: str
    keys: tuple[str, ...] = ()

    def made(self, data: Dataset, seed: int) -> Dataset:
        """The logs with the mistake in them; nobody has logged references."""
        return Dataset(self._of_log(log, np.random.default_rng(seed)) for log in data)

    def _of_log(self, log: Trajectory, rng: Rng) -> Trajectory:
        layouts = log.layouts
        columns = {name: log.column(name) for name in (*layouts.state, *layouts.action)}
        columns |= self.apply(columns, rng)
        state = np.stack([columns[name] for name in layouts.state], axis=1)
        action = np.stack([columns[name] for name in layouts.action], axis=1)
        return replace(log, state=state, action=action, extra={})

    def named_in(self, keys: Iterable[str], sentences: Iterable[str]) -> bool:
        """Whether effects or sentences of an answer are this mistake."""
        matching = any(fnmatch(key, pattern) for key in keys for pattern in self.keys)
        return matching or any(re.search(self.words, text, re.IGNORECASE) for text in sentences)


def reversed_sign(column: str) -> Mistake:
    """One column with the other sign."""
    words = rf"\b{column}\b.*(wrong sign|reversed|correlate by -|other sign)"
    return Mistake(f"{column} reversed", scaled([column], -1.0), words, (f"sensor_sign:{column}",))


def in_unit(name: str, columns: tuple[str, ...], factor: float) -> Mistake:
    """Columns in another unit."""
    first = columns[0]
    keys = tuple(f"sensor_scale:{column}" for column in columns) if len(columns) == 1 else ()
    return Mistake(f"{first} … in {name}" if len(columns) > 1 else f"{first} in {name}", scaled(columns, factor),
                   rf"\b{first}\b.*( instead of|in no unit of|in {re.escape(name)} looks the same)", keys)  # fmt: skip


def _rows(log: Columns) -> int:
    return len(next(iter(log.values())))


def scaled(names: Iterable[str], factor: float) -> Apply:
    """Columns in another unit."""
    return lambda log, _: {name: factor * log[name] for name in names}


def moved(sources: Mapping[str, str]) -> Apply:
    """Columns that hold others'."""
    return lambda log, _: {name: log[source] for name, source in sources.items()}


def swapped(*names: str) -> Apply:
    """Two columns exchanged; of four, the first pair and the second."""
    pairs = zip(names[::2], names[1::2], strict=True)
    return moved({own: other for one, two in pairs for own, other in ((one, two), (two, one))})


def late(names: Iterable[str], least: int, most: int) -> Apply:
    """Columns some rows behind all others; negative rows are ahead."""

    def shift(log: Columns, rng: Rng) -> Columns:
        rows, length = int(rng.integers(least, most + 1)), _rows(log)
        places = np.clip(np.arange(length) - rows, 0, length - 1)
        return {name: log[name][places] for name in names}

    return shift


def biased(name: str, low: float, high: float) -> Apply:
    """A column with a constant added, to either side."""
    return lambda log, rng: {name: log[name] + rng.choice([-1.0, 1.0]) * rng.uniform(low, high)}


def gained(name: str, low: float, high: float) -> Apply:
    """A column times a drawn factor."""
    return lambda log, rng: {name: log[name] * rng.uniform(low, high)}


def jumping(name: str) -> Apply:
    """A place that jumps by half a metre or radian for some rows, as motion capture does when it takes another body."""

    def jump(log: Columns, rng: Rng) -> Columns:
        place = log[name].copy()
        for start in rng.integers(10, len(place) - 20, 3):
            place[start : start + int(rng.integers(3, 10))] += 0.5
        return {name: place}

    return jump


def repeating(names: Iterable[str]) -> Apply:
    """Measurements that a slow link repeats: a third of the rows holds what the row before held."""

    def hold(log: Columns, rng: Rng) -> Columns:
        stale = rng.random(_rows(log)) < 1 / 3
        stale[0] = False
        places = np.maximum.accumulate(np.where(stale, 0, np.arange(len(stale))))
        return {name: log[name][places] for name in names}

    return hold


def clipped(name: str, least: float, most: float) -> Apply:
    """A column that was written with a smaller range than was sent; the limit is drawn between two values."""

    def clip(log: Columns, rng: Rng) -> Columns:
        limit = rng.uniform(least, most)
        return {name: np.clip(log[name], -limit, limit)}

    return clip


def frozen(names: Iterable[str]) -> Apply:
    """Columns that stand still for a second or two."""

    def freeze(log: Columns, rng: Rng) -> Columns:
        rows = _rows(log)
        length = int(rng.uniform(0.1, 0.2) * rows)
        start = int(rng.integers(10, rows - length))
        places = np.arange(rows)
        places[start : start + length] = start
        return {name: log[name][places] for name in names}

    return freeze


def spiked(name: str, size: float) -> Apply:
    """Single rows far off."""

    def spike(log: Columns, rng: Rng) -> Columns:
        hit = rng.random(len(log[name])) < 0.01
        return {name: log[name] + size * hit * rng.choice([-1.0, 1.0], len(hit))}

    return spike


def in_plane(angle: Callable[[Rng], float], *pairs: tuple[str, str]) -> Apply:
    """Pairs of components along axes that are turned to the left."""

    def turn(log: Columns, rng: Rng) -> Columns:
        sine, cosine = np.sin(turned := angle(rng)), np.cos(turned)
        found = {}
        for x, y in pairs:
            found[x], found[y] = cosine * log[x] - sine * log[y], sine * log[x] + cosine * log[y]
        return found

    return turn


def angles_times(factor: float) -> Apply:
    """An attitude made of roll, pitch and yaw in another unit."""

    def change(log: Columns, _: Rng) -> Columns:
        angles = torch.as_tensor(factor * np.unwrap(rotation.to_euler(quaternion(log)).numpy(), axis=0))
        return dict(zip(QUATERNION, rotation.from_euler(*angles.unbind(-1)).numpy().T, strict=True))

    return change


def attitude_turned(angle: Callable[[Rng], float]) -> Apply:
    """An attitude whose yaw is off by an angle."""

    def turn(log: Columns, rng: Rng) -> Columns:
        half = angle(rng) / 2
        zero = torch.tensor([np.cos(half), 0.0, 0.0, np.sin(half)], dtype=torch.float64)
        return dict(zip(QUATERNION, rotation.multiply(zero, quaternion(log)).numpy().T, strict=True))

    return turn


def quaternion(log: Columns) -> torch.Tensor:
    """Attitude ``# (rows, 4)``."""
    return torch.as_tensor(np.stack([log[name] for name in QUATERNION], axis=1))


def to_body(names: Iterable[str]) -> Apply:
    """World vectors written along body axes."""
    return _rotated(names, rotation.conjugate)


def to_world(names: Iterable[str]) -> Apply:
    """Body vectors written along world axes."""
    return _rotated(names, lambda q: q)


def _rotated(names: Iterable[str], by: Callable[[torch.Tensor], torch.Tensor]) -> Apply:
    columns = tuple(names)

    def rotate(log: Columns, _: Rng) -> Columns:
        vectors = torch.as_tensor(np.stack([log[name] for name in columns], axis=1))
        return dict(zip(columns, rotation.rotate(by(quaternion(log)), vectors).numpy().T, strict=True))

    return rotate
