"""Commands of all rows of a log whose positions are slower: what was sent in equal parts of each row that is kept."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from sym2real.logs.derive import mean_in_force
from sym2real.logs.dropouts import is_slow, last_number
from sym2real.logs.parts import Attitude
from sym2real.logs.resample import TURNED
from sym2real.logs.specification import LogSpec
from sym2real.logs.standard import Standard, standardise, tidy
from sym2real.logs.table import Table
from sym2real.trajectory import Trajectory


def sent_in_all_rows(
    table: Table, spec: LogSpec, places: Collection[str], actions: Collection[str], start: float | None
) -> Standard | None:
    """The commands of a table in standard columns, row after row; None where its positions are as fast as they are.

    Args:
        table: as read, with empty cells where no position is new.
        spec: of its columns.
        places: its columns of positions.
        actions: standard columns of commands.
        start: as of :func:`~sym2real.logs.standard.tidy`; None where stamps stay as they are.
    """
    if not any(name in table.columns and is_slow(table.columns[name]) for name in places):
        return None
    columns = {name: source for name, source in spec.columns.items() if name in actions}
    held = {
        source.column: last_number(table.columns[source.column])
        for source in columns.values()
        if source.column in spec.hold and source.column in table.columns
    }
    none = Attitude()
    own = replace(
        spec, columns=columns, attitude=none, attitude_command=none, reference_attitude=none, velocity_frame="world"
    )
    filled = table.with_columns(held)
    if any(np.isnan(filled.columns[name]).any() for name in own.sources if name in filled.columns):
        return None
    standard = standardise(filled, own)
    return standard if start is None else tidy(standard, start)


def with_commands_between(log: Trajectory, sent: Standard, parts: int) -> Trajectory:
    """A log with the mean of what was sent from every row to the next, but of angles, and with what was in force in the
    middle of each of so many parts of it, where all of its commands are there.
    """
    if len(log) < 2:
        return log
    ends, there = np.append(log.time[1:], log.time[-1] + log.dt), sent.columns.keys() & {*log.layouts.action}
    means = {name: mean_in_force(sent.time, sent.columns[name], log.time, ends) for name in there if name not in TURNED}
    log = log.with_columns(means)
    if parts < 2 or len(there) < len(log.layouts.action):
        return log
    middles = log.time[:, None] + log.dt * (np.arange(parts) + 0.5) / parts
    in_force = np.maximum(np.searchsorted(sent.time, middles, side="right") - 1, 0)
    between = np.stack([sent.columns[name][in_force] for name in log.layouts.action], axis=-1)
    return replace(log, between=between)
