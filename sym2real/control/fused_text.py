"""C text of one step of MPPI: noise, rollout, cost and weighted mean in one pass over registers and first-level cache.

The file ``sym2real/native/plan.h`` says what happens around a rollout; printed here is the rollout of these equations
with this cost, twice where it has sines: with short sines under assumptions that are checked, and with sines of any
argument for the blocks of samples in which an assumption failed.
"""

from __future__ import annotations

import math
from dataclasses import replace
from string import Template

from sym2real.control.fused_horizon import SINGLE, horizon_text
from sym2real.control.fused_problem import Fused, Sampling
from sym2real.control.fused_residual import residual_text
from sym2real.control.planning_program import REACH, Planning, planning_program
from sym2real.symbolic.c_functions import header, polynomial_macro, preamble
from sym2real.symbolic.chebyshev import shortest
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.intervals import Interval
from sym2real.symbolic.origin import origin_of_equations, origin_of_expression
from sym2real.symbolic.sines import HALF_TURN, plan_sines

NOISE_ERROR = 2e-5
BLOCKS = 2  # vectors of samples that share what is read of a network; more would leave the first-level cache

TOTAL = Template("""
INLINE void total_costs(const struct plan *p, const TRACK tracks, v *costs) {
    v worst = splat(R(0.0));
    horizon_short(p, tracks, &worst, costs);
    if ($guarded && any_beyond(worst, $limit)) again(p, tracks, costs);
    EACH_BLOCK costs[b] += price_of(p, OF_BLOCK(p, tracks, b));
}
""")
TILE_OF = "EXPORTED int tile(void) { return TILE; }"
AGAIN = """
APART void again(const struct plan *p, const TRACK tracks, v *costs) {
    v worst;
    horizon_any(p, tracks, &worst, costs);
}
"""


def fused_text(step: Fused, machine: str = "cpu") -> str:
    """C text that exports ``plan_share``, ``finish`` and ``noise_of`` (machine "cpu"), or CUDA kernels ("gpu")."""
    planning = planning_program(
        step.equations, step.robot, step.cost, filtered=bool(step.filters.stages), residual=bool(step.residual)
    )
    network = [header("network.h"), residual_text(step.residual.sizes)] if step.residual else []
    network += [TILE_OF] if step.residual and machine == "cpu" else []
    return "\n".join(
        [
            preamble(SINGLE, machine),
            *definitions(step.equations, step.sampling),
            *([f"#define BLOCKS {BLOCKS if step.residual else 1}"] if machine == "cpu" else []),
            header("random.h"),
            header("plan.h"),
            *network,
            *rollouts(step, planning, machine),
            header(f"plan_{machine}.h"),
        ]
    )


def origin_of(step: Fused) -> str:
    """What the text follows from."""
    robot, filters = step.robot, step.filters
    limits = [robot.low.tolist(), robot.high.tolist()]
    numbers = (robot.layouts.state, robot.layouts.action, limits, step.sampling, step.residual)
    memory = (filters.stages, filters.actions, filters.dt)
    written = (origin_of_expression(step.cost), origin_of_equations(step.equations))
    return "\n".join(["plan", repr(numbers), repr(memory), *written])


def definitions(equations: Equations, sampling: Sampling) -> list[str]:
    """Sizes and polynomials that the fixed text needs."""
    lines = [
        f"#define ACTIONS {len(equations.layouts.action)}",
        f"#define COLOUR {sampling.colour}",
        f"#define DIAGONAL {int(sampling.diagonal)}",
    ]
    ranges = {"sin": HALF_TURN, "cos": HALF_TURN, "log2": Interval(1.0, 2.0)}
    found = {function: shortest(function, ranges[function], NOISE_ERROR, SINGLE) for function in ranges}
    sine, cosine, logarithm = (found[function] for function in ranges)
    assert sine and cosine and logarithm
    squared = tuple(-2.0 * math.log(2.0) * coefficient for coefficient in logarithm.coefficients)
    named = {"SINE": sine, "COSINE": cosine, "LOG": replace(logarithm, coefficients=squared)}
    return lines + [polynomial_macro(f"NORMAL_{name}", polynomial, SINGLE) for name, polynomial in named.items()]


def rollouts(step: Fused, planning: Planning, machine: str) -> list[str]:
    """The rollout with short sines, with any sines where they differ, and the choice between them."""
    state = len(step.equations.layouts.state)
    sines = plan_sines(planning.program, planning.assumed, planning.program.outputs[:state])
    guarded = bool(sines)
    texts = [horizon_text("short", step, planning, sines, machine)]
    texts += [horizon_text("any", step, planning, {}, machine), AGAIN] if guarded else []
    texts.append(TOTAL.substitute(guarded=int(guarded), limit=f"R({REACH**2!r})"))
    return [text if guarded else text.replace("again(p, tracks, costs)", "(void)0") for text in texts]
