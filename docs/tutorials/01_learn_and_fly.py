"""# Learn a base model and fly it

From a robot's description to equations, and from equations to a controller. You need nothing but the package.

    python docs/tutorials/01_learn_and_fly.py
"""

import sys

import numpy as np

from sym2real import MPPI, ROBOTS, BeamSearch, MujocoPlant, StageOne, compile_model, learn_base, make_task, run_episode

SHORT = "--short" in sys.argv

# A robot is its columns, limits and description; `MujocoPlant` simulates it. Commands beyond its limits are clipped.

robot = ROBOTS["mushr"]
plant = MujocoPlant(robot)
task = make_task("circle", robot)
print(robot.title, "measures", *robot.layouts.state, "and takes", *robot.layouts.action)

# Stage I of the paper: a first episode of random commands, a fit, an episode that MPPI drives with that fit,
# another fit, and so on. Beam search is the default engine; Operon and PySR have the same interface.

settings = StageOne(episodes=2 if SHORT else 5, steps=100 if SHORT else 400, pushed=False)
base = learn_base(plant, [task], BeamSearch(angles=robot.recipe.angles), settings)

# The model is a set of equations. They print, they say what they depend on, and they predict.

print(base.text())
print("yaw rate depends on the steering:", base.depends("wz", "steer"))
print("one step from rest at 1 m/s:", base.predict(robot.start, np.array([0.1, 1.0])).round(3))

# `compile_model` makes one TorchScript module of them. MPPI rolls that out for every sample, in C where a compiler is
# there.

log = run_episode(plant, MPPI(compile_model(base), robot, task), task, steps=60 if SHORT else 400)
radius = np.hypot(log.column("x"), log.column("y"))
print(f"driven: {len(log)} rows, radius {radius.mean():.2f} m of the task's 1.50 m")
log.plot().savefig("driven.svg")
assert abs(radius.mean() - 1.5) < 0.3
