"""Rows that a log should not hold as they are: repeated ones, a component that stands, and values that jump.

A row repeats where a sensor's columns hold to the last bit what they held in the row before although the robot moves,
as a slower sensor or a lost packet writes it: the next fresh row has then moved by more than one step. A component of
a velocity or a rate stands where it holds the same bits, not those of zero, longer than a jump lasts while the others
go on, though it changes from row to row elsewhere. A value jumps where it leaves its neighbours by far more than its
changes vary, and by more than they move there: what is let go under full torque does not jump, nor does what the model
moves so from the row before, as a torque that steps moves a light arm. Of up to three such rows in a row the values are
interpolated; longer runs cut the log, and nothing is made up inside.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.ndimage import binary_opening, median_filter

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.start import ROWS
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.along_logs import from_row_to_row
from sym2real.field import Field
from sym2real.logs.noise import MAD_TO_SIGMA
from sym2real.logs.sources import AsRead
from sym2real.logs.standing import Rows, stretches
from sym2real.symbolic import Equations
from sym2real.trajectory import Array, Trajectory

Jumps = list[NDArray[np.int64]]  # rows of each log to which a value jumps


@dataclass(frozen=True, eq=False)
class BadRows:
    """Rows whose values of some columns are not those of their time.

    Args:
        kind: "repeat", "stand" or "jump".
        columns: of the state.
        rows: of each log ``# (rows,)``.
        cuts: places before which a log is cut, in each log.
    """

    kind: str
    columns: tuple[str, ...]
    rows: tuple[Rows, ...]
    cuts: tuple[tuple[int, ...], ...]

    @property
    def evidence(self) -> str:
        """How many and in which columns, one clause."""
        count = f"{sum(int(rows.sum()) for rows in self.rows)} of {sum(map(len, self.rows))}"
        names = " ".join(self.columns)
        if self.kind == "repeat":
            return f"rows that repeat in {names}: {count} hold what the row before held while the robot moves"
        if self.kind == "stand":
            return f"{names} stands: {count} rows hold the same bits while what is measured with it goes on"
        places, off = sum(map(len, self.cuts)), any(rows.any() for rows in self.rows)
        clauses = [f"{count} rows are off by far more than any step"] if off else []
        where = "place" if places == 1 else "places"
        clauses += [f"at {places} {where} it stays elsewhere, further off than any step"] if places else []
        return f"{names} jumps: {', and '.join(clauses)}"

    def fix(self, _: AsRead) -> str:
        """What to change."""
        if self.kind == "repeat":
            return "log a sensor when it has measured, and leave its cells empty in between; such rows are interpolated"
        if self.kind == "stand":
            return "look at what reads that component and writes it; the log is cut where it stands"
        return "look at the motion capture's bodies or the sensor's link; such rows are interpolated, or the log is cut"

    def undone(self, data: Dataset) -> Dataset:
        """The logs with short runs interpolated and cut at long ones."""
        parts = zip(data, self.rows, self.cuts, strict=True)
        return Dataset(piece for log, rows, cuts in parts for piece in _mended(log, self.columns, rows, cuts))


def bad_rows(data: Dataset, model: Equations | None = None) -> list[BadRows]:
    """What repeats, then what stands, then what jumps of the robot's body, each in the logs without those before it.

    Args:
        data: logs.
        model: tells a jump from motion, if it has the columns of the logs.
    """
    damages = list[BadRows]()
    while bad := _all_that_repeats(data) or _standing(data):
        if not len(whole := bad.undone(data)):  # nothing else is left to judge
            break
        damages.append(bad)
        data = whole
    return [*damages, *_jumps(data, model, of_body=True)]


def joints_that_jump(data: Dataset, model: Equations | None = None) -> list[BadRows]:
    """Each joint's own sensor. A torque that steps moves a light joint so, if it is the right one in the right unit."""
    return _jumps(data, model, of_body=False)


def _sensors(fields: Iterable[Field]) -> Iterator[tuple[str, ...]]:
    """Columns that one sensor measures: a vector's all, of joints each its own."""
    for field in fields:
        yield from [field.columns] if field.frame else [(column,) for column in field.columns]


def _jumps(data: Dataset, model: Equations | None, *, of_body: bool) -> list[BadRows]:
    damages, vectors = list[BadRows](), (field for field in data.layouts.state.fields if field.kind == "vector")
    for columns in _sensors(field for field in vectors if bool(field.frame) == of_body):
        if (jumping := _jumping(data, columns, model)) is not None:
            damages.append(jumping)
            data = jumping.undone(data)
    return damages


def _all_that_repeats(data: Dataset) -> BadRows | None:
    """The sensors that repeat in the same rows as the first that does: one link holds several."""
    repeats = [bad for columns in _sensors(data.layouts.state.fields) if (bad := _repeated(data, columns)) is not None]
    if not repeats:
        return None
    alike = [bad for bad in repeats if all(map(np.array_equal, bad.rows, repeats[0].rows))]
    return replace(repeats[0], columns=tuple(name for bad in alike for name in bad.columns))


def _repeated(data: Dataset, columns: Sequence[str]) -> BadRows | None:
    places, rows, caught_up = data.layouts.state.indices(columns), [], []
    for log in data:
        change = np.linalg.norm(np.diff(log.state[:, places], axis=0), axis=1)
        stale = np.concatenate([[False], change == 0.0])
        rows.append(stale)
        fresh = ~stale[1:] & ~stale[:-1]
        behind = ~stale[1:] & stale[:-1]
        step = float(np.median(change[fresh])) if fresh.any() else 0.0
        if not fresh.any() and not (stale[1:] & stale[:-1]).any() and behind.any():  # every second row
            step = float(np.median(change[behind])) / 2
        caught_up += [*(change[behind] / step)] if step > 0 else []
    few = sum(int(part.sum()) for part in rows) < SETTINGS.negligible * data.rows
    if few or not caught_up or float(np.median(caught_up)) < SETTINGS.gap:
        return None
    return BadRows("repeat", tuple(columns), tuple(rows), tuple(() for _ in data))


def _standing(data: Dataset) -> BadRows | None:
    """The first component of a measured velocity or rate that stands, but for at zero: there may be no motion."""
    for field in (field for field in data.layouts.state.fields if field.frame and field.unit.endswith("/s")):
        values = [log.state[:, data.layouts.state.indices(field.columns)] for log in data]
        still = [np.diff(part, axis=0) == 0.0 for part in values]
        for place, column in enumerate(field.columns):
            others = [np.delete(part, place, axis=1).all(axis=1) for part in still]
            moving = [part[1:, place] != 0.0 for part in values]
            parts = zip(still, others, moving, strict=True)
            # Longer than a value that jumped is away.
            run = np.ones(SETTINGS.jump_rows + 1, dtype=bool)
            rows = [binary_opening(part[:, place] & ~rest & somewhere, run) for part, rest, somewhere in parts]
            elsewhere = np.concatenate([part[~own, place] for part, own in zip(still, rows, strict=True)])
            if any(own.any() for own in rows) and len(elsewhere) and elsewhere.mean() < 1.0 - SETTINGS.nearly:
                bad = tuple(np.concatenate([[False], own]) for own in rows)
                return BadRows("stand", (column,), bad, tuple(() for _ in data))
    return None


def _jumping(data: Dataset, columns: tuple[str, ...], model: Equations | None) -> BadRows | None:
    layout = data.layouts.state
    places = layout.indices(columns)
    changes = [np.diff(log.state[:, places], axis=0) for log in data]
    usual = [median_filter(change, (5, 1), mode="nearest") for change in changes]
    sizes = [np.linalg.norm(change - around, axis=1) for change, around in zip(changes, usual, strict=True)]
    every = np.concatenate(sizes)
    unheard_of = SETTINGS.unheard_of * MAD_TO_SIGMA * float(np.median(every))
    beyond = SETTINGS.jump_beyond * float(np.percentile(every, 95))
    stays = columns[0] in layout.rates or layout.units[columns[0]] == "m"
    least = max(unheard_of, beyond, SETTINGS.jump_metres * stays)
    moving = [np.linalg.norm(around, axis=1) for around in usual]
    jumps = [np.flatnonzero(size > np.maximum(least, move)) + 1 for size, move in zip(sizes, moving, strict=True)]
    jumps = _unpredicted(model, data, columns, jumps)
    excursions = [_excursions(change, there, stays=stays) for change, there in zip(changes, jumps, strict=True)]
    if least <= 0.0 or not any(rows.any() or cuts for rows, cuts in excursions):
        return None
    rows, cuts = zip(*excursions, strict=True)
    return BadRows("jump", columns, rows, cuts)


def _unpredicted(model: Equations | None, data: Dataset, columns: tuple[str, ...], jumps: Jumps) -> Jumps:
    """Rows of each log to which values jump and back, without those where a model's step from before is most of it."""
    stepping = from_row_to_row(model, data) if model is not None and any(map(len, jumps)) else None
    if stepping is None:
        return jumps
    (predict, known), places, left = stepping, data.layouts.state.indices(columns), []
    for log, there in zip(known, jumps, strict=True):
        before = (torch.as_tensor(part[there - 1]) for part in (log.state, log.action, log.step_inputs))
        missed = log.state[there][:, places] - predict(*before).numpy()[:, places]
        whole = log.state[there][:, places] - log.state[there - 1][:, places]
        part = np.linalg.norm(missed, axis=1) / np.linalg.norm(whole, axis=1)
        # A model that starts from a value which has jumped from nowhere tells nothing of the way back.
        back = [there - row for row in there[part >= SETTINGS.nearly]]
        kept = np.any([part >= SETTINGS.mostly, *((rows > 0) & (rows <= SETTINGS.spike_rows) for rows in back)], axis=0)
        left.append(there[kept])
    return left


def _excursions(change: Array, jumps: NDArray[np.int64], *, stays: bool) -> tuple[Rows, tuple[int, ...]]:
    """Rows between a jump and the one back, and the rows before which a value jumps for good, where it may.

    A rate may jump: an impact, a new estimate. Where only its spikes are bad, they last a row or two.
    """
    rows, cuts, place = np.zeros(len(change) + 1, dtype=bool), list[int](), 0
    latest = SETTINGS.jump_rows if stays else SETTINGS.spike_rows
    while place < len(jumps):
        first = int(jumps[place])
        soon = [offset for offset in range(place, len(jumps)) if jumps[offset] - first <= latest]
        # How far it is away after each jump: what overshoots as it settles elsewhere does not come back.
        away = np.linalg.norm(np.cumsum(change[jumps[soon] - 1], axis=0), axis=1)
        back = next((offset for offset, left in zip(soon, away, strict=True) if left < SETTINGS.mostly * away[0]), None)
        if back is None:
            # Those that follow at once are the same motion: none of them starts from where the value was.
            alone = np.flatnonzero(np.diff(jumps[place:]) > 1)
            back = place + int(alone[0]) if len(alone) else len(jumps) - 1
            cuts += map(int, jumps[place : back + 1]) if stays else []
        else:
            rows[first : int(jumps[back])] = True
        place = back + 1
    return rows, tuple(cuts)


def _mended(log: Trajectory, columns: Sequence[str], rows: Rows, cuts: Sequence[int]) -> list[Trajectory]:
    long = [(a, b) for a, b in stretches(rows) if b - a > SETTINGS.bridged_rows or a == 0 or b == len(rows)]
    good = np.flatnonzero(~rows)
    if not len(good):
        return []
    state, layout = log.state.copy(), log.layouts.state
    for place in layout.indices(columns):
        state[:, place] = np.interp(log.time, log.time[good], state[good, place])
    whole = replace(log, state=layout.normalise(torch.as_tensor(state)).numpy())
    ends = sorted([*long, *((cut, cut) for cut in cuts)])
    starts, stops = [0, *(b for _, b in ends)], [*(a for a, _ in ends), len(log)]
    pieces = [(a, b) for a, b in zip(starts, stops, strict=True) if b - a > ROWS]
    if len(pieces) == 1 and pieces[0] == (0, len(log)):
        return [whole]
    return [replace(whole.rows(a, b), name=f"{log.name}#{number + 1}") for number, (a, b) in enumerate(pieces)]
