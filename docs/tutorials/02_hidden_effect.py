"""# A hidden effect: from a log to a better controller

A car's steering is off, and nobody knows. The log of one drive says so, says by how much, and makes a model that knows.

    python docs/tutorials/02_hidden_effect.py
"""

import sys

import numpy as np

from sym2real import (
    MPPI,
    ROBOTS,
    MujocoPlant,
    compare,
    compile_model,
    diagnose,
    effect,
    make_task,
    run_episode,
    sensors,
)

SHORT = "--short" in sys.argv

# The robot that differs is a simulator with a change that MuJoCo makes by its own means, and with noisy sensors. The
# model is of first principles and knows nothing of either.

robot = ROBOTS["mushr"]
task, model = make_task("circle", robot), robot.nominal()
hidden = effect("offset:steer", robot).inject(value=0.06)
real = MujocoPlant(robot, [sensors(robot, np.random.default_rng(0)), hidden])
log = run_episode(real, MPPI(compile_model(model), robot, task), task, steps=500, name="drive")

# How good is the model? Errors at the end of windows along the log, beside the noise of the sensors. In a notebook the
# answer is a table, and `.plot()` a figure.

gap = compare(model, log)
print(gap)
gap.plot().savefig("gap.svg")

# What is missing? The plain simulator calibrates the model first, so that its own errors are not taken for effects. The
# report is a page for people, in which the effect is switched on and off. What the sentences of the summary mean stands
# in [how to read a diagnosis](../diagnosis.md).

found = diagnose(model, log, MujocoPlant(robot))
print(found.summary)
found.plot().savefig("ladder.svg")
found.report(model, log, "report.html")
named = {finding.effect: finding.values for finding in found.findings}
assert abs(named["offset:steer"]["value"] - 0.06) < 0.01

# `apply` puts the findings into the equations. The same drive is predicted better (a fit of 100 % is perfect, 0 no
# better than the mean of the log), and MPPI with this model steers against the offset.

informed = found.apply(model)
log.plot(before=model, after=informed).savefig("measured_and_predicted.svg")
print("fit before, %:", {name: round(fit) for name, fit in model.score(log).items()})
print("fit after, %: ", {name: round(fit) for name, fit in informed.score(log).items()})
for name, equations in (("before", model), ("after", informed)):
    drive = run_episode(real, MPPI(compile_model(equations), robot, task), task, steps=100 if SHORT else 300)
    off = np.hypot(drive.column("x") - drive.extra["ref_x"], drive.column("y") - drive.extra["ref_y"])
    drive.plot().savefig(f"drive_{name}.svg")
    print(f"distance from the path, {name}: {100 * off[len(off) // 2 :].mean():.1f} cm")
