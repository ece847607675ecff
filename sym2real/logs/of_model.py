"""The columns of a log that a specification need not name: they are called as standard ones are, or as the model's own,
such as those of a robot's joints.
"""

from collections.abc import Collection
from dataclasses import replace

from sym2real.errors import DataError, UnknownNameError
from sym2real.layout import Layouts
from sym2real.logs.parts import HEADINGS, STANDARD_COLUMNS, Source, TimeBase
from sym2real.logs.sources import MADE_OF
from sym2real.logs.specification import LogSpec
from sym2real.logs.standard import attitude_columns
from sym2real.logs.table import Table
from sym2real.logs.units import UNITS
from sym2real.vocabulary import RATE, VELOCITY


def for_model(spec: LogSpec, table: Table, layouts: Layouts | None) -> LogSpec:
    """The specification with the columns that the log calls as the model does, or the vocabulary.

    Args:
        spec: of the log.
        table: the log.
        layouts: of the model; None where nobody has said which.

    Raises:
        DataError: for a column that is neither a standard one nor the model's, or a unit that is not of its kind.
    """
    own = own_units(layouts)
    for name, source in spec.columns.items():
        if name not in STANDARD_COLUMNS:
            _require_own(spec, table, name, source, own)
    there = {*table.columns, *table.texts}
    if spec.time.column == TimeBase.column and TimeBase.column not in there and "time" in there:
        spec = replace(spec, time=replace(spec.time, column="time"))
    free = there.difference(spec.sources, spec.columns, *(MADE_OF.get(name, ()) for name in spec.columns))
    names = [name for name in (*own, *_standard(spec, there, layouts)) if name in free]
    return replace(spec, columns={**spec.columns, **{name: Source(name) for name in names}})


def _standard(spec: LogSpec, there: Collection[str], layouts: Layouts | None) -> list[str]:
    """Standard columns that are wanted, and that the specification does not make of others."""
    made = {name: columns for name, columns in MADE_OF.items() if not {*columns} & {*there, *spec.columns}}
    wanted = {*STANDARD_COLUMNS} if layouts is None else {*layouts.columns}
    wanted |= {name for name, columns in made.items() if {*columns} & wanted}
    if spec.attitude.sources:
        wanted -= {*attitude_columns("attitude"), *HEADINGS[0], "yaw"}
    for what, columns in ("velocity", VELOCITY.columns), ("rate", RATE.columns):
        wanted -= {*columns} if what in spec.derive else set()
    return [name for name in STANDARD_COLUMNS if name in wanted]


def own_units(layouts: Layouts | None) -> dict[str, str]:
    """Unit of every column of a model that is no standard one."""
    units = {} if layouts is None else layouts.units
    return {name: unit for name, unit in units.items() if name not in STANDARD_COLUMNS}


def _require_own(spec: LogSpec, table: Table, name: str, source: Source, own: dict[str, str]) -> None:
    wanted = own.get(name.removeprefix("ref_"))
    if wanted is None:
        actual = str(UnknownNameError("column", name, [*own, *STANDARD_COLUMNS]))
        expected = f"in [columns] of specification {spec.name!r} standard columns"
        raise DataError(table.path, f"{expected} or those of the model" if own else expected, actual)
    if source.unit and UNITS[source.unit][0] != wanted:
        known = [unit for unit, (inside, _) in UNITS.items() if inside == wanted]
        actual = str(UnknownNameError(f"unit of column {name!r}", source.unit, known))
        raise DataError(table.path, f"a unit that fits in specification {spec.name!r}", actual, column=name)
