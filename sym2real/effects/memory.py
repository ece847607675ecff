"""Effects with memory as recursions over a series of commands or measurements.

A row of commands is held for one period, and what reaches the robot in it is one number as well: the held command with
which a loop ẋ = K (u - x) behind it ends the period where it does with the one that moves. It is the mean over the
period with weights that fall by e^(-K t) into the past; of an integrator, K = 0, the plain mean. A lag or delay of zero
is then the identity, with a derivative that is not zero. K is the nominal loop's; of filters in a row each is weighted
as if it were the last.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from sym2real.effects.period_shares import kept, older_share, ramp_share
from sym2real.errors import ModelError
from sym2real.trajectory import Array

Given = Mapping[str, Tensor]
Begin = Callable[[Tensor, float, Given], Tensor]
Run = Callable[[Tensor, Tensor, float, Given], tuple[Tensor, Tensor]]
# Periods by which a delay may miss a whole number of them: in single precision 0.04 s are less than two of 0.02 s.
WHOLE = 1e-6
SOFT = 0.05  # part of a dead zone's threshold, to either side of it, within which commands act in part
NARROWEST = 1e-12  # threshold of a dead zone that is none
LONGEST_DELAY = 60.0  # s; every row that is still under way is kept, so that a delay without end fills the memory


@dataclass(frozen=True)
class Memory:
    """A recursion.

    Args:
        begin: (first row ``# (..., C)``, dt, values ``# (..., 1)``) → memory of having had that row for ever.
        run: (memory, rows ``# (..., T, C)``, dt, values ``# (..., 1)``) → memory after them, what comes out of them.
    """

    begin: Begin
    run: Run


def first_row(row: Tensor, dt: float, values: Given) -> Tensor:
    """Memory that is the row itself, in the shape it has with the values."""
    shape = np.broadcast_shapes(row.shape, *(value.shape for value in values.values()))
    return row.expand(shape)


def series(
    memory: Memory, rows: Tensor, dt: float, values: Mapping[str, Tensor | float], columns: Sequence[int]
) -> Tensor:
    """Rows ``# (..., T, columns)`` with some columns put through a recursion that starts in rest at the first row."""
    chosen = rows[..., list(columns)]
    given = as_given(values, rows)
    _, output = memory.run(memory.begin(chosen[..., 0, :], dt, given), chosen, dt, given)
    return replaced(rows, columns, output)


def as_given(values: Mapping[str, Tensor | float], like: Tensor) -> Given:
    """Values ``# (...)`` as tensors that broadcast with a row ``# (..., C)``."""
    return {
        name: torch.as_tensor(value, dtype=like.dtype, device=like.device)[..., None] for name, value in values.items()
    }


def replaced(rows: Tensor, columns: Sequence[int], output: Tensor) -> Tensor:
    """Rows with those columns exchanged, in the batch shape of both."""
    batch = np.broadcast_shapes(rows.shape[:-1], output.shape[:-1])
    result = rows.expand(*batch, rows.shape[-1]).clone()
    result[..., list(columns)] = output.expand(*batch, len(columns))
    return result


def _like(gains: Sequence[float], rows: Tensor) -> Tensor:
    """Gains of the loops behind the columns ``# (C,)``; zeros where none are given."""
    return torch.tensor(gains or [0.0], dtype=rows.dtype, device=rows.device)


def shift(gains: Sequence[float] = ()) -> Memory:
    """a(t - ``value``): whole rows by look-up, fractions of a row blended as :func:`older_share` says."""

    def depth(dt: float, values: Given) -> int:
        longest = float(values["value"].max())
        if longest > LONGEST_DELAY:
            raise ModelError(f"expected a delay of at most {LONGEST_DELAY:g} s, found {longest:g} s")
        return max(0, int(longest / dt + WHOLE)) + 1

    def begin(row: Tensor, dt: float, values: Given) -> Tensor:
        row = first_row(row, dt, values)
        return row[..., None, :].expand(*row.shape[:-1], depth(dt, values), row.shape[-1])

    def run(memory: Tensor, rows: Tensor, dt: float, values: Given) -> tuple[Tensor, Tensor]:
        before, steps = memory.shape[-2], rows.shape[-2]
        batch = np.broadcast_shapes(memory.shape[:-2], rows.shape[:-2])
        whole = torch.cat([part.expand(*batch, *part.shape[-2:]) for part in (memory, rows)], dim=-2)
        late = values["value"][..., 0] / dt  # (...)
        late = torch.where((late - late.round()).abs() < WHOLE, late.round(), late)
        full = torch.floor(late)
        position = before + torch.arange(steps, device=rows.device) - full[..., None].long()  # (..., T)
        position = position.expand(*batch, steps)
        ends = before + steps - 1
        part = older_share((late - full)[..., None, None], _like(gains, rows), dt)
        newer, older = (
            torch.gather(whole, -2, place.clamp(0, ends)[..., None].expand(*batch, steps, rows.shape[-1]))
            for place in (position, position - 1)
        )
        # No blending where there is nothing to blend: a whole shift copies rows bit by bit.
        blended = torch.where(part == 0, newer, (1 - part) * newer + part * older)
        return whole[..., steps:, :], blended

    return Memory(begin, run)


def _faded(rows: Tensor, left: Tensor) -> Tensor:
    """Every row and what is left of those before it, y' = left·y + row ``# (..., T, C)``.

    The sum over earlier rows is doubled in length at every pass.
    """
    reach = 1
    while reach < rows.shape[-2]:
        rows = torch.cat([rows[..., :reach, :], rows[..., reach:, :] + left * rows[..., :-reach, :]], dim=-2)
        reach, left = 2 * reach, left * left
    return rows


def lag(gains: Sequence[float] = ()) -> Memory:
    """First-order lag of a held command: its mean over the period, as :func:`lag_share` says.

    The distance d of the memory from the command obeys d' = left·d + a - a'.
    """

    def run(memory: Tensor, rows: Tensor, dt: float, values: Given) -> tuple[Tensor, Tensor]:
        left, mean = kept(values["value"][..., None, :], dt, _like(gains, rows))
        batch = np.broadcast_shapes(memory.shape[:-1], rows.shape[:-2], left.shape[:-2])
        rows = rows.expand(*batch, *rows.shape[-2:])
        first = (memory - rows[..., 0, :]).expand(*batch, rows.shape[-1])
        away = _faded(torch.cat([first[..., None, :], rows[..., :-1, :] - rows[..., 1:, :]], dim=-2), left)
        return rows[..., -1, :] + away[..., -1, :] * left[..., 0, :], rows + away * mean

    return Memory(first_row, run)


def _passed(rule: Callable[..., None], memory: Tensor, *rows: Tensor) -> Tensor:
    """Memory before the first row and after every one ``# (..., T + 1, C)``: a recursion that takes row by row.

    A row takes as long as its few calls, which are NumPy's: on short rows torch's take several times as long.

    Args:
        rule: puts what follows (memory, row of each of ``rows``) into its last argument.
        memory: ``# (..., C)``.
        rows: ``# (..., T, C)``.
    """
    shape = np.broadcast_shapes(memory.shape, *(part[..., 0, :].shape for part in rows))
    given = [part.movedim(-2, 0).cpu().numpy() for part in rows]
    history = np.empty((len(given[0]) + 1, *shape), given[0].dtype)
    history[0] = memory.cpu().numpy()
    for number, row in enumerate(zip(*given, strict=True)):
        rule(history[number], *row, history[number + 1])
    return torch.from_numpy(history).to(memory.device).movedim(0, -2)


def rate_limited(gains: Sequence[float] = ()) -> Memory:
    """A ramp towards a held command, then the command: its mean over the period, as :func:`ramp_share` says."""

    def run(memory: Tensor, rows: Tensor, dt: float, values: Given) -> tuple[Tensor, Tensor]:
        most = (values["value"] * dt).cpu().numpy()

        def follow(now: Array, row: Array, after: Array) -> None:
            np.minimum(np.maximum(row, now - most), now + most, out=after)

        passed = _passed(follow, memory, rows)
        before, after = passed[..., :-1, :], passed[..., 1:, :]
        part = torch.clamp((rows - before).abs() / values["value"][..., None, :] / dt, max=1.0)
        return after[..., -1, :], after - (after - before) * ramp_share(part, _like(gains, rows), dt)

    return Memory(first_row, run)


def play() -> Memory:
    """Hysteresis of a gear with play: the output moves once the command has crossed the play."""

    def follow(now: Array, low: Array, high: Array, after: Array) -> None:
        np.minimum(np.maximum(now, low), high, out=after)

    def run(memory: Tensor, rows: Tensor, dt: float, values: Given) -> tuple[Tensor, Tensor]:
        half = values["value"][..., None, :] / 2
        after = _passed(follow, memory, rows - half, rows + half)[..., 1:, :]
        return after[..., -1, :], after

    return Memory(first_row, run)


def dead_zone() -> Memory:
    """Nothing of a command well within the threshold, all of it well beyond, a part in between."""

    def run(memory: Tensor, rows: Tensor, dt: float, values: Given) -> tuple[Tensor, Tensor]:
        beyond = rows.abs() / values["value"][..., None, :].clamp_min(NARROWEST) - 1.0
        return memory, rows * (0.5 + beyond / (2 * SOFT)).clamp(0.0, 1.0)

    return Memory(first_row, run)


def sampled_lag() -> Memory:
    """First-order lag of a signal that moves in straight lines between its samples, sampled.

    Its memory is the filtered row, and the row before.
    """

    def begin(row: Tensor, dt: float, values: Given) -> Tensor:
        row = first_row(row, dt, values)
        return torch.cat([row, row], dim=-1)

    def run(memory: Tensor, rows: Tensor, dt: float, values: Given) -> tuple[Tensor, Tensor]:
        left, mean = kept(values["value"], dt, _like((), rows))
        batch = np.broadcast_shapes(memory.shape[:-1], rows.shape[:-2], left.shape[:-1])
        rows = rows.expand(*batch, *rows.shape[-2:])
        filtered, before = memory.expand(*batch, memory.shape[-1]).chunk(2, dim=-1)
        earlier = torch.cat([before[..., None, :], rows[..., :-1, :]], dim=-2)
        driven = rows - (rows - earlier) * mean[..., None, :] - earlier * left[..., None, :]
        first = driven[..., :1, :] + (left * filtered)[..., None, :]
        after = _faded(torch.cat([first, driven[..., 1:, :]], dim=-2), left[..., None, :])
        return torch.cat([after[..., -1, :], rows[..., -1, :]], dim=-1), after

    return Memory(begin, run)
