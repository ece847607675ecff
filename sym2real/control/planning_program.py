"""What MPPI computes per sample and step, as one straight-line program: next state on the manifold, and its cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from sympy import Expr

from sym2real.robots.robot import Robot
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.graph import Graph, Lowered
from sym2real.symbolic.intervals import Interval
from sym2real.symbolic.lowering import Lowering
from sym2real.symbolic.program import Instruction, Program
from sym2real.symbolic.schedule import make_program
from sym2real.symbolic.sines import CALLS, Assumed
from sym2real.symbolic.source import on_manifold

# Columns of the state may be this large, in their unit, while short sines hold; a rollout that goes beyond is computed
# again with sines of any argument.
REACH = 16.0
UNIT = 1.0001  # a component of a quaternion or of a unit circle, rounding included


@dataclass(frozen=True)
class Planning:
    """A program whose outputs are the next state, the cost and what is guarded, and where its inputs come from.

    Args:
        program: over state, acting actions, inputs, ``planned <action>``, ``reference <column>``,
            ``residual <column>``; its last output is the sum of squares of the guarded columns, where there are any.
        guarded: state columns that must stay within :data:`REACH`.
        assumed: intervals under which sines may be short.
    """

    program: Program
    guarded: tuple[str, ...]
    assumed: Assumed


def planning_program(
    equations: Equations, robot: Robot, cost: Expr, filtered: bool = False, residual: bool = False
) -> Planning:
    """One step of a rollout of equations, priced.

    Args:
        equations: with their parameter values, which become constants.
        robot: gives the limits of the actions and the columns of the reference.
        cost: over state, action and reference columns (``ref_x``).
        filtered: what acts is not the planned action itself.
        residual: something is added to the next state (``residual <column>``), before it is normalised again.

    Raises:
        ModelError: for functions that are not supported.
        UnknownNameError: for names that are neither column nor reference.
    """
    layouts = equations.layouts
    state, actions = layouts.state.columns, layouts.action.columns
    visible = robot.layouts.state.columns
    names = [
        *state,
        *actions,
        *layouts.inputs,
        *(f"planned {a}" for a in actions),
        *(f"reference {c}" for c in visible),
    ]
    names += [f"residual {c}" for c in visible] if residual else []
    graph = Graph(names)
    dynamics = Lowering(graph, equations.quantities, equations.parameters)
    columns = {column: dynamics.lower(equations.next[column]) for column in state}
    nodes = on_manifold(graph, layouts.state, columns)
    if residual:
        added = {column: (1.0, node) for column, node in zip(state, nodes, strict=True)}
        added |= {c: graph.sum([added[c], (1.0, graph.inputs[f"residual {c}"])]) for c in visible}
        nodes = on_manifold(graph, layouts.state, added)
    known: dict[str, Lowered] = {column: (1.0, node) for column, node in zip(state, nodes, strict=True)}
    known |= {action: (1.0, graph.inputs[f"planned {action}"]) for action in actions}
    known |= {f"ref_{column}": (1.0, graph.inputs[f"reference {column}"]) for column in visible}
    price = graph.whole(Lowering(graph, values=known).lower(cost))
    program = make_program(graph, [*nodes, price])
    guarded = _guarded(program, equations)
    return Planning(_with_squares(program, guarded), guarded, _assumed(equations, robot, filtered))


def _guarded(program: Program, equations: Equations) -> tuple[str, ...]:
    """State columns that are no unit vectors and that the argument of a sine depends on."""
    free = [c for field in equations.layouts.state.fields if field.kind == "vector" for c in field.columns]
    arguments = {operands[0] for operation, operands in program.instructions if operation in CALLS}
    return tuple(column for column in free if not program.reached_by({column}).isdisjoint(arguments))


def _with_squares(program: Program, columns: tuple[str, ...]) -> Program:
    """The program with the sum of squares of some inputs as one more output."""
    if not columns:
        return program
    instructions = {
        instruction: value for value, instruction in zip(program.computed, program.instructions, strict=True)
    }

    def emit(operation: str, *operands: int) -> int:
        return instructions.setdefault(Instruction(operation, operands), program.first_instruction + len(instructions))

    size, *others = (emit("multiply", place, place) for place in map(program.inputs.index, columns))
    for other in others:
        size = emit("add", size, other)
    return Program(program.inputs, program.constants, tuple(instructions), (*program.outputs, size))


def _assumed(equations: Equations, robot: Robot, filtered: bool) -> Assumed:
    intervals: dict[str, Interval] = {}
    for field in equations.layouts.state.fields:
        most = REACH if field.kind == "vector" else UNIT
        intervals |= dict.fromkeys(field.columns, Interval(-most, most))
    limits: Mapping[str, Interval] = {
        action: Interval(float(low), float(high))
        for action, low, high in zip(robot.layouts.action, robot.low, robot.high, strict=True)
    }
    intervals |= {f"planned {action}": limit for action, limit in limits.items()}
    if not filtered:  # what filters remember may have been sent by someone else
        intervals |= limits
    return Assumed(intervals)
