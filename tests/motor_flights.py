"""Flights of a Crazyflie whose four motors are MuJoCo's own actuators, as a log of motor commands would hold them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from sym2real.control.geometric_quadrotor import Gains, GeometricQuadrotor
from sym2real.dataset import Dataset
from sym2real.effects import effect
from sym2real.experiments import standard_conditions
from sym2real.experiments.excitation import ColouredNoise
from sym2real.layout import Layout
from sym2real.plants import MujocoPlant, run_episode
from sym2real.plants.mujoco_plant import edited
from sym2real.robots import CRAZYFLIE, Motors, quadrotor
from sym2real.robots.crazyflie import ARM, INERTIA, MASS, ROTOR_THRUST, TORQUE_PER_THRUST
from sym2real.robots.motors import MotorUnit
from sym2real.symbolic import Equations
from sym2real.tasks import make_task
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import MOTORS

FAST, EVERY = 0.01, 2  # control period in s, and rows of it to one of the log
THRUST = 0.15  # N of one rotor at full command
ANGLES = np.deg2rad([-45.0, -135.0, 135.0, 45.0])  # front right, back right, back left, front left
REACTION = np.array([-1.0, 1.0, -1.0, 1.0])
PLACES = ARM * np.stack([np.cos(ANGLES), np.sin(ANGLES), 0 * ANGLES], axis=1)
# Thrust in N and torque in N m of commands 0 to 1: MuJoCo's moments of four forces at four sites.
MIXER = THRUST * np.stack([np.ones(4), PLACES[:, 1], -PLACES[:, 0], TORQUE_PER_THRUST * REACTION])
RATE_GAINS = np.array([18.0, 18.0, 8.0])

ROBOT = replace(
    CRAZYFLIE,
    layouts=replace(CRAZYFLIE.layouts, action=Layout.of(MOTORS)),
    dt=FAST,
    limits=replace(CRAZYFLIE.limits, low=np.zeros(4), high=np.ones(4), draws=None),
    description=replace(CRAZYFLIE.description, rest=np.full(4, MASS * 9.81 / 4 / THRUST)),
)
# The same at the log's period, told the speed of every rotor in rad/s.
SPINNING = replace(
    ROBOT,
    dt=FAST * EVERY,
    limits=replace(ROBOT.limits, high=np.full(4, np.sqrt(THRUST / ROTOR_THRUST))),
    description=replace(ROBOT.description, to_control=lambda speeds: speeds**2 * ROTOR_THRUST / THRUST),
)


def equations(
    spin: Sequence[int] = (-1, 1, -1, 1), unit: MotorUnit = "command", every: int = EVERY, inertia: float = 1.0
) -> Equations:
    """What an analyst knows of it, whose motors are told a part of full command or have their speeds measured.

    ``inertia`` is what the analyst takes for the moments of inertia, by the true ones.
    """
    thrust = THRUST if unit == "command" else ROTOR_THRUST
    motors = Motors(thrust, unit, torque_per_thrust=TORQUE_PER_THRUST, arm=ARM, spin=tuple(spin))
    return quadrotor(
        MASS, tuple(inertia * moment for moment in INERTIA), interface="motors", motors=motors, dt=FAST * every
    )


def with_speeds(data: Dataset) -> Dataset:
    """Logs with rotor speeds in rad/s in the place of commands."""
    return Dataset(replace(log, action=np.sqrt(log.action * THRUST / ROTOR_THRUST)) for log in data)


def description(
    lag: float = 0.0, strength: Sequence[float] = (1.0,) * 4, spin: Sequence[float] = (-1.0, 1.0, -1.0, 1.0)
) -> str:
    """The Crazyflie's, with a thruster at each rotor in place of thrust and rate loop."""
    spec = edited(CRAZYFLIE)
    for actuator in list(spec.actuators):
        spec.delete(actuator)
    body = spec.worldbody.first_body()
    for number, (place, part, way) in enumerate(zip(PLACES, strength, spin, strict=True), 1):
        site = body.add_site(name=f"rotor{number}", pos=place)
        rotor = spec.add_actuator(name=f"motor{number}", target=site.name)
        rotor.trntype = mujoco.mjtTrn.mjTRN_SITE
        rotor.gear = [0, 0, 1, 0, 0, TORQUE_PER_THRUST * way]
        rotor.gainprm = [THRUST * part, *([0.0] * 9)]
        rotor.ctrllimited, rotor.ctrlrange = True, [0.0, 1.0]
        if lag:
            rotor.dyntype = mujoco.mjtDyn.mjDYN_FILTER
            rotor.dynprm = [lag, *([0.0] * 9)]
    text: str = spec.to_xml()
    return text


@dataclass
class Mixed:
    """A geometric controller, a rate loop and a mixer, which knows how the rotors turn; with dither on the motors."""

    outer: GeometricQuadrotor
    inverse: Array
    dither: ColouredNoise

    def reset(self) -> None:
        """Forget as the outer loop does; the dither goes on."""
        self.outer.reset()

    def remember(self, sent: ArrayLike) -> None:
        """What was sent is the outer loop's to note."""
        self.outer.remember(sent)

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        measured = np.asarray(state, dtype=np.float64)
        thrust, *wanted = self.outer.act(measured, step)
        torque = np.array(INERTIA) * RATE_GAINS * (np.array(wanted) - measured[10:13])
        clipped: Array = np.clip(self.inverse @ [thrust, *torque] + self.dither.next(), 0.0, 1.0)
        return clipped


def motor_flights(
    *,
    lag: float = 0.0,
    com: Sequence[float] = (),
    strength: Sequence[float] = (1.0, 1.0, 1.0, 1.0),
    spin: Sequence[float] = (-1.0, 1.0, -1.0, 1.0),
    dither: float = 0.01,
    names: Sequence[str] = ("hover", "circle", "lemniscate"),
    seconds: float = 8.0,
    seed: int = 0,
    hidden: Mapping[str, Mapping[str, float]] | None = None,
    every: int = EVERY,
    period: float = FAST,
) -> Dataset:
    """Flights with the sensors' noise and small pushes; motor1 to motor4 as the model counts them.

    Args:
        lag: time constant of the rotors in s.
        com: centre of mass in m.
        strength: part of its thrust that every rotor gives.
        spin: sign of every rotor's reaction torque.
        dither: on the motors, part of full command.
        hidden: further effects that the simulated robot has, by key.
        every: control periods to one row of the log; of more than one the log holds every so many commands only.
        period: of control in s.
    """
    hidden = {**(hidden or {}), **({"com_offset": dict(zip(("rx", "ry", "rz"), com, strict=True))} if com else {})}
    changes = [effect(key, ROBOT).inject(**values) for key, values in hidden.items()]
    robot, flown = replace(ROBOT, dt=period), []
    for number, name in enumerate(names):
        rng, task = np.random.default_rng([seed, number]), make_task(name, CRAZYFLIE)
        plant = MujocoPlant(
            robot, [*changes, standard_conditions.sensors(robot, rng)], description=description(lag, strength, spin)
        )
        outer = GeometricQuadrotor(
            MASS,
            CRAZYFLIE.low,
            CRAZYFLIE.high,
            period,
            task.reference,
            0.5,
            Gains(position=4.0, velocity=3.5, attitude=7.0),
        )
        mixer = MIXER.copy()
        mixer[3] = THRUST * TORQUE_PER_THRUST * np.array(spin)
        noise = ColouredNoise(np.full(4, dither), 0.03, period, rng)
        push = ColouredNoise(np.array([1.5e-3, 1.5e-3, 1e-3, 1e-6, 1e-6, 1e-6]), 0.2, period, rng)
        steps = round(seconds / period)
        log = run_episode(
            plant, Mixed(outer, np.linalg.inv(mixer), noise), task, steps=steps, seed=number,
            wrench=np.array([push.next() for _ in range(steps)]), name=f"{name} {number}",
        )  # fmt: skip
        assert len(log) == steps
        flown.append(thinned(log, every))
    return Dataset(flown)


def thinned(log: Trajectory, every: int) -> Trajectory:
    """Every so many rows, without what nobody could have logged."""
    rows = slice(None, None, every)
    extra = {name: values[rows] for name, values in log.extra.items()}
    inputs = np.zeros_like(log.inputs[rows])
    return replace(log, time=log.time[rows], state=log.state[rows], action=log.action[rows], inputs=inputs, extra=extra)


def reordered(data: Dataset, order: Sequence[int]) -> Dataset:
    """Logs whose column i holds what the model's motor ``order[i]`` got."""
    return Dataset(replace(log, action=log.action[:, list(order)]) for log in data)
