"""What a program that opens an exported model must know beside it: its columns, and what of it acts outside a step."""

import json
from typing import Any

from sym2real.layout import Layouts
from sym2real.symbolic.equations import Equations
from sym2real.vocabulary import is_push


def interface(equations: Equations) -> dict[str, Any]:
    """Columns with units in their order, time step in s, and what acts outside the step: filters, first hidden values.

    Expressions are texts over the columns; ``inputs`` that are not given count as zero.
    """
    written = json.loads(equations.to_json())
    same = {name: written[name] for name in ("parameters", "filters", "start")}
    return {"dt": equations.dt, **columns_of(equations.layouts), **same, "measured": written["output"]}


def outside_notes(equations: Equations) -> tuple[str, ...]:
    """A sentence for everything of the equations that a step of the exported model leaves to its caller."""
    filters = [key for key, _ in equations.filters]
    inputs = [name for name in equations.layouts.inputs if not is_push(name)]
    clauses = {
        "is not in it: the memory of a filter belongs to whoever sends the commands": filters,
        "must be given with every step: inputs that are left out count as zero": inputs,
        "is a state that no sensor reports: it begins where `start` says, and goes on by steps": equations.start,
        "is reported other than it is, as `measured` says; states are true": equations.output,
    }
    return tuple(f"{', '.join(names)} {clause}" for clause, names in clauses.items() if names)


def columns_of(layouts: Layouts) -> dict[str, list[dict[str, str]]]:
    """Columns with units of state, action and inputs."""
    return {
        group: [{"column": column, "unit": unit} for column, unit in layout.units.items()]
        for group, layout in layouts.groups.items()
    }
