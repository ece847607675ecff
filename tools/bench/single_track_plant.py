"""CommonRoad's single-track car with sliding tyres as a plant: what a bicycle without slip has to be corrected to.

M. Althoff, G. Würsching, "CommonRoad: Vehicle Models", TU Munich 2020. Installed with the extra ``bench``; nothing of
it is in this project. The numbers of the car are those of the MuSHR class, the tyres those of CommonRoad.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from foreign_plant import ForeignPlant, runge_kutta

from sym2real.robots import ROBOTS
from sym2real.trajectory import Array

ROBOT = ROBOTS["mushr"]
WHEELBASE = ROBOT.constants["wheelbase"]
GRIP, STIFFNESS = 1.0489, 21.92  # CommonRoad: p_dy1, -p_ky1
STEP = 0.002  # s
NO_LIMIT = 20.0


@dataclass(frozen=True)
class Car:
    """What the car has that a bicycle has not.

    Args:
        offset: added to the steering command, rad.
        steering: factor of the steering command.
        speed: factor of the speed command.
        servo: time constant of the steering in s.
        motor: time constant of the speed in s.
        late: control periods that commands take to arrive.
    """

    offset: float = 0.0
    steering: float = 1.0
    speed: float = 1.0
    servo: float = 0.02
    motor: float = 0.06
    late: int = 0


class SingleTrackPlant(ForeignPlant):
    """CommonRoad's model, whose place is the centre of mass.

    Args:
        car: what is hidden in it.
        rng: of the sensors' noise.
    """

    def __init__(self, car: Car, rng: np.random.Generator) -> None:
        super().__init__(ROBOT, car.late, rng)
        self._car, self._numbers = car, _numbers()

    def _start(self, state: Array) -> Array:
        x, y, sine, cosine, vx, vy, rate = state
        speed = np.hypot(vx, vy)
        # place, steering angle, speed, yaw, yaw rate, slip angle
        self._state = np.array([x, y, 0.0, speed, np.arctan2(sine, cosine), rate, 0.0])
        return np.array([0.0, speed])

    def _hold(self, action: Array) -> None:
        steer, speed = self._car.steering * action[0] + self._car.offset, self._car.speed * action[1]
        for _ in range(round(self.dt / STEP)):
            self._advance(steer, speed)

    def _advance(self, steer: float, speed: float) -> None:
        from vehiclemodels.vehicle_dynamics_st import vehicle_dynamics_st

        def slope(state: Array) -> Array:
            turning = (steer - state[2]) / self._car.servo
            return np.array(vehicle_dynamics_st(state, [turning, (speed - state[3]) / self._car.motor], self._numbers))

        self._state = runge_kutta(slope, self._state, STEP)

    def _true(self) -> Array:
        x, y, _, speed, yaw, rate, slip = self._state
        velocity = speed * np.cos(yaw + slip), speed * np.sin(yaw + slip)
        return np.array([x, y, np.sin(yaw), np.cos(yaw), *velocity, rate])


def _numbers() -> SimpleNamespace:
    """CommonRoad's parameter object with this car's numbers; its limits of steering and motor are not met."""
    half = WHEELBASE / 2
    limits = {"v_min": -NO_LIMIT, "v_max": NO_LIMIT, "v_switch": NO_LIMIT, "a_max": 3 * NO_LIMIT}
    return SimpleNamespace(
        tire=SimpleNamespace(p_dy1=GRIP, p_ky1=-STIFFNESS),
        a=half,
        b=half,
        h_s=0.05,
        m=ROBOT.mass,
        I_z=ROBOT.constants["jz"],
        steering=SimpleNamespace(min=-0.6, max=0.6, v_min=-NO_LIMIT, v_max=NO_LIMIT),
        longitudinal=SimpleNamespace(**limits),
    )
