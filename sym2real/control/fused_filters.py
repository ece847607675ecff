"""Command filters as C: what of a planned action reaches the robot, step by step along each sample's horizon.

The recursions are those of :mod:`sym2real.effects.memory`; their values are constants of the text. What was sent
before lies in ``p->memory``, filter after filter; before anything was sent, a sample's own first action counts as
having been held for ever.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from sym2real.effects.actuators import DEAD_BAND, DEAD_ZONE, DELAY, LAG, RATE_LIMIT
from sym2real.effects.body import AT_ONCE
from sym2real.effects.bound import Effect
from sym2real.effects.commands import LIMIT
from sym2real.effects.filters import FilterState
from sym2real.effects.memory import NARROWEST, SOFT, WHOLE
from sym2real.effects.period_shares import SMALL, lag_share, older_share
from sym2real.errors import ModelError
from sym2real.trajectory import Array

# Of the memory that a column has, and the names of what goes in and comes out: statements of one step.
Rule = Callable[[str, str, str], list[str]]


@dataclass(frozen=True)
class Stage:
    """One filter.

    Args:
        columns: positions of the actions that go through it.
        rows: how many earlier rows it remembers.
        rules: of a step of each, on one remembered row; none for the ring of a delay.
        older: of a delay, each one's share of the older of two rows.
    """

    columns: tuple[int, ...]
    rows: int = 1
    rules: tuple[Rule, ...] = ()
    older: tuple[float, ...] = ()

    @property
    def size(self) -> int:
        """Numbers in its memory."""
        return self.rows * len(self.columns)


class FilterLines:
    """Text of the filters of a controller.

    Args:
        filters: None for none.
        actions: columns.
        dt: control period in s.

    Raises:
        ModelError: for a filter that is not known here.
    """

    def __init__(self, filters: FilterState | None, actions: Sequence[str], dt: float) -> None:
        self.actions = tuple(actions)
        self.stages = [] if filters is None else [_stage(effect, values, dt) for effect, values in filters.filters]

    @property
    def size(self) -> int:
        """Numbers in the memory of all filters."""
        return sum(stage.size for stage in self.stages)

    def before(self) -> list[str]:
        """Declarations ahead of the horizon: memories."""
        lines, offset = [], 0
        for i, stage in enumerate(self.stages):
            lines.append(f"v memory_{i}[{stage.size + len(stage.older)}];")
            lines.append(f"for (int i = 0; i < {stage.size}; i++)")
            lines.append(f"    memory_{i}[i] = splat(p->begun ? p->memory[{offset} + i] : R(0.0));")
            offset += stage.size
        return lines

    def lines(self) -> list[str]:
        """Planned actions ``planned_<a>`` → acting ones ``x_<a>``."""
        names = [f"planned_{action}" for action in self.actions]
        lines = list[str]()
        for i, stage in enumerate(self.stages):
            for place, column in enumerate(stage.columns):
                row, out, memory = names[column], f"filtered_{i}_{column}", f"memory_{i}[{place}]"
                if stage.rules:
                    body = [f"if (h == 0 && !p->begun) {memory} = {row};", *stage.rules[place](memory, row, out)]
                else:
                    body = _delayed(i, stage, place, row, out)
                lines += [f"v {out};", "{", *(f"    {line}" for line in body), "}"]
                names[column] = out
        return [*lines, *(f"const v x_{action} = {name};" for action, name in zip(self.actions, names, strict=True))]


def memory_of(filters: FilterState) -> Array:
    """What filters remember ``# (size,)``, in the order of the text, once something was sent."""
    return np.concatenate([memory.double().cpu().numpy().reshape(-1) for memory in filters.memories])


def _stage(effect: Effect, values: Mapping[str, Tensor | float], dt: float) -> Stage:
    name, columns, given = effect.of.name, tuple(effect.filtered_columns), {k: float(v) for k, v in values.items()}
    gains = effect.body.loop_gains
    if name == DELAY.name:
        whole, part = _periods(given["value"], dt)
        return Stage(columns, whole + 1, older=tuple(_as_number(older_share, part, gain, dt) for gain in gains))
    if name == LAG.name:
        return Stage(columns, rules=tuple(_lag(given["value"], gain, dt) for gain in gains))
    if name == DEAD_BAND.name:
        rule = _play(given["value"])
    elif name == DEAD_ZONE.name:
        rule = _rest(given["value"])
    elif name == LIMIT.name:
        rule = _limit(max(given["lower"], -given["magnitude"]), min(given["upper"], given["magnitude"]))
    elif name == RATE_LIMIT.name:
        return Stage(columns, rules=tuple(_rate(given["value"], gain, dt) for gain in gains))
    else:
        raise ModelError(f"{name} has no fused form")
    return Stage(columns, rules=(rule,) * len(columns))


def _as_number(share: Callable[[Tensor, Tensor, float], Tensor], value: float, gain: float, dt: float) -> float:
    return float(share(torch.tensor(value, dtype=torch.float64), torch.tensor(gain, dtype=torch.float64), dt))


def _periods(value: float, dt: float) -> tuple[int, float]:
    """Whole periods of a delay and the part of one that is left."""
    late = value / dt
    late = float(round(late)) if abs(late - round(late)) < WHOLE else late
    return math.floor(late), late - math.floor(late)


def _delayed(number: int, stage: Stage, place: int, row: str, out: str) -> list[str]:
    """A ring of the last rows; the two around the delay are blended."""
    ring, width, part = stage.rows + 1, len(stage.columns), stage.older[place]

    def at(step: str) -> str:
        return f"memory_{number}[({step}) % {ring} * {width} + {place}]"

    return [
        "if (h == 0 && !p->begun)",
        f"    for (int i = 0; i < {stage.rows}; i++) memory_{number}[i * {width} + {place}] = {row};",
        f"{at(f'h + {stage.rows}')} = {row};",
        f"{out} = {at('h + 1')} * R({1.0 - part!r}) + {at('h')} * R({part!r});",
    ]


def _lag(value: float, gain: float, dt: float) -> Rule:
    left, mean = math.exp(-dt / value) if value > 0.0 else 0.0, _as_number(lag_share, value, gain, dt)
    return lambda memory, row, out: [
        f"const v away = {memory} - {row};",
        f"{out} = away * R({mean!r}) + {row};",
        f"{memory} = away * R({left!r}) + {row};",
    ]


def _rate(value: float, gain: float, dt: float) -> Rule:
    most, part = f"splat(R({value * dt!r}))", f"minimum(absolute(away) * R({1.0 / (value * dt)!r}), splat(R(1.0)))"
    return lambda memory, row, out: [
        f"const v away = {row} - {memory};",
        f"const v after = {memory} + maximum(minimum(away, {most}), -{most});",
        f"const v part = {part};",
        f"{out} = after - (after - {memory}) * ({_ramp_share(gain, dt)});",
        f"{memory} = after;",
    ]


def _ramp_share(gain: float, dt: float) -> str:
    """``period_shares.ramp_share`` of ``part``; one that is next to none moves nothing, whatever its share."""
    x = gain * dt
    if gain >= AT_ONCE:
        return "part * R(0.0)"
    if x < SMALL:
        return "part * R(0.5)"
    moved = f"maximum(part, splat(R(1e-6))) * R({x!r})"
    begun = f"exponential(part * R({x!r}) - splat(R({x!r}))) * (splat(R(1.0)) - exponential(-({moved}))) / ({moved})"
    return f"({begun} - splat(R({math.exp(-x)!r}))) * R({-1.0 / math.expm1(-x)!r})"


def _play(value: float) -> Rule:
    half = f"R({0.5 * value!r})"
    return lambda memory, row, out: [
        f"{memory} = maximum(minimum({memory}, {row} + {half}), {row} - {half});",
        f"{out} = {memory};",
    ]


def _rest(value: float) -> Rule:
    low, slope = f"R({0.5 - 0.5 / SOFT!r})", f"R({0.5 / (SOFT * max(value, NARROWEST))!r})"
    return lambda memory, row, out: [
        f"const v part = absolute({row}) * {slope} + {low};",
        f"{out} = {row} * maximum(minimum(part, splat(R(1.0))), splat(R(0.0)));",
    ]


def _limit(lower: float, upper: float) -> Rule:
    low, high = f"splat(R({lower!r}))", f"splat(R({upper!r}))"
    return lambda memory, row, out: [f"{out} = maximum(minimum({row}, {high}), {low});"]
