"""The simulator that a model is held against, and the logs' manoeuvres in it.

It is the plain one with the effects that the model has already: against a simulator without them, what the model knows
rightly would count as its own error. It flies along every log's reference (else along its smoothed path) with the
nominal geometric controller and the log's quick changes of command, and what was sent is sent again. The nearer of both
flights counts: a controller may drive forwards along a path that was driven in reverse, and an arm's knows one posture.
"""

import torch
from numpy.typing import ArrayLike
from scipy.ndimage import uniform_filter1d
from torch import Tensor

from sym2real.control import Disturbed, geometric_controller
from sym2real.control.logged import Replayed, path_of
from sym2real.dataset import Dataset
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects import injected
from sym2real.effects.along_logs import with_filtered_commands
from sym2real.errors import Sym2RealError
from sym2real.plants import MujocoPlant, run_episode
from sym2real.symbolic import Equations
from sym2real.tasks.task import Reference
from sym2real.trajectory import Array, Trajectory

# What a note says where the base is not calibrated.
UNCALIBRATED = "the base's own errors were not calibrated and may look like effects"
SWITCHED_OFF = f"calibration was switched off: {UNCALIBRATED}"
HEALTHY_FIRST = "diagnose logs of the healthy robot first, and put what these show into the base"
NO_SIMULATOR = f"no plain simulator: {UNCALIBRATED}; {HEALTHY_FIRST}"
NOT_FLOWN = "the logs' manoeuvres cannot be flown in the plain simulator: the base is not calibrated"
# A car's figure of eight takes 300 rows: of its first half alone the base's own errors look like an arm to one side.
# Of fast logs as long as of a quadrotor's at 50 Hz.
MOST_LOGS, MOST_ROWS, MOST_SECONDS = 8, 400, 8.0
STILL = 1e-6  # squares of a field in its unit, all rows together, of a robot that stands
QUICK = 15  # rows over which changes of a command count as quick


def with_effects_of(model: Equations, plant: MujocoPlant | None, dt: float) -> tuple[MujocoPlant | None, str]:
    """The plain simulator with a model's effects, by MuJoCo's own means, commanded every ``dt`` s where logs are slow.

    None, and why, where there is none.
    """
    if plant is None:
        return None, NO_SIMULATOR
    try:
        robot = plant.robot.at_period(dt) if dt > (1.0 + SETTINGS.same) * plant.dt else plant.robot
        return MujocoPlant(robot, (*plant.changes, *injected(model, robot)), description=plant.description), ""
    except Sym2RealError as error:
        return None, f"no simulator has all effects that the model has already ({error}): {UNCALIBRATED}"


def flown_along(model: Equations, plant: MujocoPlant, logs: Dataset) -> tuple[Dataset | None, str]:
    """The logs' manoeuvres in the simulator, commands as they reach the robot; None, and why, where none can be flown.

    Args:
        model: whose command filters the simulator has too.
        plant: of :func:`with_effects_of`.
        logs: whose manoeuvres are flown.
    """
    try:
        flights = [_flight(plant, log) for log in list(logs)[:MOST_LOGS]]
    except Sym2RealError as error:  # nothing holds it where it starts
        return None, f"{NOT_FLOWN} ({error})"
    long_enough = [flight for flight in flights if len(flight) >= SETTINGS.base_rows]
    return (with_filtered_commands(model, Dataset(long_enough)), "") if long_enough else (None, NOT_FLOWN)


def fly(
    plant: MujocoPlant, reference: Reference, dither: Array, *, start: ArrayLike | None = None, name: str = ""
) -> Trajectory:
    """A path in the simulator, by the nominal geometric controller, until its end or a crash.

    Args:
        plant: the plain simulator.
        reference: states of the path at times in s ``# (..., state)``.
        dither: on the commands, by row ``# (rows, action)``.
        start: first state; that of the path by default ``# (state,)``.
        name: of the trajectory.
    """
    robot = plant.robot
    dithered = Disturbed(geometric_controller(robot, reference), lambda step: dither[step], robot.low, robot.high)
    first = reference(torch.zeros((), dtype=torch.float64)).numpy() if start is None else start
    return run_episode(plant, dithered, start=first, steps=len(dither), name=name)


def _flight(plant: MujocoPlant, log: Trajectory) -> Trajectory:
    path = path_of(log)

    def reference(time: Tensor) -> Tensor:
        rows = (time / log.dt).clamp(0, len(path) - 1)
        low = rows.floor().long().clamp(max=len(path) - 2)
        return log.layouts.state.normalise(torch.lerp(path[low], path[low + 1], (rows - low)[..., None]))

    rows = max(MOST_ROWS, round(MOST_SECONDS / log.dt))
    dither = (log.action - uniform_filter1d(log.action, QUICK, axis=0, mode="nearest"))[:rows]
    flown = fly(plant, reference, dither, start=log.state[0], name=log.name)
    if plant.crashed:  # no base describes the second that leads to it, of a robot on wheels that tips over
        flown = flown.rows(0, max(1, len(flown) - round(1.0 / plant.dt)))
    again = run_episode(plant, Replayed(log.action[:rows]), start=log.state[0], name=log.name, steps=len(dither))
    near = len(flown) < SETTINGS.base_rows or _astray(again, log) < _astray(flown, log)
    return again if near and not plant.crashed else flown


def _astray(flown: Trajectory, log: Trajectory) -> float:
    """Squares of how far a flight is off a log, over those of the log about its mean: the mean of what is measured."""
    layout, own = log.layouts.state, torch.as_tensor(log.state[: len(flown)])
    apart = layout.difference(torch.as_tensor(flown.state), own).square().sum(0)
    spread = layout.difference(own, layout.normalise(own.mean(0)).expand_as(own)).square().sum(0)
    shown = zip(layout.fields, layout.tangent_places, strict=True)
    parts = [apart[where].sum() / spread[where].sum().clamp_min(STILL) for field, where in shown if not field.hidden]
    return float(torch.stack(parts).mean())
