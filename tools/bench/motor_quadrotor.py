"""A Crazyflie whose four rotors are bodies in MuJoCo that spin, driven to their speeds by servos.

Every rotor has a hinge, an inertia about it and a velocity servo; air pushes it along the body's z axis by k ω² and
brakes it by κ k ω². What the servo gives reacts on the body: drag torque and the reaction to a change of speed come out
of MuJoCo's own dynamics.
"""

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import mujoco
import numpy as np
import torch
from numpy.typing import ArrayLike

from sym2real.experiments.excitation import ColouredNoise
from sym2real.layout import Layout
from sym2real.protocols import Change, Controller, Filter
from sym2real.robots import CRAZYFLIE, Robot
from sym2real.robots.crazyflie import ARM, HOVER, INERTIA, MASS, ROTOR_THRUST, TORQUE_PER_THRUST
from sym2real.trajectory import Array
from sym2real.vocabulary import MOTORS

DT, PHYSICS_DT = 0.01, 0.001  # s
FASTEST = 2600.0  # rad/s
FRONT, LEFT, SPIN = np.array([1, -1, -1, 1]), np.array([-1, -1, 1, 1]), np.array([-1, 1, -1, 1])
PLACES = ARM / np.sqrt(2.0) * np.stack([FRONT, LEFT, np.zeros(4)], axis=1)
ROTOR_MASS = 1e-4  # kg
SERVO = 0.005  # s, time constant of a rotor's speed
RATE_GAINS = np.array([18.0, 18.0, 8.0])  # 1/s, of the loop on board
# Thrust in N and torque in N m of four forces in N.
MIXER = np.stack([np.ones(4), PLACES[:, 1], -PLACES[:, 0], TORQUE_PER_THRUST * SPIN])
POSITION_NOISE, ANGLE_NOISE, RATE_NOISE = 1e-3, float(np.deg2rad(0.2)), 0.02  # m, rad, rad/s
VELOCITY_ERROR, ERROR_TIME = 0.01, 0.1  # m/s and s: of an estimator, which forgets its errors slowly


def robot(inertia: float, servo: float = SERVO) -> Robot:
    """The Crazyflie commanded by rotor speeds in rad/s at 100 Hz.

    Args:
        inertia: of a rotor about its axis in kg m².
        servo: time constant of its speed in s.
    """
    hover = float(np.sqrt(HOVER / 4 / ROTOR_THRUST))
    return replace(
        CRAZYFLIE,
        layouts=replace(CRAZYFLIE.layouts, action=Layout.of(MOTORS)),
        dt=DT,
        limits=replace(
            CRAZYFLIE.limits,
            low=np.zeros(4),
            high=np.full(4, FASTEST),
            draws=(np.full(4, 0.5 * hover), np.full(4, 1.5 * hover)),
        ),
        description=replace(
            CRAZYFLIE.description,
            physics_dt=PHYSICS_DT,
            rest=np.full(4, hover),
            to_control=partial(_servo_command, gain=inertia / servo),
        ),
    )


def _servo_command(speeds: Array, gain: float) -> Array:
    """What the servos are told so that they stand at these speeds although the air brakes ``# (..., 4)``, rad/s."""
    return -SPIN * (speeds + TORQUE_PER_THRUST * ROTOR_THRUST * speeds**2 / gain)


@dataclass
class Rotors:
    """The rotors as a change of the description; it keeps the speeds of every physics step.

    Args:
        inertia, servo: as of :func:`robot`.
    """

    inertia: float
    servo: float = SERVO
    speeds: list[Array] = field(default_factory=list)
    _wanted: Array = field(default_factory=lambda: np.zeros(4))

    @property
    def change(self) -> Change:
        """For a :class:`~sym2real.plants.MujocoPlant`, ahead of all others."""
        return Change("", edit=self._edit, force=self._push, command=self._begin)

    def _edit(self, spec: Any) -> None:
        for actuator in list(spec.actuators):
            spec.delete(actuator)
        spec.option.timestep = PHYSICS_DT
        body, gain = spec.worldbody.first_body(), self.inertia / self.servo
        # Rotors as points, of which the whole keeps mass and inertia.
        body.mass = MASS - 4 * ROTOR_MASS
        body.inertia = np.array(INERTIA) - ROTOR_MASS * (PLACES[:, [1, 0]] ** 2).sum(0).tolist()[0] * np.array(
            [1, 1, 2]
        )
        for number, place in enumerate(PLACES, 1):
            rotor = body.add_body(name=f"rotor{number}", pos=place)
            rotor.explicitinertial, rotor.ipos = True, np.zeros(3)
            rotor.mass, rotor.inertia = ROTOR_MASS, self.inertia * np.array([0.5, 0.5, 1.0])
            hinge = rotor.add_joint(name=f"spin{number}", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1])
            servo = spec.add_actuator(name=f"servo{number}", target=hinge.name)
            servo.trntype, servo.biastype = mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtBias.mjBIAS_AFFINE
            servo.gainprm, servo.biasprm = [gain, *([0.0] * 9)], [0.0, 0.0, -gain, *([0.0] * 7)]

    def _begin(self) -> Filter:
        self.speeds.clear()

        def note(action: Array) -> Array:
            self._wanted = action
            return action

        return note

    def _push(self, model: Any, data: Any) -> None:
        if data.time == 0.0:
            data.qvel[6:10] = -SPIN * self._wanted
        speeds = np.abs(data.qvel[6:10])
        self.speeds.append(speeds)
        lift = ROTOR_THRUST * speeds**2
        axis = data.xmat[1].reshape(3, 3)[:, 2]
        for rotor in range(4):
            data.xfrc_applied[2 + rotor, :3] += lift[rotor] * axis
            data.xfrc_applied[2 + rotor, 3:] += SPIN[rotor] * TORQUE_PER_THRUST * lift[rotor] * axis

    def measured(self, rows: int) -> Array:
        """Mean speeds of every control period, as tachometers report them ``# (rows, 4)``, rad/s."""
        steps = round(DT / PHYSICS_DT)
        return np.array(self.speeds[: rows * steps]).reshape(rows, steps, 4).mean(axis=1)


@dataclass
class OnMotors:
    """A controller of thrust and body rates on a rate loop and a mixer, with dither on the rotor speeds.

    Args:
        inner: gives thrust in N and rates in rad/s.
        dither: added to the speeds, rad/s.
    """

    inner: Controller
    dither: ColouredNoise

    def reset(self) -> None:
        """Forget as the inner controller does; the dither goes on."""
        self.inner.reset()

    def remember(self, sent: ArrayLike) -> None:
        """Rotor speeds tell the inner controller nothing."""

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """Rotor speeds ``# (4,)``, rad/s."""
        measured = np.asarray(state, dtype=np.float64)
        thrust, *rates = self.inner.act(measured, step)
        torque = np.array(INERTIA) * RATE_GAINS * (np.array(rates) - measured[10:13])
        forces = np.linalg.solve(MIXER, [thrust, *torque])
        speeds = np.sqrt(np.maximum(forces, 0.0) / ROTOR_THRUST) + self.dither.next()
        return np.clip(speeds, 0.0, FASTEST)


def estimated(rng: np.random.Generator) -> Change:
    """What an estimator on board reports: white noise of pose and gyro, velocities whose errors last."""
    layout = CRAZYFLIE.layouts.state
    white = {"position": POSITION_NOISE, "attitude": ANGLE_NOISE, "rate": RATE_NOISE}
    deviation = np.concatenate([np.full(one.tangent_size, white.get(one.name, 0.0)) for one in layout.fields])

    def begin() -> Filter:
        slow = ColouredNoise(np.full(3, VELOCITY_ERROR), ERROR_TIME, DT, rng)

        def measure(state: Array) -> Array:
            """The reported state ``# (state,)``."""
            tangent = torch.as_tensor(deviation * rng.standard_normal(len(deviation)))
            reported: Array = layout.retract(torch.as_tensor(state), tangent).numpy()
            reported[layout.slice("velocity")] += slow.next()
            return reported

        return measure

    return Change("", measure=begin)
