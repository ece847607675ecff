"""Equations → C text of a whole rollout of many samples, each with parameters of its own."""

from collections.abc import Sequence
from string import Template

from sym2real.symbolic.c_functions import preamble
from sym2real.symbolic.c_source import CLines
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.source import TIME, step_program

KERNEL = Template("""
INLINE v load(const real *from) {
    v r;
    __builtin_memcpy(&r, from, sizeof r);
    return r;
}
EXPORTED int width(void) { return WIDTH; }

/* Columns lie one after the other, each over all samples, whose count is a multiple of the width. */
EXPORTED void roll_out(const real *state, const real *actions, const real *inputs, const real *parameters, real *out,
                       long long count, long long horizon, long long per_step) {
    for (long long first = 0; first < count; first += WIDTH) {
$state
$parameters
$inputs
$hoisted
        for (long long h = 0; h < horizon; h++) {
            if (h && per_step) {
$next_inputs
            }
$time
$actions
$step
$following
        }
    }
}
""")


def rollout_text(equations: Equations, single: bool) -> str:
    """C text that exports ``roll_out``, in float32 or float64."""
    layouts, parameters = equations.layouts, tuple(equations.parameters)
    program = step_program(equations)
    lines = CLines(program, single)
    moving = program.reached_by({*layouts.columns})
    size, known = len(layouts.state), [f"start_{TIME}" if c == TIME else f"x_{c}" for c in layouts.inputs]
    following = [f"const v next_{i} = {lines.vector(value)};" for i, value in enumerate(program.outputs)]
    following += [f"x_{column} = next_{i};" for i, column in enumerate(layouts.state)]
    following += [
        f"__builtin_memcpy(out + (h * {size} + {i}) * count + first, &x_{column}, sizeof x_{column});"
        for i, column in enumerate(layouts.state)
    ]
    time = f"const v x_{TIME} = start_{TIME} + (per_step ? R(0.0) : h * {lines.number(equations.dt)});"
    parts = {
        "state": _loads("v ", [f"x_{column}" for column in layouts.state], "state"),
        "parameters": _loads("v ", [f"x_{name}" for name in parameters], "parameters"),
        "inputs": _loads("v ", known, "inputs"),
        "hoisted": lines.lines({value for value in program.computed if value not in moving}),
        "next_inputs": _loads("", known, "inputs", "h"),
        "time": [time] if TIME in layouts.inputs else [],
        "actions": _loads("v ", [f"x_{column}" for column in layouts.action], "actions", "h"),
        "step": lines.lines(moving),
        "following": following,
    }
    return "\n".join([preamble(single), KERNEL.substitute({name: "\n".join(text) for name, text in parts.items()})])


def _loads(kind: str, names: Sequence[str], operand: str, step: str = "0") -> list[str]:
    """Variables of a step from the columns of an operand."""
    return [
        f"{kind}{name} = load({operand} + ({step} * {len(names)} + {i}) * count + first);"
        for i, name in enumerate(names)
    ]
