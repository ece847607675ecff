"""The running cost of the paper, eq. (5), as a SymPy expression.

::

    α_p ‖p - p*‖ + α_r d_R(R, R*) + α_v ‖v - v*‖ + α_ω ‖ω - ω*‖
    d_R = 1 - (q · q*)²                         (quaternion)
    d_R = |sin θ - sin θ*| + |cos θ - cos θ*|   (unit circle)
"""

from collections.abc import Callable, Iterable

import sympy
from torch import Tensor

from sym2real.layout import Layouts
from sym2real.robots.robot import Robot
from sym2real.symbolic import compile_function, symbol
from sym2real.tasks.task import Task

# Added under each root, so that its gradient at zero is finite; 1e-6 of a metre is nothing to a cost.
SMOOTH = sympy.Float(1e-12)


def tracking_cost(robot: Robot) -> sympy.Expr:
    """Eq. (5) over the robot's state fields and ``ref_<column>``, with the weights of its recipe, whatever fields."""
    weights = robot.recipe.cost_weights
    fields = [field for field in robot.layouts.state.fields if not field.hidden]
    named = [(field, field.name if field.kind == "vector" else "orientation") for field in fields]
    return sympy.Add(
        *(weights[name] * DISTANCES[field.kind](field.columns) for field, name in named if name in weights)
    )


def distance(columns: Iterable[str]) -> sympy.Expr:
    """Euclidean distance of columns from their reference."""
    return sympy.sqrt(sympy.Add(SMOOTH, *(error(column) ** 2 for column in columns)))


def quaternion_distance(columns: Iterable[str]) -> sympy.Expr:
    """1 - (q · q*)²: zero for equal rotations, q and -q alike."""
    return 1 - sympy.Add(*(symbol(column) * symbol(f"ref_{column}") for column in columns)) ** 2


def circle_distance(columns: Iterable[str]) -> sympy.Expr:
    """Sum of the absolute errors of sine and cosine."""
    return sympy.Add(*(sympy.Abs(error(column)) for column in columns))


DISTANCES = {"vector": distance, "quaternion": quaternion_distance, "circle": circle_distance}


def error(column: str) -> sympy.Expr:
    """Distance of a column from its reference, signed."""
    return symbol(column) - symbol(f"ref_{column}")


def running_cost(task: Task, layouts: Layouts) -> Callable[[Tensor, Tensor, Tensor], Tensor]:
    """A task's cost as one call over a batch: states, actions, references → ``# (...,)``."""
    if not isinstance(task.cost, sympy.Expr):
        return task.cost
    states, actions = layouts.state.columns, layouts.action.columns
    function = compile_function([task.cost], [states, actions, [f"ref_{column}" for column in states]])
    return lambda state, action, reference: function(state, action, reference)[..., 0]
