"""What the base model itself gets wrong about the plain simulator: the origin from which effects are counted.

A learned base is 1 or 2 % wrong, enough to look like an effect. So the plain simulator flies along every log's
reference (else along its smoothed path) with the nominal geometric controller, as noisy as the log, and the same
estimator says which effects would explain the base's own errors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor

from sym2real.control import GeometricQuadrotor, PurePursuit
from sym2real.diagnosis.candidates import Candidate
from sym2real.diagnosis.fit import Problems
from sym2real.diagnosis.leftover import find_leftover
from sym2real.diagnosis.segments import component_noise
from sym2real.diagnosis.select import Selection
from sym2real.diagnosis.sensitivity import Library, Problem
from sym2real.diagnosis.start import noise_level
from sym2real.diagnosis.whitening import Spread, Whitening
from sym2real.plants import MujocoPlant, run_episode
from sym2real.protocols import Controller
from sym2real.trajectory import Array, Dataset, Trajectory

MOST_LOGS, MOST_ROWS, FEWEST_ROWS = 8, 400, 100
GAIN, MOST_EFFECTS, REFITTED = 0.003, 6, 3
SMOOTHING = 9


class _Dithered:
    """A controller with white noise on its commands, as the log's commands have."""

    def __init__(self, controller: Controller, deviation: Array, rng: np.random.Generator, low: Array, high: Array):
        self.controller, self.deviation, self.rng, self.low, self.high = controller, deviation, rng, low, high

    def reset(self) -> None:
        self.controller.reset()

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        noise = self.deviation * self.rng.standard_normal(len(self.deviation))
        action: Array = np.clip(self.controller.act(state, step, inputs) + noise, self.low, self.high)
        return action

    def remember(self, sent: ArrayLike) -> None:
        self.controller.remember(sent)


def simulated(plant: MujocoPlant, data: Dataset, seed: int = 0) -> Dataset | None:
    """The logs' manoeuvres in the plain simulator, with their noise; None where none of them can be flown."""
    rng = np.random.default_rng(seed)
    noise = component_noise(data)
    flights = [_flight(plant, trajectory, noise, rng) for trajectory in list(data)[:MOST_LOGS]]
    long_enough = [flight for flight in flights if len(flight) >= FEWEST_ROWS]
    return Dataset(long_enough) if long_enough else None


def _flight(plant: MujocoPlant, log: Trajectory, noise: Array, rng: np.random.Generator) -> Trajectory:
    robot, path = plant.robot, reference_of(log)
    steps = min(len(log), MOST_ROWS)

    def reference(time: Tensor) -> Tensor:
        rows = (time / log.dt).clamp(0, len(path) - 1)
        low = rows.floor().long().clamp(max=len(path) - 2)
        part = (rows - low)[..., None]
        blended = (1 - part) * path[low] + part * path[low + 1]
        return robot.layouts.state.normalise(blended)

    deviation = noise_level(log.action)
    controller: Controller
    if robot.layouts.state.has_field("attitude"):
        controller = GeometricQuadrotor(robot.mass, robot.low, robot.high, robot.dt, reference)
    else:
        controller = PurePursuit(robot.constants["wheelbase"], robot.low, robot.high, robot.dt, reference)
    dithered = _Dithered(controller, deviation, rng, robot.low, robot.high)
    flown = run_episode(plant, dithered, start=log.state[0], steps=steps, name=log.name)
    tangent = rng.standard_normal((len(flown), len(noise))) * noise
    state = robot.layouts.state.retract(torch.as_tensor(flown.state), torch.as_tensor(tangent)).numpy()
    return replace(flown, state=state)


def reference_of(log: Trajectory) -> Tensor:
    """Full reference state along a log ``# (rows, state)``: its columns ``ref_…``, the smoothed path for the others."""
    layout = log.layouts.state
    kernel = np.ones(SMOOTHING) / SMOOTHING
    padded = np.pad(log.state, ((SMOOTHING // 2, SMOOTHING // 2), (0, 0)), mode="edge")
    path = np.stack([np.convolve(column, kernel, "valid") for column in padded.T], axis=1)
    if all(f"ref_{c}" in log.extra for c in layout.field("position").columns):
        for column in layout:
            place = layout.index(column)
            if f"ref_{column}" in log.extra:
                path[:, place] = log.extra[f"ref_{column}"]
            elif column[1:] in layout.field("position").columns and column.startswith("v"):
                path[:, place] = np.gradient(log.extra[f"ref_{column[1:]}"], log.time)
    return layout.normalise(torch.as_tensor(path))


def origin(
    library: Library, candidates: Sequence[Candidate], data: Dataset, variances: Whitening
) -> tuple[Tensor, set[str]]:
    """Parameter set ``# (P,)`` that explains the base's errors on the plain simulator's data, and what it leaves.

    The latter are channels of pushes that still depend on something there: the base's own fault, not an effect.

    Args:
        library: effects in the base's equations.
        candidates: what may explain them.
        data: of :func:`simulated`.
        variances: of the logs' whitening, so that errors weigh here as they weigh there.
    """
    problem = Problem(library, data)
    spread = Spread.of(problem, library.null)
    sizes = spread.sizes
    power = torch.tensor([variances.pushes[name] for name in spread.names], dtype=torch.float64) / sizes
    whitening = spread.whitening(variances.sensor.square(), power.square())
    selection = Selection(Problems.of(problem, whitening), candidates, library.null)
    selection.grow(least=GAIN, most=MOST_EFFECTS, tested=False, refitted=REFITTED)
    left: set[str] = set()
    while found := find_leftover(problem, spread, whitening, selection.fit.values, left):
        left.add(found.channel)
    return selection.fit.values, left
