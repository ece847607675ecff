"""Programs → Python source of one ``torch.nn.Module`` that needs torch and nothing else.

Columns are laid out one after the other (features first), so that every operation runs over contiguous memory.
What depends on parameters alone is computed once, in ``hoist``, before the horizon loop.
"""

import math
import textwrap
from collections.abc import Mapping, Sequence
from functools import lru_cache

from sympy import Expr

from sym2real.layout import Layout
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.expressions import require_names
from sym2real.symbolic.graph import UNIT, Graph, Lowered
from sym2real.symbolic.lowering import Lowering
from sym2real.symbolic.program import Program
from sym2real.symbolic.schedule import make_program
from sym2real.symbolic.template import FUNCTION, MODEL
from sym2real.symbolic.torch_source import TorchLines
from sym2real.vocabulary import is_push

TIME = "t"
SMALLEST_NORM_SQUARED = 1e-24
Groups = Mapping[str, Sequence[str]]


def step_program(equations: Equations) -> Program:
    """Next state on the manifold over state, action, inputs and parameters."""
    layouts = equations.layouts
    names = (*layouts.columns, *equations.parameters)
    graph = Graph(names, fixed=equations.parameters)
    lowering = Lowering(graph, equations.quantities)
    columns = {column: lowering.lower(equations.next[column]) for column in layouts.state}
    return make_program(graph, on_manifold(graph, layouts.state, columns))


def function_program(
    expressions: Sequence[Expr], names: Sequence[str], definitions: Mapping[str, Expr] | None = None
) -> Program:
    """Values of the expressions over the names, and over what is defined by them."""
    graph = Graph(names)
    lowering = Lowering(graph, definitions)
    return make_program(graph, [graph.whole(lowering.lower(expression)) for expression in expressions])


def on_manifold(graph: Graph, layout: Layout, columns: Mapping[str, Lowered]) -> list[int]:
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


def _literal(value: float) -> str:
    return repr(value) if math.isfinite(value) else f'float("{value}")'


def _method(signature: str, body: Sequence[str]) -> str:
    return textwrap.indent("\n".join([f"def {signature} -> List[Tensor]:", *(f"    {line}" for line in body)]), "    ")


def methods_of(program: Program, groups: Groups, parameters: Sequence[str]) -> tuple[str, str]:
    """Source of two methods, and of the list of numbers that the first one is given as tensors without dimensions.

    ``hoist(values, constants)`` → what steps share: constants, and what parameters alone decide;
    ``step(<groups>, fixed)`` → results, in the shape of the state's columns where there is a state.

    Args:
        program: its inputs are the columns of the groups in order, then the parameters.
        groups: argument name → columns.
        parameters: columns of ``values``.

    Raises:
        ModelError: for a column or parameter that cannot be a variable's name.
    """
    require_names([*parameters, *(column for columns in groups.values() for column in columns)])
    places = {f"{group}_{column}": f"{group}[{i}]" for group, names in groups.items() for i, column in enumerate(names)}
    moving = program.reached_by({column for columns in groups.values() for column in columns})
    fixed = {*range(program.first_instruction), *program.computed} - moving
    lines = TorchLines(program, [*places, *(f"p_{name}" for name in parameters)], fixed)
    computed = [value for value in program.computed if value in moving and value not in lines.absorbed]
    read = set(program.outputs).union(*map(lines.reads, computed))
    handed = sorted(read & fixed)
    hoisted = [value for value in program.computed if value in fixed]
    needed = set(handed).union(*map(lines.reads, hoisted))
    constants = sorted(filter(program.is_constant, needed))
    hoist = [f"{lines.name(value)} = constants[{i}]" for i, value in enumerate(constants)]
    first_parameter = len(program.inputs) - len(parameters)
    hoist += [f"p_{name} = values[{i}]" for i, name in enumerate(parameters) if first_parameter + i in needed]
    hoist += lines.lines(hoisted)
    hoist.append(f"return [{', '.join(map(lines.name, handed))}]" if handed else "return constants[:0]")
    step = [f"{variable} = {place}" for i, (variable, place) in enumerate(places.items()) if i in read]
    step += [f"{lines.name(value)} = fixed[{i}]" for i, value in enumerate(handed)]
    step += lines.lines(computed)
    first, columns = next(iter(groups.items()))
    own_shape = program.reached_by(set(columns))
    expand = f".expand_as({first}[0])" if first == "state" else ""
    results = [lines.name(value) + ("" if value in own_shape else expand) for value in program.outputs]
    step.append(f"return [{', '.join(results)}]")
    arguments = ", ".join(f"{group}: List[Tensor]" for group in groups)
    methods = [
        _method("hoist(self, values: List[Tensor], constants: List[Tensor])", hoist),
        _method(f"step(self, {arguments}, fixed: List[Tensor])", step),
    ]
    numbers = ", ".join(_literal(program.constant(value)) for value in constants)
    return "\n\n".join(methods), f"[{numbers}]"


def model_source(equations: Equations) -> str:
    """Source of the class ``Dynamics``: ``forward`` and ``rollout`` of the equations."""
    layouts, parameters = equations.layouts, tuple(equations.parameters)
    groups = {str(group): layout.columns for group, layout in layouts.groups.items()}
    methods, constants = methods_of(step_program(equations), groups, parameters)
    time = layouts.inputs.index(TIME) if TIME in layouts.inputs else None
    dt = repr(equations.dt)
    return MODEL.substitute(
        about=f"Next state after {dt} s, generated from its equations",
        dt=dt,
        **{group: " ".join(columns) for group, columns in groups.items()},
        parameters=" ".join(parameters),
        values=f"[{', '.join(map(_literal, equations.parameters.values()))}]",
        methods=methods,
        constants=constants,
        n=len(layouts.state),
        m=len(layouts.action),
        k=len(layouts.inputs),
        p=len(parameters),
        inputs_optional=repr(not measured_inputs(equations)),
        time="" if time is None else f"if not varying:\n                known[{time}] = held[{time}] + k * {dt}",
    )


@lru_cache(maxsize=64)
def measured_inputs(equations: Equations) -> tuple[str, ...]:
    """Inputs that equations use and that cannot be taken for zero: all but external forces and the time."""
    used = (c for c in equations.layouts.inputs if any(equations.depends(s, c) for s in equations.layouts.state))
    return tuple(column for column in used if column != TIME and not is_push(column))


def function_source(
    expressions: Sequence[Expr], arguments: Sequence[Sequence[str]], definitions: Mapping[str, Expr] | None = None
) -> str:
    """Source of the class ``Function``: one tensor argument per group of column names."""
    groups = {f"a{i}": tuple(columns) for i, columns in enumerate(arguments)}
    program = function_program(expressions, [name for columns in arguments for name in columns], definitions)
    methods, constants = methods_of(program, groups, ())
    checks = [f'assert {g}.shape[-1] == {len(c)}, "expected the columns {" ".join(c)}"' for g, c in groups.items()]
    unbind = [f"{group}_columns = list(torch.unbind({group}, -1))" for group in groups]
    return FUNCTION.substitute(
        about="Function generated from expressions",
        n=len(expressions),
        methods=methods,
        constants=constants,
        arguments=", ".join(f"{group}: Tensor" for group in groups),
        columns="; ".join(" ".join(columns) for columns in arguments),
        checks=textwrap.indent("\n".join(checks), " " * 8),
        unbind=textwrap.indent("\n".join(unbind), " " * 8),
        groups=", ".join(f"{group}_columns" for group in groups),
        values=", ".join(f"values[{i}]" for i in range(len(expressions))),
        shapes=", ".join(f"{group}[..., 0]" for group in groups),
    )
