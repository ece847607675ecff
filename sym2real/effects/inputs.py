"""Inputs along a log for equations that use more, or others, than the log was read with."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from sym2real.dataset import Dataset
from sym2real.effects.voltage import VOLTAGE, settled, voltage_at_start, with_voltage
from sym2real.layout import Layout
from sym2real.symbolic import Equations
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import CLOCK, FORCE, THRUST_COLUMN, VOCABULARY, is_push

(TIME,) = CLOCK.columns
# Of a force that swings, in the middle of the step after a row, rad; what swings in no log has it at zero.
ANGLE = "swing_angle"
DROPOUT = 1.0  # s without rows, at most, between parts of one recording


def inputs_along(inputs: Layout, log: Trajectory) -> Array:
    """What the log holds at its rows, time from its start, zeros for the rest ``# (rows, inputs)``."""
    columns = [_column(name, log) for name in inputs]
    return np.stack(columns, axis=1) if columns else np.zeros((len(log), 0))


def with_inputs(inputs: Layout, logs: Dataset) -> Dataset:
    """The logs with these inputs, as they are where one of them is neither in a log nor known without it."""
    if logs.layouts.inputs == inputs or not all(_is_known(name, log) for log in logs for name in inputs):
        return logs
    layouts = replace(logs.layouts, inputs=inputs)
    return Dataset(replace(log, inputs=inputs_along(inputs, log), layouts=layouts) for log in logs)


def with_inputs_of(equations: Equations, logs: Dataset) -> Equations:
    """The equations with the ranges of the logs' commands, and the battery's voltage as an input where logs have it."""
    equations = _with_numbers(equations, _ranges(equations, logs))
    reference = voltage_at_start(logs)
    if reference is None or THRUST_COLUMN not in (*equations.layouts.action, *equations.quantities):
        return equations
    return _with_voltage(equations, reference)


@lru_cache(maxsize=8)
def _with_numbers(equations: Equations, numbers: tuple[tuple[str, float], ...]) -> Equations:
    return replace(equations, numbers={**equations.numbers, **dict(numbers)}) if numbers else equations


_with_voltage = lru_cache(maxsize=4)(with_voltage)  # the same equations again, of which libraries are kept


def _ranges(equations: Equations, logs: Dataset) -> tuple[tuple[str, float], ...]:
    """How far commands go in logs that a model's author named, in whatever unit, each with the name of its number.

    Effects on a command are as large as that lets expect. Without those whose range is known, and that never change.
    """
    named = [name for name in equations.layouts.action if not any(name in field.columns for _, field in VOCABULARY)]
    rows = {name: np.concatenate([log.column(name) for log in logs]) for name in named}
    spans = {f"{name}_range": float(np.ptp(values)) for name, values in rows.items()}
    return tuple((name, span) for name, span in spans.items() if span > 0.0 and name not in equations.numbers)


def has_force(log: Trajectory) -> bool:
    """Whether the log has a force along a world axis that is not zero throughout."""
    names = {*log.layouts.inputs, *log.extra} & {*FORCE.columns}
    return any(bool(np.any(log.column(name))) for name in names)


def with_common_clock(logs: Dataset) -> Dataset:
    """The logs, those that go on where another one ends with the time from where that recording began, in ``t``.

    A dropout, and whoever cuts a log in two, leaves the battery as it is.
    """
    begun: dict[int, float] = {}
    for number in sorted(range(len(logs)), key=lambda number: logs[number].time[0]):
        first = float(logs[number].time[0])
        gaps = {other: first - float(logs[other].time[-1]) for other in begun}
        before = [other for other, gap in gaps.items() if 0.0 < gap <= DROPOUT]
        begun[number] = begun[min(before, key=gaps.__getitem__)] if before else first
    return Dataset(
        log
        if begun[number] == log.time[0] or TIME in log.extra
        else replace(log, extra={**log.extra, TIME: log.time - begun[number]})
        for number, log in enumerate(logs)
    )


def _is_known(name: str, log: Trajectory) -> bool:
    return name in log.layouts.inputs or name in log.extra or name == TIME or is_push(name)


def _column(name: str, log: Trajectory) -> Array:
    held = name in log.layouts.inputs or name in log.extra
    if name == VOLTAGE and held:
        return settled(log)
    if held:
        return log.column(name)
    return log.time - log.time[0] if name == TIME else np.zeros(len(log))
