"""C text of one step of MPPI: noise, rollout, cost and weighted mean in one pass over registers and first-level cache.

The file ``sym2real/native/plan.h`` says what happens around a rollout; printed is the rollout of these equations with
this cost.
"""

from sym2real.control.fused_horizon import SINGLE, horizon_text
from sym2real.control.fused_problem import Fused
from sym2real.control.fused_residual import residual_text
from sym2real.symbolic.c_functions import header, preamble

TILE_OF = "EXPORTED int tile(void) { return TILE; }"


def fused_text(step: Fused, machine: str = "cpu") -> str:
    """C text that exports ``plan_all``, ``shifted`` and ``noise_of`` (machine "cpu"), or CUDA kernels ("gpu")."""
    network = [header("network.h"), residual_text(step.residual.sizes)] if step.residual else []
    network += [TILE_OF] if step.residual and machine == "cpu" else []
    return "\n".join(
        [
            preamble(SINGLE, machine),
            f"#define ACTIONS {len(step.equations.layouts.action)}",
            f"#define COLOUR {step.colour}",
            header("random.h"),
            header("plan.h"),
            *network,
            horizon_text(step),
            header(f"plan_{machine}.h"),
        ]
    )
