"""RotorPy's quadrotor as a plant: rotors that take time, and drag that its authors modelled.

S. Folk, J. Paulos, V. Kumar, "RotorPy: A Python-based Multirotor Simulator with Aerodynamics for Education and
Research", arXiv 2306.04485. Installed with the extra ``bench``; nothing of it is in this project.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from foreign_plant import ForeignPlant, runge_kutta

from sym2real.robots import ROBOTS
from sym2real.robots.robot import GRAVITY
from sym2real.trajectory import Array

ROBOT = ROBOTS["crazyflie"]
# Our simulator's rotors answer at once; RotorPy's cannot, so they take as long as a rate loop does not notice.
QUICK = 0.004  # s
SUBSTEPS = 5
AERODYNAMICS = ("k_d", "k_z", "k_h", "k_flap", "c_Dx", "c_Dy", "c_Dz")


@dataclass(frozen=True)
class Quadrotor:
    """What RotorPy is told that differs from the Crazyflie the base model knows.

    Args:
        parameters: RotorPy's names and values.
        centre: centre of mass from the middle of the rotors in m ``# (3,)``.
        late: control periods that commands take to arrive.
        stock: all of RotorPy's own numbers of the Crazyflie instead, but for the gains of the rate loop.
    """

    parameters: Mapping[str, float] = field(default_factory=dict)
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    late: int = 0
    stock: bool = False

    def numbers(self) -> dict[str, Any]:
        """RotorPy's table of parameters."""
        from rotorpy.vehicles.crazyflie_params import quad_params

        inertia = dict(zip(("Ixx", "Iyy", "Izz"), (ROBOT.numbers[name] for name in ("jx", "jy", "jz")), strict=True))
        ours = {"mass": ROBOT.mass, "tau_m": QUICK, **inertia, **dict.fromkeys(AERODYNAMICS, 0.0)}
        gains = np.array([ROBOT.numbers[name] for name in ("kx", "ky", "kz")])
        return {**quad_params, **({} if self.stock else ours), "k_w": gains, **self.parameters}


class RotorpyPlant(ForeignPlant):
    """RotorPy's vehicle.

    Args:
        quadrotor: what is hidden in it.
        rng: of the sensors' noise.
    """

    def __init__(self, quadrotor: Quadrotor, rng: np.random.Generator) -> None:
        from rotorpy.vehicles.multirotor import Multirotor

        super().__init__(ROBOT, quadrotor.late, rng)
        self._vehicle = Multirotor(quadrotor.numbers(), control_abstraction="cmd_ctbr")
        self._vehicle.rotor_geometry = self._vehicle.rotor_geometry - np.array(quadrotor.centre)

    def _start(self, state: Array) -> Array:
        hover = np.sqrt(self._vehicle.mass * GRAVITY / 4 / self._vehicle.k_eta)
        self._state = {
            "x": state[:3].copy(),
            "q": np.r_[state[4:7], state[3]],
            "v": state[7:10].copy(),
            "w": state[10:].copy(),
            "wind": np.zeros(3),
            "rotor_speeds": np.full(4, hover),
        }
        return ROBOT.rest.copy()

    def _hold(self, action: Array) -> None:
        for _ in range(SUBSTEPS):
            self._advance({"cmd_thrust": action[0], "cmd_w": action[1:]}, self.dt / SUBSTEPS)

    def _advance(self, control: dict[str, Any], h: float) -> None:
        """One step on RotorPy's derivative; its own solver takes ten times as long."""
        vehicle = self._vehicle
        speeds = vehicle.get_cmd_motor_speeds(self._state, control)
        speeds = np.clip(speeds, vehicle.rotor_speed_min, vehicle.rotor_speed_max)
        packed = runge_kutta(lambda at: vehicle._s_dot_fn(0.0, at, speeds), vehicle._pack_state(self._state), h)
        self._state = vehicle._unpack_state(packed)
        self._state["q"] /= np.linalg.norm(self._state["q"])

    def _true(self) -> Array:
        quaternion = self._state["q"] * np.sign(self._state["q"][3])
        attitude = [quaternion[3], *quaternion[:3]]
        return np.r_[self._state["x"], attitude, self._state["v"], self._state["w"]]
