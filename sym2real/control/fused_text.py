"""C text of one step of MPPI: noise, rollout, cost and weighted mean in one pass over registers and first-level cache.

The file ``sym2real/native/plan.h`` says what happens around a rollout; printed is the rollout of these equations with
this cost.
"""

from string import Template

from sym2real.control.fused_problem import Fused
from sym2real.control.fused_residual import residual_lines, residual_text
from sym2real.control.planning_program import planning_program
from sym2real.effects.filters import spelled_out
from sym2real.symbolic.c_functions import header, preamble
from sym2real.symbolic.c_source import CLines
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.program import Program
from sym2real.symbolic.source import SMALLEST_NORM_SQUARED, TIME, function_program

SINGLE = True
TILE_OF = "EXPORTED int tile(void) { return TILE; }"

HORIZON = Template("""
INLINE v total_cost(const struct plan *p, const TRACK track) {
$held
$memory
$start
$room
    v cost = splat(R(0.0));
    for (int h = 0; h < p->horizon; h++) {
$loaded
$filtered
$first
$network
$step
$following
    }
    return cost;
}
""")


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
            _horizon(step),
            header(f"plan_{machine}.h"),
        ]
    )


def _horizon(step: Fused) -> str:
    """C function ``total_cost`` of a vector of rollouts."""
    equations, filters = step.equations, step.filters
    layouts = equations.layouts
    program = planning_program(equations, step.robot, step.cost, residual=bool(step.residual))
    lines = CLines(program, SINGLE, _named(program))
    moving = program.reached_by({label for label in program.inputs if label not in layouts.inputs or label == TIME})
    held = [value for value in program.computed if value not in moving]
    visible = step.robot.layouts.state.columns
    room, network = residual_lines(step.residual, visible, layouts.action.columns) if step.residual else ([], [])
    parts = {
        "room": room,
        "held": _inputs(equations) + lines.lines(held),
        "memory": filters.before(),
        "start": _start(equations),
        "loaded": _loaded(equations, program),
        "filtered": filters.lines(),
        "first": _hidden(equations),
        "step": lines.lines(moving),
        "following": _following(equations, lines),
        "network": network,
    }
    return HORIZON.substitute({part: "\n".join(text) for part, text in parts.items()})


def _named(program: Program) -> dict[int, str]:
    """C names of the inputs that are not columns of the equations, by number."""
    return {
        number: label.replace(" ", "_")
        for number, label in enumerate(program.inputs)
        if label.split()[0] in ("planned", "reference", "residual")
    }


def _start(equations: Equations) -> list[str]:
    """The measured state, on the manifold, and the hidden one as it has gone on so far."""
    visible = [field for field in equations.layouts.state.fields if not field.hidden]
    columns = [column for field in visible for column in field.columns]
    lines = [f"v x_{column} = splat(p->state[{i}]);" for i, column in enumerate(columns)]
    for field in visible:
        if field.kind != "vector":
            square = " + ".join(f"x_{column} * x_{column}" for column in field.columns)
            least = f"splat(R({SMALLEST_NORM_SQUARED!r}))"
            lines.append(f"const v scale_{field.columns[0]} = reciprocal_root(maximum({square}, {least}));")
            lines += [f"x_{column} *= scale_{field.columns[0]};" for column in field.columns]
    hidden = [column for field in equations.layouts.state.fields if field.hidden for column in field.columns]
    return lines + [f"v x_{column} = splat(p->hidden ? p->hidden[{i}] : R(0.0));" for i, column in enumerate(hidden)]


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
    """Hidden states that begin: before the first step, from the first action that reaches the robot."""
    if not equations.start:
        return []
    values = [spelled_out(equations, expression) for expression in equations.start.values()]
    program = function_program(values, list(equations.layouts.columns))
    lines = CLines(program, SINGLE)
    inner = lines.lines(set(program.computed))
    inner += [f"x_{c} = {lines.vector(value)};" for c, value in zip(equations.start, program.outputs, strict=True)]
    return ["if (h == 0 && !p->hidden) {", *(f"    {line}" for line in inner), "}"]


def _following(equations: Equations, lines: CLines) -> list[str]:
    *following, cost = lines.program.outputs
    result = [f"const v next_{i} = {lines.vector(value)};" for i, value in enumerate(following)]
    result += [f"x_{column} = next_{i};" for i, column in enumerate(equations.layouts.state)]
    return [*result, f"cost += {lines.name(cost)};"]
