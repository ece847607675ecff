"""# A new effect in one file

An effect is a hypothesis that substitutes into equations, and an independent truth that changes a simulated robot by
its own means. Here: a rope that pulls a drone back towards the origin, F = -k p.

    python docs/tutorials/08_new_effect.py
"""

import sys
from typing import Any

from sym2real import MPPI, ROBOTS, MujocoPlant, compile_model, make_task, run_episode
from sym2real.effects import Effect, truth
from sym2real.effects.body import Body
from sym2real.effects.kind import Kind, Parameter, of_any_body
from sym2real.effects.wrench import apply_wrench
from sym2real.symbolic import Equations, symbol

SHORT = "--short" in sys.argv
PLACE = ("x", "y", "z")


# Its numbers: name, unit, the value at which it does nothing, bounds, and the size that is to be expected.

STIFFNESS = Parameter("stiffness", "N/m", null=0.0, low=0.0, high=1.0, scale=0.02)

# The hypothesis: a force in N along world axes goes into the wrench inputs of whatever equations there are.


def substitute(equations: Equations, values: dict, body: Body) -> Equations:
    return apply_wrench(equations, body, force=[-values["stiffness"] * symbol(axis) for axis in PLACE])


# The truth, which uses none of that: a force on MuJoCo's body before every physics step.


def pull(data: Any, body: Body, values: dict) -> None:
    truth.add_force(data, -values["stiffness"] * data.qpos[:3])


ROPE = Kind(
    name="rope",
    stage="wrench",
    parameters=of_any_body(STIFFNESS),
    formula=r"F = -k\,p",
    summary="A rope pulls towards the origin.",
    confused_with="added mass at one height",
    shown_by="several places and heights",
    fix="cut the rope",
    inject=truth.with_force(pull),
    substitute=substitute,
    needs=PLACE,
    numbers=("mass",),
)

# Bound to a robot or to equations it is an effect like any other. The truth flies:

robot = ROBOTS["crazyflie"]
model, task = robot.nominal(), make_task("circle", robot)
rope = Effect(ROPE, Body.of(model))
tied = MujocoPlant(robot, [rope.inject(stiffness=0.03)])
log = run_episode(tied, MPPI(compile_model(model), robot, task), task, steps=200 if SHORT else 400)

# The hypothesis predicts. Which stiffness fits the log best, 0.5 s ahead?

fits = {k: rope.substitute(model, {"stiffness": k}).score(log)["position"] for k in (0.0, 0.015, 0.03, 0.045)}
for stiffness, fit in fits.items():
    print(f"{stiffness:.3f} N/m: fit of the position {fit:.2f} %")
log.plot(without=model, rope=rope.substitute(model, {"stiffness": 0.03})).savefig("measured_and_predicted.svg")
assert max(fits, key=lambda stiffness: fits[stiffness]) == 0.03

# In the package the file is `sym2real/effects/rope.py`, and one line in `kinds.py` registers it. Contract tests then
# hold the hypothesis against the truth, `diagnose` tests it beside all others, and `sym2real add MODEL rope --fit LOG`
# fits it with an interval.
