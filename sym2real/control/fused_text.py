"""C text of one step of MPPI: noise, rollout, cost and weighted mean in one pass over registers and first-level cache.

The file ``sym2real/native/plan.h`` says what happens around a rollout; printed here is the rollout of these equations
with this cost, twice where it has sines: with short sines under assumptions that are checked, and with sines of any
argument for the blocks of samples in which an assumption failed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from string import Template

from sympy import Expr
from torch import Tensor

from sym2real.control.fused_filters import FilterLines
from sym2real.control.fused_residual import residual_lines, residual_text
from sym2real.control.planning_program import REACH, UNIT, Planning, planning_program
from sym2real.effects.filters import spelled_out
from sym2real.robots.robot import MPPISettings, Robot
from sym2real.symbolic.c_functions import header, polynomial_macro, preamble
from sym2real.symbolic.c_source import CLines
from sym2real.symbolic.chebyshev import shortest
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.intervals import Interval
from sym2real.symbolic.program import Program
from sym2real.symbolic.sines import HALF_TURN, Sine, plan_sines
from sym2real.symbolic.source import TIME, function_program

NOISE_ERROR = {"sin": 2e-5, "cos": 2e-5, "log2": 2e-5}
SINGLE = True

HORIZON = Template("""
$table
INLINE v horizon_$name(const struct plan *p, const TRACK track, v *worst) {
$numbers
$start
$held
$memory
    v cost = splat(R(0.0));
    for (int h = 0; h < p->horizon; h++) {
$loaded
$filtered
$first
$guard
$step
$following
    }
    return cost;
}
""")
TOTAL = Template("""
INLINE v total_cost(const struct plan *p, TRACK track) {
    v worst = splat(R(0.0));
    v cost = horizon_short(p, track, &worst);
    if ($guarded && any_beyond(worst, $limit)) cost = again(p, track);
    return cost + price_of(p, track);
}
""")
AGAIN = """
APART v again(const struct plan *p, TRACK track) {
    v worst;
    return horizon_any(p, track, &worst);
}
"""


@dataclass(frozen=True)
class Sampling:
    """What of the sampling is fixed in the text.

    Args:
        colour: 0 white, 1 first-order correlated, 2 through a matrix.
        diagonal: the noise of the actions is independent.
    """

    colour: int
    diagonal: bool

    @classmethod
    def of(cls, settings: MPPISettings, factor: Tensor) -> Sampling:
        """The sampling of these settings with noise of covariance C Cᵀ."""
        colour = 2 if settings.knots else 1 if settings.correlation > 0 else 0
        return cls(colour, bool((factor == factor.diag().diag()).all()))


@dataclass(frozen=True)
class Fused:
    """What a fused step computes.

    Args:
        equations: with their parameter values, which become constants.
        robot: limits, columns and control period.
        cost: running cost over state, action and ``ref_<column>``.
        sampling: what of it is fixed.
        filters: what actions go through.
        residual: sizes of the layers of a network that adds to the next state; none for none.
    """

    equations: Equations
    robot: Robot
    cost: Expr
    sampling: Sampling
    filters: FilterLines
    residual: tuple[int, ...] = ()


def fused_text(step: Fused, machine: str = "cpu") -> str:
    """C text that exports ``plan_share``, ``finish`` and ``noise_of`` (machine "cpu"), or CUDA kernels ("gpu")."""
    planning = planning_program(
        step.equations, step.robot, step.cost, filtered=bool(step.filters.stages), residual=bool(step.residual)
    )
    network = [header("network.h"), residual_text(step.residual)] if step.residual else []
    return "\n".join(
        [
            preamble(SINGLE, machine),
            *definitions(step.equations, step.sampling),
            header("random.h"),
            header("plan.h"),
            *network,
            *rollouts(step, planning, machine),
            header(f"plan_{machine}.h"),
        ]
    )


def definitions(equations: Equations, sampling: Sampling) -> list[str]:
    """Sizes and polynomials that the fixed text needs."""
    lines = [
        f"#define ACTIONS {len(equations.layouts.action)}",
        f"#define COLOUR {sampling.colour}",
        f"#define DIAGONAL {int(sampling.diagonal)}",
    ]
    ranges = {"sin": HALF_TURN, "cos": HALF_TURN, "log2": Interval(1.0, 2.0)}
    for name, function in {"NORMAL_SINE": "sin", "NORMAL_COSINE": "cos", "NORMAL_LOG2": "log2"}.items():
        found = shortest(function, ranges[function], NOISE_ERROR[function], SINGLE)
        assert found is not None
        lines.append(polynomial_macro(name, found, SINGLE))
    return lines


def rollouts(step: Fused, planning: Planning, machine: str) -> list[str]:
    """The rollout with short sines, with any sines where they differ, and the choice between them."""
    sines = plan_sines(planning.program, planning.assumed, planning.program.outputs[:-1])
    guarded = bool(sines)
    texts = [_horizon("short", step, planning, sines, machine)]
    texts += [_horizon("any", step, planning, {}, machine), AGAIN] if guarded else []
    texts.append(TOTAL.substitute(guarded=int(guarded), limit=f"R({REACH**2!r})"))
    return [text if guarded else text.replace("again(p, track)", "cost") for text in texts]


def _horizon(name: str, step: Fused, planning: Planning, sines: Mapping[int, Sine], machine: str) -> str:
    equations, filters = step.equations, step.filters
    layouts, program = equations.layouts, planning.program
    numbers = {label: number for number, label in enumerate(program.inputs)}
    named = {numbers[f"planned {a}"]: f"planned_{a}" for a in layouts.action}
    named |= {
        n: label.replace(" ", "_") for label, n in numbers.items() if label.split()[0] in ("reference", "residual")
    }
    table: list[str] | None = [] if machine == "cpu" else None
    lines = CLines(program, SINGLE, sines, named, table)
    moving = program.reached_by({label for label in program.inputs if label not in layouts.inputs or label == TIME})
    held = [value for value in program.computed if value not in moving]
    parts = {
        "start": _indented(_start(equations, planning, bool(sines)), 4),
        "held": _indented(_inputs(equations) + lines.lines(held), 4),
        "memory": _indented(filters.before(), 4),
        "loaded": _indented(_loaded(equations, program), 8),
        "filtered": _indented(filters.lines(), 8),
        "first": _indented(_hidden(equations) + (residual_lines(layouts) if step.residual else []), 8),
        "guard": _indented(_guard(planning, lines) if sines else [], 8),
        "step": _indented(lines.lines(moving), 8),
        "following": _indented(_following(equations, planning, lines, bool(sines)), 8),
    }
    if not table:
        return HORIZON.substitute(parts, name=name, table="", numbers="")
    # The empty assembly hides what the numbers are: each is then loaded where it is used, four bytes at a time.
    return HORIZON.substitute(
        parts,
        name=name,
        table=f"static const real numbers_{name}[] = {{{', '.join(table)}}};",
        numbers=f'    const real *k = numbers_{name};\n    __asm__("" : "+r"(k));',
    )


def _start(equations: Equations, planning: Planning, guarded: bool) -> list[str]:
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


def _guard(planning: Planning, lines: CLines) -> list[str]:
    if not planning.guarded:
        return []
    first, *others = (f"x_{column}" for column in planning.guarded)
    result = [f"v size = {first} * {first};", *(f"size = {x} * {x} + size;" for x in others)]
    return [*result, "*worst = maximum(size, *worst);"]


def _following(equations: Equations, planning: Planning, lines: CLines, guarded: bool) -> list[str]:
    program, state = planning.program, equations.layouts.state
    result = []
    if guarded:
        scale = f"R({REACH / planning.assumed.longest_reciprocal!r})"
        for value in program.computed:
            instruction = program.instruction(value)
            if instruction is not None and instruction.operation == "rsqrt":
                result += [f"const v length_{value} = {lines.name(value)} * {scale};"]
                result += [f"*worst = maximum(length_{value} * length_{value}, *worst);"]
    *following, cost = program.outputs
    result += [f"const v next_{i} = {lines.vector(value)};" for i, value in enumerate(following)]
    result += [f"x_{column} = next_{i};" for i, column in enumerate(state)]
    return [*result, f"cost += {lines.name(cost)};"]


def _indented(lines: Sequence[str], spaces: int) -> str:
    return "\n".join(" " * spaces + line for line in lines)
