"""highway-env's dynamical bicycle as a plant: a road car whose tyres push sideways by their slip angle alone.

E. Leurent, "An Environment for Autonomous Driving Decision-Making", 2018; its equations are those of R. Rajamani,
Vehicle Dynamics and Control, ch. 2. Installed with the extra ``bench``; nothing of it is in this project. Commands are
drawn, not tracked: levels of speed and steering for every run, and coloured noise about them.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from drawn_drives import ROBOT, drawn_drives
from foreign_plant import ForeignPlant

from sym2real.dataset import Dataset
from sym2real.trajectory import Array

WHEELBASE = 5.0  # m, highway-env's
STIFFNESS = 15.0  # highway-env's, of one tyre per mass of the car: m/s² a rad
STEP = 0.005  # s
# Of the runs: levels of speed (m/s) and steering (rad), deviation of steering and speed about them.
SPEEDS, STEERING = (4.0, 6.0, 8.0, 10.0), (-0.08, 0.08)
DEVIATION = (0.06, 0.8)


@dataclass(frozen=True)
class Tyres:
    """What the car rolls on, as multiples of highway-env's stiffness.

    Args:
        front, rear: of either axle.
        motor: time constant of the speed in s.
    """

    front: float = 1.0
    rear: float = 1.0
    motor: float = 0.1

    @property
    def slip(self) -> float:
        """Slip angle of the rear axle per lateral acceleration in rad s²/m: it carries half the mass on two tyres."""
        return 0.5 / (2 * STIFFNESS * self.rear)

    @property
    def understeer(self) -> float:
        """What the front axle slips more than that, rad s²/m."""
        return 0.5 / (2 * STIFFNESS * self.front) - self.slip

    @property
    def truth(self) -> dict[str, dict[str, float]]:
        """What the car is in the catalogue's terms: effects with their values."""
        truth = {
            "lever_arm": {"rx": WHEELBASE / 2},
            "lag:speed": {"value": self.motor},
            "tyre_slip": {"value": self.slip},
        }
        return {**truth, "understeer": {"value": self.understeer}} if self.understeer else truth


class HighwayPlant(ForeignPlant):
    """highway-env's model, whose place is the centre of mass.

    Args:
        tyres: what is hidden in it.
        rng: of the sensors' noise.
    """

    def __init__(self, tyres: Tyres, rng: np.random.Generator) -> None:
        super().__init__(ROBOT, 0, rng)
        self._tyres, self._kind = tyres, _sized(tyres)

    def _start(self, state: Array) -> Array:
        x, y, sine, cosine, vx, vy, rate = state
        heading = float(np.arctan2(sine, cosine))
        self._car = self._kind(None, [x, y], heading, cosine * vx + sine * vy)
        self._car.lateral_speed, self._car.yaw_rate = cosine * vy - sine * vx, rate
        return np.array([0.0, self._car.speed])

    def _hold(self, action: Array) -> None:
        for _ in range(round(self.dt / STEP)):
            pull = (action[1] - self._car.speed) / self._tyres.motor
            self._car.act({"steering": action[0], "acceleration": pull})
            self._car.step(STEP)

    def _true(self) -> Array:
        car = self._car
        sine, cosine = np.sin(car.heading), np.cos(car.heading)
        velocity = cosine * car.speed - sine * car.lateral_speed, sine * car.speed + cosine * car.lateral_speed
        return np.array([*car.position, sine, cosine, *velocity, car.yaw_rate])


def drives(tyres: Tyres, seed: int) -> Dataset:
    """Runs at every level of speed, to the left and to the right."""
    return drawn_drives(lambda rng: HighwayPlant(tyres, rng), SPEEDS, STEERING, DEVIATION, seed)


def _sized(tyres: Tyres) -> Any:
    """highway-env's class on these tyres, whose stiffness is an attribute of the class there."""
    from highway_env.vehicle.dynamics import BicycleVehicle

    stiffness = STIFFNESS * BicycleVehicle.MASS
    numbers = {"FRICTION_FRONT": stiffness * tyres.front, "FRICTION_REAR": stiffness * tyres.rear}
    return type("OnTyres", (BicycleVehicle,), numbers)
