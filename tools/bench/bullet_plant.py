"""Bullet's rigid bodies as a plant: a hexarotor whose six motors are commanded, with what is hidden in it.

E. Coumans, Y. Bai, "PyBullet, a Python module for physics simulation", pybullet.org. Where its rotors stand, and what
they push, is the MJCF's; how a body moves for that is Bullet's.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
from foreign_plant import ForeignPlant

from sym2real.control.geometric_quadrotor import body_axes
from sym2real.dataset import Dataset
from sym2real.experiments.noisy_runs import noisy_runs
from sym2real.plants.mujoco_plant import compile_robot
from sym2real.robots import ROBOTS
from sym2real.robots.robot import GRAVITY
from sym2real.tasks import make_task
from sym2real.trajectory import Array

ROBOT = ROBOTS["hexarotor"]
SUBSTEPS = 20


@dataclass(frozen=True)
class Hexarotor:
    """What Bullet is told that differs from the hexarotor the base model knows.

    Args:
        load: further mass in kg.
        strength: factor on what the rotors push.
        motor: time constant of the rotors in s; 0 for none.
        drag: in N s/m.
        wind: force in N along the world's axes ``# (3,)``.
        centre: of mass from the middle of the rotors in m, level ``# (2,)``.
        late: control periods that commands take to arrive.
    """

    load: float = 0.0
    strength: float = 1.0
    motor: float = 0.0
    drag: float = 0.0
    wind: tuple[float, float, float] = (0.0, 0.0, 0.0)
    centre: tuple[float, float] = (0.0, 0.0)
    late: int = 0


class BulletPlant(ForeignPlant):
    """Bullet's body, pushed where the rotors are.

    Args:
        hexarotor: what is hidden in it.
        rng: of the sensors' noise.
    """

    def __init__(self, hexarotor: Hexarotor, rng: np.random.Generator) -> None:
        import pybullet
        from pybullet_utils.bullet_client import BulletClient

        super().__init__(ROBOT, hexarotor.late, rng)
        self._told, self._centre = hexarotor, np.array([*hexarotor.centre, 0.0])
        described = compile_robot(ROBOT)
        sites = described.site_pos[described.actuator_trnid[:, 0]]
        self._places, self._gears = sites - self._centre, described.actuator_gear * described.actuator_gainprm[:, :1]
        self._client = BulletClient(connection_mode=pybullet.DIRECT)
        self._client.setGravity(0.0, 0.0, -GRAVITY)
        self._client.setTimeStep(self.dt / SUBSTEPS)
        self._body = self._client.createMultiBody(baseMass=ROBOT.mass + hexarotor.load)
        inertia = [ROBOT.numbers[name] for name in ("jx", "jy", "jz")]
        undamped = {"linearDamping": 0.0, "angularDamping": 0.0, "jointDamping": 0.0}
        self._client.changeDynamics(self._body, -1, localInertiaDiagonal=inertia, **undamped)

    def _start(self, state: Array) -> Array:
        turned = body_axes(state[3:7])
        self._client.resetBasePositionAndOrientation(
            self._body, state[:3] + turned @ self._centre, np.roll(state[3:7], -1)
        )
        rates = turned @ state[10:]
        self._client.resetBaseVelocity(self._body, state[7:10] + np.cross(rates, turned @ self._centre), rates)
        self._pushing = ROBOT.rest.copy()
        return ROBOT.rest.copy()

    def _hold(self, action: Array) -> None:
        client, told = self._client, self._told
        part = 1.0 if told.motor == 0.0 else -np.expm1(-self.dt / SUBSTEPS / told.motor)
        for _ in range(SUBSTEPS):
            self._pushing = self._pushing + part * (np.clip(action, 0.0, 1.0) - self._pushing)
            for place, push in zip(self._places, told.strength * self._pushing[:, None] * self._gears, strict=True):
                client.applyExternalForce(self._body, -1, push[:3], place, client.LINK_FRAME)
                client.applyExternalTorque(self._body, -1, push[3:], client.LINK_FRAME)
            velocity, _ = client.getBaseVelocity(self._body)
            middle, _ = client.getBasePositionAndOrientation(self._body)
            force = np.array(told.wind) - told.drag * np.array(velocity)
            client.applyExternalForce(self._body, -1, force, middle, client.WORLD_FRAME)
            client.stepSimulation()

    def _true(self) -> Array:
        (place, attitude), (velocity, rates) = (
            self._client.getBasePositionAndOrientation(self._body),
            self._client.getBaseVelocity(self._body),
        )
        quaternion = np.r_[attitude[3], attitude[:3]] * np.sign(attitude[3])
        turned = body_axes(quaternion)
        arm = turned @ self._centre
        return np.r_[place - arm, quaternion, velocity - np.cross(rates, arm), turned.T @ np.array(rates)]


def flights_in_bullet(hexarotor: Hexarotor, seed: int) -> Dataset:
    """Circles and figures of eight of a controller that knows the plain hexarotor, with dither on its motors."""
    tasks = [make_task(name, ROBOT) for name in ("circle", "lemniscate")]
    return noisy_runs(ROBOT, tasks, seed=seed, plant=partial(BulletPlant, hexarotor))
