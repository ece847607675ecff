"""Columns that are a model's own, such as those of a robot's joints: a specification names them like standard ones."""

from dataclasses import replace

from sym2real.errors import DataError, UnknownNameError
from sym2real.layout import Layouts
from sym2real.logs.parts import STANDARD_COLUMNS, Source
from sym2real.logs.specification import LogSpec
from sym2real.logs.table import Table
from sym2real.logs.units import UNITS


def for_model(spec: LogSpec, table: Table, layouts: Layouts | None) -> LogSpec:
    """The specification with the columns that the log calls as the model does.

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
    taken, there = {*spec.sources, *spec.columns}, {*table.columns, *table.texts}
    as_they_are = {name: Source(name) for name in own if name in there and name not in taken}
    return replace(spec, columns={**spec.columns, **as_they_are})


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
