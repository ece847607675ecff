"""Which group of a model, state, action or inputs, a standard column lands in: the model's layouts decide."""

from dataclasses import replace

import numpy as np

from sym2real.layout import Layout, Layouts
from sym2real.logs import derive
from sym2real.logs.missing import require_columns
from sym2real.logs.standard import QUATERNION, Columns, Standard, side_by_side
from sym2real.logs.table import Table
from sym2real.trajectory import Array, Trajectory


def visible(layouts: Layouts) -> Layouts:
    """The layouts without hidden states, which no log holds."""
    return replace(layouts, state=Layout(tuple(field for field in layouts.state.fields if not field.hidden)))


def trajectory(table: Table, log: Standard, layouts: Layouts, name: str) -> Trajectory:
    """Standard columns sorted into the groups of ``layouts``; what is left over goes to ``extra``.

    ``t`` is the time, wrench inputs that the log has not are zero, heading follows from a quaternion.

    Raises:
        DataError: naming every column that the layouts ask for and the log has not.
    """
    columns = _with_heading(log.columns, layouts)
    require_columns(table.path, columns, log.others, layouts)
    state, action, inputs = (
        np.column_stack([np.empty((len(log.time), 0)), *(_column(table, log, columns, column) for column in layout)])
        for layout in layouts.groups.values()
    )
    extra = {name: values for name, values in (log.others | log.columns).items() if name not in layouts.columns}
    return Trajectory(log.time, state, action, inputs, layouts, extra, name=name, notes=log.notes, raw=table.columns)


def _with_heading(columns: Columns, layouts: Layouts) -> Columns:
    wanted = {"sin_yaw", "cos_yaw"} & {*layouts.state.columns, *layouts.inputs.columns}
    quaternion = side_by_side(columns, QUATERNION)
    if not wanted or "sin_yaw" in columns or quaternion is None:
        return columns
    yaw = derive.heading(quaternion)
    return {**columns, "sin_yaw": np.sin(yaw), "cos_yaw": np.cos(yaw)}


def _column(table: Table, log: Standard, columns: Columns, name: str) -> Array:
    if name in columns:
        return columns[name]
    if name in log.others:
        values = log.others[name]
        table.check_finite(name, values)
        return values
    # What is left of the columns that are required: time, and pushes that nobody applied.
    return log.time if name == "t" else np.zeros(len(log.time))
