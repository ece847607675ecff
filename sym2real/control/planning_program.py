"""What MPPI computes per sample and step, as one straight-line program: next state on the manifold, and its cost."""

from sympy import Expr

from sym2real.robots.robot import Robot
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.graph import Graph, Lowered
from sym2real.symbolic.lowering import Lowering
from sym2real.symbolic.program import Program
from sym2real.symbolic.schedule import make_program
from sym2real.symbolic.source import on_manifold


def planning_program(equations: Equations, robot: Robot, cost: Expr, residual: bool = False) -> Program:
    """One step of a rollout of equations, priced: next state, then the cost.

    Its inputs are state, acting actions, inputs, ``planned <action>``, ``reference <column>``, ``residual <column>``.

    Args:
        equations: with their parameter values, which become constants.
        robot: gives the limits of the actions and the columns of the reference.
        cost: over state, action and reference columns (``ref_x``).
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
    return make_program(graph, [*nodes, price])
