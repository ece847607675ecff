"""Equations → C text of a whole rollout of many samples, each with parameters of its own."""

from collections.abc import Sequence
from string import Template

from sym2real.symbolic.c_functions import preamble
from sym2real.symbolic.c_source import CLines
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.source import TIME, step_program

KERNEL = Template("""
/* Where the samples of a vector lie in an operand, and whether all of them have the same numbers. */
typedef struct {
    const real *first[WIDTH];
    long long step, column;
    int same;
} operand;

/* Strides are those of sets, samples, steps and columns. */
INLINE operand lanes_of(const real *from, const long long *strides, const long long *set, const long long *sample) {
    operand lanes = {.step = strides[2], .column = strides[3], .same = 1};
    EACH_LANE {
        lanes.first[lane] = from + set[lane] * strides[0] + sample[lane] * strides[1];
        lanes.same &= lanes.first[lane] == lanes.first[0];
    }
    return lanes;
}

INLINE void load(const operand *from, long long h, int columns, v *to) {
    for (int i = 0; i < columns; i++) {
        const long long at = h * from->step + i * from->column;
        if (from->same)
            to[i] = splat(from->first[0][at]);
        else
            EACH_LANE to[i][lane] = from->first[lane][at];
    }
}

INLINE void store(v value, real *to, long long count) {
    if (count >= WIDTH)
        __builtin_memcpy(to, &value, sizeof value);
    else
        for (int lane = 0; lane < count; lane++)
            to[lane] = value[lane];
}

/* Of all samples of all sets those from begin to end, whole vectors but for the last one. Columns of the output lie
   one after the other, step by step, each over all samples. */
EXPORTED void roll_out(const real *state, const real *actions, const real *inputs, const real *parameters, real *out,
                       const long long *strides, long long samples, long long count, long long horizon,
                       long long per_step, long long begin, long long end) {
    for (long long first = begin; first < end; first += WIDTH) {
        long long set[WIDTH], sample[WIDTH];
        EACH_LANE { /* beyond the last sample, that one again */
            const long long number = first + lane < count ? first + lane : count - 1;
            set[lane] = number / samples, sample[lane] = number % samples;
        }
$operands
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
OPERANDS = ("state", "actions", "inputs", "parameters")


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
        f"store(x_{column}, out + (h * {size} + {i}) * count + first, count - first);"
        for i, column in enumerate(layouts.state)
    ]
    time = f"const v x_{TIME} = start_{TIME} + (per_step ? R(0.0) : h * {lines.number(equations.dt)});"
    parts = {
        "operands": [
            f"const operand of_{name} = lanes_of({name}, strides + {4 * i}, set, sample);"
            for i, name in enumerate(OPERANDS)
        ],
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
    if not names:
        return []
    loaded = [f"v {operand}_columns[{len(names)}];", f"load(&of_{operand}, {step}, {len(names)}, {operand}_columns);"]
    return [*loaded, *(f"{kind}{name} = {operand}_columns[{i}];" for i, name in enumerate(names))]
