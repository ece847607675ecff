r"""Level axes that are no principal axes of inertia: what a load at an arm brings beside its mass.

``inertia_axes``. J₀ → J₀ + ΔJ about the centre of mass, with u = √(J_x J_y)::

    ΔJ = [[a J_x, e u], [e u, -a J_y]]

in the level plane: a is by how much a roll is harder than a pitch, e = J_xy/u makes one with the other, and a load that
stands diagonally at (x, y) has J_xy = -m x y. What makes all turns harder alike is ``rate_loop_gain``: no flight parts
inertia from the loop's stiffness. The motors' torques stay, so that a rate loop turns the body by::

    (J₀ + ΔJ) ω̇ = J₀ K (ω_cmd - ω) + τ - ω × ΔJ ω

With A = (J₀ + ΔJ)⁻¹ J₀ K and ω_0 = ω_cmd + (J₀ K)⁻¹ τ, the last term in τ and held, a step is exactly::

    ω' = ω_0 + e^(-A dt) (ω - ω_0)

The exponential of A dt = s I + N, of trace zero in N, is e^(-s) (cosh q I - sinh q N/q), q² = -det N.
"""

from typing import Any

import numpy as np
from sympy import Expr, Integer, Matrix, exp

from sym2real.effects import truth
from sym2real.effects.body import Body
from sym2real.effects.kind import Domain, Kind, Numbers, Values, of_any_body, several
from sym2real.effects.loops import NUMBERS, other_torque, rate_loops
from sym2real.effects.manoeuvres import EXCITED
from sym2real.effects.wrench import apply_wrench
from sym2real.symbolic import Equations
from sym2real.vocabulary import RATE, RATE_COMMAND

TERMS = 4  # of cosh q and sinh q/q in q² behind the first, where q is hardly ever beyond one
MOST = 0.65  # where both are as large, the inertia about every axis is still positive


def _more(values: Values, body: Body) -> Matrix:
    """ΔJ ``# (3, 3)``, kg m²."""
    x, y = body.number("jx"), body.number("jy")
    across, product = values["roll"], values["coupling"] * (x * y) ** 0.5
    return Matrix([[across * x, product, 0], [product, -across * y, 0], [0, 0, 0]])


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    loops, more = rate_loops(body, equations.dt), _more(values, body)
    rates = Matrix([loop.rate for loop in loops])
    torques = Matrix([other_torque(equations, loop.axis) for loop in loops])
    stiffness = Matrix.diag(*(loop.inertia * loop.gain for loop in loops))
    aims = Matrix([loop.command for loop in loops]) + stiffness.inv() * (torques - rates.cross(more * rates))
    inertia = (Matrix.diag(*(loop.inertia for loop in loops)) + more)[:2, :2]
    # Not by elimination, which may divide by what is null; nor by SymPy's determinant, which simplifies for a minute.
    determinant = inertia[0, 0] * inertia[1, 1] - inertia[0, 1] ** 2
    adjugate = Matrix([[inertia[1, 1], -inertia[0, 1]], [-inertia[0, 1], inertia[0, 0]]])
    level = adjugate / determinant * stiffness[:2, :2] * equations.dt
    left = Matrix.diag(_exponential(level), loops[2].kept)
    ends = aims + left * (rates - aims)
    return apply_wrench(
        equations,
        body,
        torque=[loop.torque_that_ends_at(end) - torque for loop, end, torque in zip(loops, ends, torques, strict=True)],
    )


def _exponential(matrix: Matrix) -> Matrix:
    """e to the power of minus a two by two matrix with real eigenvalues, in powers of half their distance."""
    half: Expr = matrix.trace() / 2
    rest = matrix - half * Matrix.eye(2)
    square = rest[0, 0] ** 2 + rest[0, 1] * rest[1, 0]
    even = odd = Integer(1)
    for last in range(2 * TERMS, 0, -2):
        even, odd = 1 + square / (last * (last - 1)) * even, 1 + square / (last * (last + 1)) * odd
    return exp(-half) * (even * Matrix.eye(2) - odd * rest)


def _turn_axes(spec: Any, body: Body, values: Numbers) -> None:
    truth.set_inertial(spec, inertia=np.array(_more(values, body), dtype=float))


INERTIA_AXES = Kind(
    name="inertia_axes",
    stage="loop",
    parameters=of_any_body(
        *several(("roll", "coupling"), "1", null=0.0, low=-MOST, high=MOST, scale=0.1, domain=Domain(-MOST, MOST))
    ),
    formula=r"(J_0 + \Delta J)\,\dot\omega = J_0 K\,(\omega_\mathrm{cmd} - \omega) + \tau, \quad "
    r"\Delta J = \begin{pmatrix} a J_x & e u \\ e u & -a J_y \end{pmatrix},\ u = \sqrt{J_x J_y}",
    summary="A roll is harder or easier than a pitch, or one makes the other: inertia of a load at an arm.",
    confused_with="gains of one rate command, where commands change slowly beside the loop",
    shown_by=EXCITED,
    fix="put the inertia into the model (`nominal quadrotor --inertia`), or carry the load under the centre; if roll "
    "and pitch loops have other gains, put those into it (`--rate-gains`): no flight parts the two",
    inject=truth.editing(_turn_axes),
    substitute=_substitute,
    needs=(*RATE_COMMAND.columns, *RATE.columns),
    numbers=NUMBERS,
    robot="quadrotor",
)
