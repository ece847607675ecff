"""What a target can have beside the catalogue's effects: noise, latency, and what no effect covers, by MuJoCo's means.

A mechanism is a function of the robot, a generator of random numbers and its own numbers, and gives a change.
"""

import inspect
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from sym2real.effects.truth import ACTUATORS
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
        for actuator in spec.actuators:
            actuator.delay += value
            actuator.nsample = int(np.ceil(actuator.delay / spec.option.timestep)) + 2

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
# What only a robot with these columns can have.
NEEDS = {"swinging_payload": ("thrust",), "speed_loop_windup": ("speed",)}


def require_mechanism(name: str, robot: Robot, values: Mapping[str, float]) -> None:
    """Refuse a mechanism that a robot cannot be given.

    Raises:
        UnknownNameError: for one that does not exist.
        ModelError: for a robot that lacks what it changes, and for other numbers than it has.
    """
    wanted = set(list(inspect.signature(MECHANISMS[name]).parameters)[2:])
    if wanted != set(values):
        shown = [", ".join(sorted(names)) or "none" for names in (wanted, set(values))]
        raise ModelError(f"{name}: expected the numbers {shown[0]}, found {shown[1]}")
    missing = [column for column in NEEDS.get(name, ()) if column not in robot.layouts.action]
    if missing:
        raise ModelError(f"{name}: expected a robot with the command {missing[0]}, found {robot.name}")
    for key, value in values.items():
        if not value > 0:
            raise ModelError(f"{name}: expected {key} > 0, found {value!r}")
