"""C text of a rollout over the horizon: the printed part of a fused step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from string import Template

from sym2real.control.fused_problem import Fused
from sym2real.control.fused_residual import residual_lines
from sym2real.control.planning_program import REACH, UNIT, Planning
from sym2real.effects.filters import spelled_out
from sym2real.symbolic.c_source import CLines
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.polynomials import written_out
from sym2real.symbolic.program import Program
from sym2real.symbolic.sines import Sine
from sym2real.symbolic.source import TIME, function_program

SINGLE = True

HORIZON = Template("""
INLINE void horizon_$name(const struct plan *p, const TRACK track, v *worst, v *costs) {
    const int b = 0;
$start
$held
$memory
    v cost = splat(R(0.0));
    for (int h = 0; h < p->horizon; h++) {
$loaded
$filtered
$first
$step
$following
    }
    costs[0] = cost;
}
""")
# States wait in memory while the network works on all blocks at once: what of it is read serves them all.
HORIZON_WITH_NETWORK = Template("""
INLINE void horizon_$name(const struct plan *p, const TRACK tracks, v *worst, v *costs) {
    v states[BLOCKS][$size];
$room
$held
$memory
    EACH_BLOCK {
$start
$kept
        costs[b] = splat(R(0.0));
    }
    for (int h = 0; h < p->horizon; h++) {
        EACH_BLOCK {
            const TRACK track = OF_BLOCK(p, tracks, b);
$state
$loaded
$filtered
$first
$kept
$ahead
        }
        residual(p->weights, seen, left);
        EACH_BLOCK {
            const TRACK track = OF_BLOCK(p, tracks, b);
$state
$loaded
$behind
            v cost = costs[b];
$step
$following
$kept
            costs[b] = cost;
        }
    }
}
""")


def horizon_text(name: str, step: Fused, planning: Planning, sines: Mapping[int, Sine], machine: str) -> str:
    """C function ``horizon_<name>``: total cost of a block's rollouts, and how far what is assumed was left.

    Args:
        name: "short" or "any".
        step: what is computed.
        planning: its program.
        sines: how sines are computed; those that are not named are calls.
        machine: "cpu" or "gpu".
    """
    equations, filters = step.equations, step.filters
    layouts = equations.layouts
    program = written_out(planning.program, sines)
    lines = CLines(program, SINGLE, _named(program))
    moving = program.reached_by({label for label in program.inputs if label not in layouts.inputs or label == TIME})
    held = [value for value in program.computed if value not in moving]
    columns = list(enumerate(layouts.state))
    room, ahead, behind = (
        residual_lines(step.residual, step.robot.layouts.state.columns, layouts.action.columns)
        if step.residual
        else ([], [], [])
    )
    body = {
        "loaded": _loaded(equations, program),
        "filtered": filters.lines(),
        "first": _hidden(equations),
        "step": lines.lines(moving),
        "following": _following(equations, planning, lines, bool(sines)),
        "state": [f"v x_{column} = states[b][{i}];" for i, column in columns],
        "kept": [f"states[b][{i}] = x_{column};" for i, column in columns],
        "ahead": ahead,
        "behind": behind,
    }
    before = {
        "room": room,
        "start": _start(equations, bool(sines)),
        "held": _inputs(equations) + lines.lines(held),
        "memory": filters.before(),
    }
    return (HORIZON_WITH_NETWORK if step.residual else HORIZON).substitute(
        {part: _indented(text, 4) for part, text in before.items()},
        **{part: _indented(text, 8) for part, text in body.items()},
        name=name,
        size=len(columns),
    )


def _named(program: Program) -> dict[int, str]:
    """C names of the inputs that are not columns of the equations, by number."""
    return {
        number: label.replace(" ", "_")
        for number, label in enumerate(program.inputs)
        if label.split()[0] in ("planned", "reference", "residual")
    }


def _start(equations: Equations, guarded: bool) -> list[str]:
    fields = equations.layouts.state.fields
    visible = [column for field in fields if not field.hidden for column in field.columns]
    lines = [f"v x_{column} = splat(p->state[{i}]);" for i, column in enumerate(visible)]
    lines += [f"v x_{c} = splat(R(0.0));" for field in fields if field.hidden for c in field.columns]
    if guarded:
        units = [column for field in fields if field.kind != "vector" for column in field.columns]
        lines += [f"*worst = maximum(*worst, x_{c} * x_{c} * R({(REACH / UNIT) ** 2!r}));" for c in units]
    return lines


def _inputs(equations: Equations) -> list[str]:
    lines = []
    for i, column in enumerate(equations.layouts.inputs):
        name = f"start_{TIME}" if column == TIME else f"x_{column}"
        lines.append(f"const v {name} = splat(p->inputs[{i}]);")
    return lines


def _loaded(equations: Equations, program: Program) -> list[str]:
    lines = [f"const v planned_{a} = AT(track, h, {i});" for i, a in enumerate(equations.layouts.action)]
    references = [label.split()[1] for label in program.inputs if label.startswith("reference ")]
    size = len(references)
    lines += [f"const v reference_{c} = splat(p->reference[h * {size} + {i}]);" for i, c in enumerate(references)]
    if TIME in equations.layouts.inputs:
        lines.append(f"const v x_{TIME} = start_{TIME} + (real)h * R({equations.dt!r});")
    return lines


def _hidden(equations: Equations) -> list[str]:
    """Hidden states before the first step, from the first action that reaches the robot."""
    if not equations.start:
        return []
    program = function_program_of_start(equations)
    lines = CLines(program, SINGLE)
    inner = lines.lines(set(program.computed))
    inner += [f"x_{c} = {lines.vector(value)};" for c, value in zip(equations.start, program.outputs, strict=True)]
    return ["if (h == 0) {", *(f"    {line}" for line in inner), "}"]


def function_program_of_start(equations: Equations) -> Program:
    """First values of the hidden states over columns, parameters at their values."""
    layouts = equations.layouts
    names = [*layouts.state, *layouts.action, *layouts.inputs]
    return function_program([spelled_out(equations, expression) for expression in equations.start.values()], names)


def _following(equations: Equations, planning: Planning, lines: CLines, guarded: bool) -> list[str]:
    program, state = lines.program, equations.layouts.state
    following, (cost, *squares) = program.outputs[: len(state)], program.outputs[len(state) :]
    result = []
    if guarded:
        result += [f"*worst = maximum({lines.name(size)}, *worst);" for size in squares]
        scale = f"R({REACH / planning.assumed.longest_reciprocal!r})"
        for value, (operation, _) in zip(program.computed, program.instructions, strict=True):
            if operation == "rsqrt":
                result += [f"const v length_{value} = {lines.name(value)} * {scale};"]
                result += [f"*worst = maximum(length_{value} * length_{value}, *worst);"]
    result += [f"const v next_{i} = {lines.vector(value)};" for i, value in enumerate(following)]
    result += [f"x_{column} = next_{i};" for i, column in enumerate(state)]
    return [*result, f"cost += {lines.name(cost)};"]


def _indented(lines: Sequence[str], spaces: int) -> str:
    return "\n".join(" " * spaces + line for line in lines)
