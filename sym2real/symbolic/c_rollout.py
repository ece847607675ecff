"""Equations → C text of a whole rollout: any broadcast of states, actions, inputs and parameter sets."""

from __future__ import annotations

from collections.abc import Sequence
from string import Template

from sym2real.symbolic.c_functions import header, preamble
from sym2real.symbolic.c_source import CLines
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.source import TIME, step_program

KERNEL = Template("""
static void roll_block(const struct batch *b, long long first) {
    long long in_state[WIDTH], in_actions[WIDTH], in_inputs[WIDTH], in_parameters[WIDTH];
    find_offsets(b, &b->state, first, in_state);
    find_offsets(b, &b->actions, first, in_actions);
    find_offsets(b, &b->inputs, first, in_inputs);
    find_offsets(b, &b->parameters, first, in_parameters);
$state
$parameters
$inputs
$hoisted
    for (long long h = 0; h < b->horizon; h++) {
        if (h && b->per_step) {
$next_inputs
        }
$time
$actions
$step
$following
$stored
    }
}

EXPORTED void roll_out(const struct batch *b) {
    for (long long first = 0; first < b->count; first += WIDTH) roll_block(b, first);
}
""")


def rollout_text(equations: Equations, single: bool) -> str:
    """C text that exports ``roll_out``, in float32 or float64."""
    layouts, parameters = equations.layouts, tuple(equations.parameters)
    program = step_program(equations)
    lines = CLines(program, single)
    moving = program.reached_by({*layouts.state, *layouts.action, *layouts.inputs})
    hoisted = [value for value in program.computed if value not in moving]
    following = [f"const v next_{i} = {lines.vector(value)};" for i, value in enumerate(program.outputs)]
    following += [f"x_{column} = next_{i};" for i, column in enumerate(layouts.state)]
    time = f"const v x_{TIME} = start_{TIME} + (b->per_step ? R(0.0) : h * {lines.number(equations.dt)});"
    kernel = KERNEL.substitute(
        state=_indented(_loads("state", layouts.state.columns), 4),
        parameters=_indented(_loads("parameters", parameters), 4),
        inputs=_indented(
            [line.replace(f"x_{TIME} ", f"start_{TIME} ") for line in _loads("inputs", layouts.inputs.columns)], 4
        ),
        hoisted=_indented(lines.lines(set(hoisted)), 4),
        next_inputs=_indented([_reload(i, column) for i, column in enumerate(layouts.inputs)], 12),
        time=_indented([time] if TIME in layouts.inputs else [], 8),
        actions=_indented(_loads("actions", layouts.action.columns, "h * b->actions.step"), 8),
        step=_indented(lines.lines(moving), 8),
        following=_indented(following, 8),
        stored=_indented(
            [f"scatter(b, h * {len(layouts.state)} + {i}, first, x_{c});" for i, c in enumerate(layouts.state)], 8
        ),
    )
    return "\n".join([preamble(single), header("batch.h"), kernel])


def _loads(operand: str, columns: Sequence[str], offset: str = "0") -> list[str]:
    return [
        f"v x_{column} = gather(b->{operand}.data + {offset} + {i} * b->{operand}.column, in_{operand});"
        for i, column in enumerate(columns)
    ]


def _reload(place: int, column: str) -> str:
    name = f"start_{TIME}" if column == TIME else f"x_{column}"
    return f"{name} = gather(b->inputs.data + h * b->inputs.step + {place} * b->inputs.column, in_inputs);"


def _indented(lines: Sequence[str], spaces: int) -> str:
    return "\n".join(" " * spaces + line for line in lines)
