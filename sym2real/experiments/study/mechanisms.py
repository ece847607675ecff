"""What a target can have beside the catalogue's effects: noise, latency, and what no effect covers, by MuJoCo's means.

A mechanism is a function of the robot, a generator of random numbers and its own numbers, and gives a change.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from sym2real.effects.truth import ACTUATORS, delay
from sym2real.errors import ModelError
from sym2real.experiments.standard_conditions import sensors
from sym2real.protocols import Change
from sym2real.registry import Registry
from sym2real.robots import Robot

BALL = 1  # mujoco.mjtJoint.mjJNT_BALL
INTEGRATOR, LIMITED = 1, 1  # mujoco.mjtDyn.mjDYN_INTEGRATOR, mujoco.mjtLimited.mjLIMITED_TRUE


def sensor_noise(robot: Robot, rng: np.random.Generator) -> Change:
    """Motion capture and gyroscope of the standard set; velocity by differences of measured positions."""
    return sensors(robot, rng)


def latency(robot: Robot, rng: np.random.Generator, value: float) -> Change:
    """Every control acts ``value`` s late, by MuJoCo's delayed controls: its own rollouts know what is under way."""

    def edit(spec: Any) -> None:
        delay(spec, spec.actuators, value)

    return Change(f"latency {value:g} s", edit=edit)


def swinging_payload(robot: Robot, rng: np.random.Generator, mass: float, length: float) -> Change:
    """A weight of ``mass`` kg on a rod of ``length`` m below the body's origin, free to swing: a spherical pendulum."""

    def edit(spec: Any) -> None:
        load = spec.worldbody.first_body().add_body(name="payload")
        joint = load.add_joint(name="payload")
        joint.type = type(joint.type)(BALL)
        load.explicitinertial = True
        load.mass, load.ipos = mass, [0.0, 0.0, -length]
        load.inertia = [0.4 * mass * (0.1 * length) ** 2] * 3  # a ball of a tenth of the rod

    return Change(f"{1e3 * mass:g} g swing on {length:g} m", edit=edit)


def speed_loop_windup(robot: Robot, rng: np.random.Generator, gain: float, torque: float) -> Change:
    """Wheels driven by an integrating speed loop whose integral goes on while the motor gives all it can.

    I-P control: τ = gain·∫(ω_cmd - ω) dt - k_v ω, |τ| ≤ ``torque`` N m; ``gain`` in N m/rad, k_v the plain servo's.
    The activation of MuJoCo's integrator is ∫ω_cmd dt, and the actuator's length is ∫ω dt.
    """

    if "speed" not in robot.layouts.action:
        raise ModelError(f"speed_loop_windup: expected a robot with the command speed, found {robot.name}")

    def edit(spec: Any) -> None:
        for actuator in spec.actuators:
            if actuator.name in ACTUATORS["speed"]:
                actuator.dyntype = type(actuator.dyntype)(INTEGRATOR)
                actuator.biasprm[1] = -gain
                actuator.gainprm[0] = gain
                actuator.forcelimited = LIMITED
                actuator.forcerange = [-torque, torque]

    return Change(f"speed loop with wind-up, {gain:g} N m/rad, {torque:g} N m", edit=edit)


MECHANISMS: Registry[Callable[..., Change]] = Registry(
    "mechanism",
    {
        "sensor_noise": sensor_noise,
        "latency": latency,
        "swinging_payload": swinging_payload,
        "speed_loop_windup": speed_loop_windup,
    },
)
