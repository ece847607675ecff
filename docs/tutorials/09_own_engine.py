"""# Your own regression engine

Anything with `fit(transitions, start=None) → Equations` is an engine. Here: ridge regression of every column's change
on all columns, in twenty lines.

    python docs/tutorials/09_own_engine.py
"""

import sys

import numpy as np

from sym2real import MPPI, ROBOTS, BeamSearch, Dataset, Equations, MujocoPlant, compile_model, make_task, run_episode
from sym2real.dataset import Transitions
from sym2real.regression import fit_quality

SHORT = "--short" in sys.argv


class Ridge:
    """Next state = state + linear function of state, action and a constant."""

    def __init__(self, penalty: float = 1e-6) -> None:
        self.penalty = penalty

    def fit(self, transitions: Transitions, start: Equations | None = None) -> Equations:
        known = np.column_stack([transitions.state, transitions.action, np.ones(len(transitions))])
        names = [*transitions.layouts.state, *transitions.layouts.action, "1"]
        target = transitions.next_state - transitions.state
        weights = np.linalg.solve(known.T @ known + self.penalty * np.eye(len(names)), known.T @ target)
        equations = {
            column: " + ".join([column, *(f"{w!r}*{name}" for w, name in zip(own.tolist(), names, strict=True))])
            for column, own in zip(transitions.layouts.state, weights.T, strict=True)
        }
        return Equations.parse(transitions.layouts, equations, transitions.dt)


# Two drives: one to learn from, one to test on. Transitions are all pairs of rows that follow each other.

robot = ROBOTS["mushr"]
plant, steps = MujocoPlant(robot), 150 if SHORT else 400
logs = []
for name in ("circle", "lemniscate"):
    task = make_task(name, robot)
    logs.append(run_episode(plant, MPPI(compile_model(robot.nominal()), robot, task), task, steps=steps, name=name))
learned, tested = (Dataset([log]).transitions() for log in logs)

# An engine is held against another by the error of single steps, or by `compare` over a horizon. A linear model has no
# words for a heading that turns; beam search has.

engines = {"ridge": Ridge(), "beam": BeamSearch(angles=robot.recipe.angles)}
models = {name: engine.fit(learned) for name, engine in engines.items()}
errors = {name: fit_quality(model, tested) for name, model in models.items()}
for name, columns in errors.items():
    print(name, {column: f"{error:.2g}" for column, error in columns.items()})
logs[1].plot(**models).savefig("measured_and_predicted.svg")
assert errors["beam"]["x"] < errors["ridge"]["x"]

# `learn_base(plant, tasks, Ridge())` takes it as it takes the others. What comes out is `Equations`: it compiles,
# flies, and can be diagnosed.
