"""What every run of the standard set suffers beside its effects and noise: disturbances, trim, an ignorant analyst.

Trim differs from run to run. Some numbers of the plant differ from the nominal ones over the whole data set.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from sym2real.effects import effect
from sym2real.experiments import standard_conditions as conditions
from sym2real.experiments.excitation import ColouredNoise
from sym2real.protocols import Change
from sym2real.robots import Robot
from sym2real.tasks.task import flies

FLIGHT_TRIM = {"gain:thrust": {"value": 0.004}, "mounting_tilt": {"roll": np.deg2rad(0.1), "pitch": np.deg2rad(0.1)}}
DRIVE_TRIM = {
    "offset:steer": {"value": 0.004},
    "gain:speed": {"value": 0.004},
    "yaw_bias": {"value": np.deg2rad(0.15)},
}
UNKNOWN = 0.1
LOOP = ("wx", "wy", "wz")


def unknown(robot: Robot, rng: np.random.Generator) -> Change:
    """Numbers of the plant that the analyst's nominal has wrong, once per data set."""
    first, second = 1.0 + rng.uniform(-UNKNOWN, UNKNOWN, 2)

    def edit_flight(spec: Any) -> None:
        """Inertia, and the gain of the rate loop, which the actuators of the description hold."""
        body = spec.worldbody.first_body()
        body.inertia = first * np.array(body.inertia)
        for actuator in spec.actuators:
            if actuator.name in LOOP:
                actuator.gainprm = second * np.array(actuator.gainprm)
                actuator.biasprm = second * np.array(actuator.biasprm)

    def edit_drive(spec: Any) -> None:
        """Time constant of every contact (``solref``, s): how soft tyres and ground are."""
        for geom in spec.geoms:
            geom.solref = [first * geom.solref[0], geom.solref[1]]

    return Change("", edit=edit_flight if flies(robot) else edit_drive)


def trim(robot: Robot, rng: np.random.Generator) -> tuple[Change, ...]:
    """What differs from run to run, uniform."""
    table = FLIGHT_TRIM if flies(robot) else DRIVE_TRIM
    changes = []
    for key, widths in table.items():
        trimmed = effect(key, robot)
        drawn = {name: trimmed.null[name] + rng.uniform(-width, width) for name, width in widths.items()}
        changes.append(trimmed.inject(**drawn))
    return tuple(changes)


def disturbance(robot: Robot, rng: np.random.Generator) -> Change:
    """Force and torque on a quadrotor; noise of steering and speed on a car, behind its commands."""
    if flies(robot):
        return Change("", force=_gusts(robot, rng))
    noise = ColouredNoise(conditions.COMMANDS, conditions.COMMANDS_TIME, robot.dt, rng)
    return Change("", command=lambda: lambda action: action + noise.next())


def _gusts(robot: Robot, rng: np.random.Generator) -> Callable[[Any, Any], None]:
    """Held over a control period, which is short beside the processes' time constants."""
    force = ColouredNoise(conditions.FORCE, conditions.FORCE_TIME, robot.dt, rng)
    torque = ColouredNoise(conditions.TORQUE, conditions.TORQUE_TIME, robot.dt, rng)
    held = [force.next(), torque.next()]
    calls = 0

    def apply(_: Any, data: Any) -> None:
        """Force (N) along world axes; torque (N m) turned there from body axes, as ``xfrc_applied`` has it."""
        nonlocal calls
        calls += 1
        if calls % robot.substeps == 0:
            held[:] = force.next(), torque.next()
        data.xfrc_applied[1, :3] += held[0]
        data.xfrc_applied[1, 3:] += data.xmat[1].reshape(3, 3) @ held[1]

    return apply
