"""What a program that opens an exported model must know beside it: its columns, and what of it acts outside a step."""

from typing import Any

from sym2real.layout import Layouts
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.expressions import text
from sym2real.vocabulary import is_push


def interface(equations: Equations) -> dict[str, Any]:
    """Columns with units in their order, time step in s, and what acts outside the step: filters, first hidden values.

    Expressions are texts over the columns; ``inputs`` that are not given count as zero.
    """
    layouts = equations.layouts
    return {
        "dt": equations.dt,
        **columns_of(layouts),
        "parameters": dict(equations.parameters),
        "filters": [
            {"effect": key, "values": {name: text(value) for name, value in values.items()}}
            for key, values in equations.filters
        ],
        "start": {column: text(value) for column, value in equations.start.items()},
        "measured": {column: text(value) for column, value in equations.output.items()},
    }


def outside_notes(equations: Equations) -> tuple[str, ...]:
    """A sentence for everything of the equations that a step of the exported model leaves to its caller."""
    filters = [key for key, _ in equations.filters]
    inputs = [name for name in equations.layouts.inputs if not is_push(name)]
    clauses = []
    if filters:
        clauses.append(
            f"{', '.join(filters)} is not in it: the memory of a filter belongs to whoever sends the commands"
        )
    if inputs:
        clauses.append(f"{', '.join(inputs)} must be given with every step: inputs that are left out count as zero")
    if equations.start:
        hidden = ", ".join(equations.start)
        clauses.append(
            f"{hidden} is a state that no sensor reports: it begins where `start` says, and goes on by steps"
        )
    if equations.output:
        clauses.append(
            f"{', '.join(equations.output)} is reported other than it is, as `measured` says; states are true"
        )
    return tuple(clauses)


def columns_of(layouts: Layouts) -> dict[str, list[dict[str, str]]]:
    """Columns with units of state, action and inputs."""
    return {
        group: [{"column": column, "unit": unit} for column, unit in layout.units.items()]
        for group, layout in layouts.groups.items()
    }
