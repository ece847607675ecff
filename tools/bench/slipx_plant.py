"""SlipX's race car as a plant: two tracks, tyres with a peak that build up, a servo, current limits, a battery.

The SlipX authors' ``slipx`` (Apache-2.0), its reference car of 1/10 in the tier ``L2_DoubleTrack``. Installed with the
extra ``bench``; nothing of it is in this project. Commands are drawn, not tracked; a proportional loop makes a speed
of the acceleration that the car is told.
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from drawn_drives import ROBOT, drawn_drives
from foreign_plant import ForeignPlant

from sym2real.dataset import Dataset
from sym2real.robots.robot import GRAVITY
from sym2real.trajectory import Array

WHEELBASE, MASS, AHEAD, STIFFNESS = 0.32, 3.5, 0.16, 420.0  # m, kg, m of the centre of mass, N/rad of an axle: SlipX's
STEP_FROM, STEP_TO, SETTLED = 0.1, 0.14, 2.0  # rad, and s in which the yaw rate settles
RESISTANCE = 0.015  # of the weight, rolling: SlipX's
MOTOR, STEP = 0.15, 0.001  # s
# Of the runs: levels of speed (m/s) and steering (rad), deviation of steering and speed about them.
SPEEDS, STEERING = (1.2, 1.6, 2.0, 2.4), (-0.1, 0.1)
DEVIATION = (0.06, 0.15)


@dataclass(frozen=True)
class RaceCar:
    """What is hidden in SlipX's reference car.

    Args:
        front: stiffness of the front tyres as a multiple of SlipX's.
        ballast: kg more, which moves the centre of mass.
        ahead: where that is then, m ahead of the rear axle.
        late: control periods that commands take to arrive.
    """

    front: float = 1.0
    ballast: float = 0.0
    ahead: float = AHEAD
    late: int = 0

    @property
    def truth(self) -> dict[str, dict[str, float]]:
        """What the car is in the catalogue's terms: rolling costs speed, servo and tyres make its turn late."""
        mass = MASS + self.ballast
        front = mass * self.ahead / (WHEELBASE * STIFFNESS * self.front)
        rear = mass * (WHEELBASE - self.ahead) / (WHEELBASE * STIFFNESS)
        truth = {
            "lever_arm": {"rx": self.ahead},
            "lag:speed": {"value": MOTOR},
            "tyre_slip": {"value": rear},
            "delay:steer": {"value": lateness(self)},
            "offset:speed": {"value": -RESISTANCE * GRAVITY * MOTOR},
        }
        if self.late:
            truth["delay"] = {"value": self.late * ROBOT.dt}
        return {**truth, "understeer": {"value": front - rear}} if abs(front - rear) > 1e-12 else truth


class SlipxPlant(ForeignPlant):
    """SlipX's model, whose place is the centre of mass.

    Args:
        car: what is hidden in it.
        rng: of the sensors' noise.
    """

    def __init__(self, car: RaceCar, rng: np.random.Generator) -> None:
        super().__init__(ROBOT, car.late, rng)
        self._model = _model(car)

    def _start(self, state: Array) -> Array:
        import slipx

        x, y, sine, cosine, vx, vy, rate = state
        self._now = slipx.VehicleState()
        self._now.pos.x, self._now.pos.y, self._now.yaw = x, y, float(np.arctan2(sine, cosine))
        self._now.vel_body.x, self._now.vel_body.y = cosine * vx + sine * vy, cosine * vy - sine * vx
        self._now.rates.z, self._now.soc = rate, 1.0
        return np.array([0.0, self._now.vel_body.x])

    def _hold(self, action: Array) -> None:
        self._drive(*map(float, action), self.dt)

    def turning(self, steer: float, speed: float) -> Array:
        """The yaw rate (rad/s) in every millisecond of two seconds with one steering (rad) and speed (m/s)."""
        return self._drive(steer, speed, SETTLED)

    def _drive(self, steer: float, speed: float, seconds: float) -> Array:
        import slipx

        rates = []
        for _ in range(round(seconds / STEP)):
            pull = (speed - self._now.vel_body.x) / MOTOR
            self._model.step(self._now, slipx.DriveInput(accel_cmd=pull, steer_cmd=steer), STEP)
            rates.append(self._now.yaw_rate)
        return np.array(rates)

    def _true(self) -> Array:
        now = self._now
        sine, cosine, ahead, left = np.sin(now.yaw), np.cos(now.yaw), now.vel_body.x, now.vel_body.y
        velocity = cosine * ahead - sine * left, sine * ahead + cosine * left
        return np.array([now.pos.x, now.pos.y, sine, cosine, *velocity, now.yaw_rate])


def races(car: RaceCar, seed: int) -> Dataset:
    """Runs at every level of speed, to the left and to the right."""
    return drawn_drives(lambda rng: SlipxPlant(car, rng), SPEEDS, STEERING, DEVIATION, seed)


@cache
def lateness(car: RaceCar) -> float:
    """By how much the car's yaw rate follows a small step of the steering late, at the middle of its speeds, s.

    Measured in SlipX: the area between the yaw rate and where it ends, by the size of the step. Its servo of second
    order alone is late by 2ζ/ω, 31 ms; the tyres and the car's yaw inertia by what is beyond.
    """
    plant, speed = SlipxPlant(replace(car, late=0), np.random.default_rng(0)), float(np.mean(SPEEDS))
    plant.reset(np.array([0.0, 0.0, 0.0, 1.0, speed, 0.0, 0.0]))
    before = plant.turning(STEP_FROM, speed)[-1]
    rates = plant.turning(STEP_TO, speed)
    return float(STEP * np.sum(rates[-1] - rates) / (rates[-1] - before))


def _model(car: RaceCar) -> Any:
    """SlipX's reference car with what is hidden."""
    import slipx

    numbers = slipx.load_reference_car().params
    numbers.mass += car.ballast
    numbers.lr, numbers.lf = car.ahead, WHEELBASE - car.ahead
    numbers.c_alpha_f *= car.front
    return slipx.VehicleModel.create(slipx.Tier.L2_DoubleTrack, numbers)
