"""Programs → Python source of one ``torch.nn.Module`` that needs torch and nothing else.

Columns are laid out one after the other (features first), so that every operation runs over contiguous memory.
What depends on parameters alone is computed once, in ``hoist``, before the horizon loop.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence

from sympy import Expr

from sym2real.layout import Layout
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.graph import UNIT, Graph, Lowered
from sym2real.symbolic.program import Program
from sym2real.symbolic.schedule import make_program
from sym2real.symbolic.template import FUNCTION, MODEL
from sym2real.symbolic.torch_source import TorchLines

WRENCH = ("fx", "fy", "fz", "tx", "ty", "tz")
TIME = "t"
SMALLEST_NORM_SQUARED = 1e-24
Groups = Mapping[str, Sequence[str]]


def step_program(equations: Equations, pushed: bool = True) -> Program:
    """Next state on the manifold over state, action, inputs and parameters; without wrench unless ``pushed``."""
    layouts = equations.layouts
    names = (*layouts.state, *layouts.action, *layouts.inputs, *equations.parameters)
    zero = {} if pushed else dict.fromkeys(WRENCH, 0.0)
    graph = Graph(names, equations.quantities, fixed=equations.parameters, numbers=zero)
    columns = {column: graph.lower(equations.next[column]) for column in layouts.state}
    return make_program(graph, _on_manifold(graph, layouts.state, columns))


def function_program(expressions: Sequence[Expr], names: Sequence[str]) -> Program:
    """Values of the expressions over the names."""
    graph = Graph(names)
    return make_program(graph, [graph.whole(graph.lower(expression)) for expression in expressions])


def _on_manifold(graph: Graph, layout: Layout, columns: Mapping[str, Lowered]) -> list[int]:
    """Layout.normalise as nodes: q / max(‖q‖, 1e-12)."""
    nodes = list[int]()
    for field in layout.fields:
        parts = [columns[column] for column in field.columns]
        if field.kind != "vector":
            square = graph.sum(graph.product([part, part]) for part in parts)
            floor = graph.function("maximum", max, square, (SMALLEST_NORM_SQUARED, UNIT))
            length = graph.function("sqrt", math.sqrt, floor)
            parts = [graph.divide(part, length) for part in parts]
        nodes += map(graph.whole, parts)
    return nodes


def step_lines(
    program: Program, groups: Groups, parameters: Sequence[str], expand_results: bool
) -> tuple[list[str], list[str]]:
    """Bodies of ``hoist(values, like)`` → List[Tensor] and of ``step(<groups>, fixed)`` → List[Tensor].

    Args:
        program: its inputs are the columns of the groups in order, then the parameters.
        groups: argument name → columns; the first has the shape of the results.
        parameters: columns of ``values``.
        expand_results: give every result the shape of the first group's columns.
    """
    variables = [f"{group}_{column}" for group, columns in groups.items() for column in columns]
    moving = program.reached_by({column for columns in groups.values() for column in columns})
    fixed = {value for value in range(len(program.inputs)) if value not in moving}
    fixed |= {value for value in program.computed if value not in moving}
    lines = TorchLines(program, [*variables, *(f"p_{name}" for name in parameters)], "like", fixed)
    computed = [value for value in program.computed if value in moving and value not in lines.absorbed]
    read = set(program.outputs).union(*map(lines.reads, computed))
    handed = sorted(read & fixed)
    first = len(variables)
    hoist = [f"p_{name} = values[{i}]" for i, name in enumerate(parameters)]
    hoist += lines.lines([value for value in program.computed if value in fixed])
    hoist.append(f"return [{', '.join(map(lines.name, handed))}]" if handed else "return values[:0]")
    step = [f"like = {next(iter(groups))}[0]"]
    places = [(group, i) for group, columns in groups.items() for i in range(len(columns))]
    step += [f"{lines.name(v)} = {places[v][0]}[{places[v][1]}]" for v in range(first) if v in read]
    step += [f"{lines.name(value)} = fixed[{i}]" for i, value in enumerate(handed)]
    step += lines.lines(computed)
    full = program.reached_by(set(next(iter(groups.values()))))
    expand = ".expand_as(like)" if expand_results else ""
    results = [lines.name(v) if v in full else lines.tensor(v) + expand for v in program.outputs]
    return hoist, [*step, f"return [{', '.join(results)}]"]


def _method(signature: str, body: Sequence[str]) -> str:
    return textwrap.indent("\n".join([f"def {signature} -> List[Tensor]:", *(f"    {line}" for line in body)]), "    ")


def _pair(program: Program, groups: Groups, parameters: Sequence[str], suffix: str = "") -> list[str]:
    hoist, step = step_lines(program, groups, parameters, expand_results="state" in groups)
    arguments = ", ".join(f"{group}: List[Tensor]" for group in groups)
    return [
        _method(f"hoist{suffix}(self, values: List[Tensor], like: Tensor)", hoist),
        _method(f"step{suffix}(self, {arguments}, fixed: List[Tensor])", step),
    ]


def model_source(equations: Equations) -> str:
    """Source of the class ``Dynamics``: ``forward`` and ``rollout`` of the equations."""
    layouts, parameters = equations.layouts, tuple(equations.parameters)
    groups = {"state": layouts.state.columns, "action": layouts.action.columns, "inputs": layouts.inputs.columns}
    methods = _pair(step_program(equations, pushed=False), groups, parameters)
    pushed = any(column in layouts.inputs for column in WRENCH)
    if pushed:
        methods += _pair(step_program(equations), groups, parameters, "_pushed")
    measured = [c for c in layouts.inputs if c not in (*WRENCH, TIME) and _used(equations, c)]
    time = layouts.inputs.index(TIME) if TIME in layouts.inputs else None
    dt = repr(equations.dt)
    return MODEL.substitute(
        title=equations.robot or "robot",
        dt=dt,
        **{group: " ".join(columns) for group, columns in groups.items()},
        parameters=" ".join(parameters),
        values=repr([equations.parameters[name] for name in parameters]),
        methods="\n\n".join(methods),
        n=len(layouts.state),
        m=len(layouts.action),
        k=len(layouts.inputs),
        p=len(parameters),
        inputs_optional=repr(not measured),
        pushed="_pushed" if pushed else "",
        advance_known=_advance(time, "known", f"torch.full_like(columns[0], k * {dt})"),
        advance_held=textwrap.indent(_advance(time, "known", f"held[{time}] + k * {dt}"), "    "),
    )


def _advance(time: int | None, target: str, value: str) -> str:
    return " " * 16 + ("pass" if time is None else f"{target}[{time}] = {value}")


def _used(equations: Equations, name: str) -> bool:
    return any(equations.depends(column, name) for column in equations.layouts.state)


def function_source(expressions: Sequence[Expr], arguments: Sequence[Sequence[str]]) -> str:
    """Source of the class ``Function``: one tensor argument per group of column names."""
    groups = {f"a{i}": tuple(columns) for i, columns in enumerate(arguments)}
    program = function_program(expressions, [name for columns in arguments for name in columns])
    checks = [f'assert {g}.shape[-1] == {len(c)}, "expected the columns {" ".join(c)}"' for g, c in groups.items()]
    unbind = [f"{group}_columns = list(torch.unbind({group}, -1))" for group in groups]
    return FUNCTION.substitute(
        n=len(expressions),
        methods="\n\n".join(_pair(program, groups, ())),
        arguments=", ".join(f"{group}: Tensor" for group in groups),
        columns="; ".join(" ".join(columns) for columns in arguments),
        checks=textwrap.indent("\n".join(checks), " " * 8),
        unbind=textwrap.indent("\n".join(unbind), " " * 8),
        groups=", ".join(f"{group}_columns" for group in groups),
        first="a0_columns[0]",
        shapes=", ".join(f"{group}[..., 0]" for group in groups),
    )
