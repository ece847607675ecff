"""Evidence on stamps: their unit, the step, jitter, gaps, first intervals that are not like the others."""

import numpy as np

from sym2real.logs.draft import Draft
from sym2real.logs.evidence import Rows
from sym2real.logs.name_words import words_and_unit
from sym2real.logs.parts import TimeBase
from sym2real.logs.resample import GAP_INTERVALS, SAME_CLOCK, gaps, is_regular, usual_step
from sym2real.logs.specification import LogSpec
from sym2real.logs.standard import stamps, unbroken
from sym2real.logs.table import Table
from sym2real.logs.units import UNITS
from sym2real.trajectory import Array

# Logs of robots have between 2 and 2000 rows a second, most about 50.
SHORTEST_STEP, USUAL_STEP, LONGEST_STEP = 5e-4, 2e-2, 0.5
FIRST_ROWS = 5
THIS_CENTURY = 1e9  # s since 1970, of 2001; ms, us and ns are more
MOSTLY = 0.8
UNLIKE = (0.6, 1.6)  # × the median: an interval outside is not like the others


def inspect_time(draft: Draft) -> None:
    """Find the time base and the rows to drop; sets ``rows``, and shortens ``tables``."""
    column = _column(draft.tables, draft.assignment.times or _ticking(draft))
    draft.rows = Rows(_without_stamps(draft) if column is None else _with_stamps(draft, column))


def _with_stamps(draft: Draft, column: str) -> list[Array]:
    counts = [stamps(table, LogSpec(time=TimeBase(column))) for table in draft.tables]
    step = usual_step(map(np.diff, counts))
    unit, evidence = _unit(draft, column, step)
    times = [values * UNITS[unit][1] for values in counts]
    # Of most logs: one of them may have lost a row there.
    first = draft.drop_first = int(np.median([*map(_first_rows, times)]))
    if first:
        intervals = ", ".join(f"{1e3 * np.diff(time[: first + 1]).max():.4g}" for time in times)
        usual = 1e3 * np.median(np.diff(times[0]))
        remark = f"the first interval is {intervals} ms where the others are {usual:.4g} ms"
        draft.add("", f"drop the first {first} row(s)", "", remark, "certain")
        draft.comment("drop_first", remark)
    draft.tables = [table[first:] for table in draft.tables]
    times = [time[first:] for time in times]
    draft.time = TimeBase(column, unit, dt=nice_period(draft.kept * step * UNITS[unit][1]))  # type: ignore[arg-type]
    draft.add(column, "time", unit, evidence, "guess" if "counter" in evidence else "certain")
    _jitter(draft, times, nice_period(step * UNITS[unit][1]))
    return times


def nice_period(step: float) -> float:
    """The period of a whole number of rows a second where that is the same clock; else four digits."""
    rate = 1.0 / step
    if rate >= 1.0 and abs(rate - round(rate)) < SAME_CLOCK * rate:
        return 1.0 / round(rate)
    return float(f"{step:.4g}")


def _column(tables: list[Table], candidates: list[str]) -> str | None:
    for name in candidates:
        known = [table.columns[name] for table in tables if name in table.columns]
        if all(len(values) > 1 and (np.diff(unbroken(values)) > 0).all() for values in known):
            return name
    return candidates[0] if candidates else None


def _ticking(draft: Draft) -> list[str]:
    """Columns that go up as a clock does, by about as much from row to row.

    Their names state a unit of time; or say nothing, and they count from 1970.
    """

    def ticks(values: Array) -> bool:
        intervals = np.diff(unbroken(values))
        usual = float(np.median(intervals)) if len(intervals) else 0.0
        return usual > 0.0 and bool(intervals.min() > 0.0 and np.mean(np.abs(intervals / usual - 1.0) < 0.5) > MOSTLY)

    def of_time(name: str) -> bool:  # an "s" behind a line may be a way
        unit = words_and_unit(name)[1]
        return bool(unit) and UNITS[unit][0] == "s" and not name.lower().endswith("_s")

    def since_1970(name: str) -> bool:
        return name not in draft.assignment.named and draft.tables[0].columns[name][0] > THIS_CENTURY

    asked = (name for name in draft.tables[0].columns if of_time(name) or since_1970(name))
    return [name for name in asked if all(name in own.columns and ticks(own.columns[name]) for own in draft.tables)]


def _unit(draft: Draft, column: str, step: float) -> tuple[str, str]:
    if named := draft.assignment.unit(column):
        return named, f"the name says so; {step:g} {named} between rows"
    units = [name for name in ("s", "ms", "us", "ns") if SHORTEST_STEP <= step * UNITS[name][1] <= LONGEST_STEP]
    if not units:
        return "s", f"{step:g} between rows: no unit makes this a usual step; it may be a counter"
    unit = min(units, key=lambda name: abs(np.log(step * UNITS[name][1] / USUAL_STEP)))
    others = f" ({', '.join(name for name in units if name != unit)} would do too)" if len(units) > 1 else ""
    counter = "; steps of 1 may also be a counter of rows" if step == 1.0 else ""
    return unit, f"{step:g} between rows is {1e3 * step * UNITS[unit][1]:g} ms in {unit}{others}{counter}"


def _first_rows(time: Array) -> int:
    if len(time) < 4 * FIRST_ROWS:
        return 0
    intervals = np.diff(time)
    share = intervals[:FIRST_ROWS] / np.median(intervals)
    unlike = np.flatnonzero((share < UNLIKE[0]) | (share > UNLIKE[1]))
    # Only intervals from the very start on: a later one is jitter or a gap.
    return int(unlike[-1]) + 1 if len(unlike) and unlike[0] == 0 and len(unlike) == unlike[-1] + 1 else 0


def _jitter(draft: Draft, times: list[Array], period: float) -> None:
    intervals = 1e3 * np.concatenate([np.diff(time) for time in times])
    low, high = np.percentile(intervals, [5, 95])
    spread = "regular"
    if not all(is_regular(time, period) for time in times):
        ends = f"90 % within {low:.4g} to {high:.4g} ms, all within {intervals.min():.4g} to {intervals.max():.4g}"
        spread = f"jittered ({ends}): rows will be resampled"
    draft.add("", "time step", "s", f"{1e3 * period:g} ms, {spread}", "certain")
    for table, time in zip(draft.tables, times, strict=True):
        for row in gaps(time, period)[:3]:
            evidence = f"{time[row] - time[row - 1]:.4g} s before row {table.lines[row]} of {table.path.name}"
            draft.add("", f"gap (more than {GAP_INTERVALS} steps)", "", evidence, "certain")


def _without_stamps(draft: Draft) -> list[Array]:
    """Stamps of 100 rows a second for the evidence; the specification is not read until somebody says the true rate."""
    draft.time = TimeBase("", "s", rate=0.0)
    draft.add("", "time", "?", "no column of stamps: time.rate is yours to say; 100 rows a second here", "unknown")
    draft.comment("time", "The log has no stamps: put the true number of rows a second here.")
    return [np.arange(len(table)) / 100.0 for table in draft.tables]
