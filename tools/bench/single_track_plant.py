"""CommonRoad's single-track cars with slipping tyres as plants: what a bicycle without slip has to be corrected to.

Two of its models: the one that is linear in the angles (so that a car turns by δ where wheels turn it by tan δ), and
the drift model with Pacejka's tyres and spinning wheels.

M. Althoff, G. Würsching, "CommonRoad: Vehicle Models", TU Munich 2020. Installed with the extra ``bench``; nothing of
it is in this project. The numbers of the car are those of the MuSHR class, the tyres those of CommonRoad.
"""

from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from foreign_plant import ForeignPlant, runge_kutta

from sym2real.robots import ROBOTS
from sym2real.robots.robot import GRAVITY
from sym2real.trajectory import Array

ROBOT = ROBOTS["mushr"]
WHEELBASE = ROBOT.numbers["wheelbase"]
WHEEL_RADIUS = ROBOT.numbers["wheel_radius"]
AXLE_INERTIA = 1.2e-3  # kg m², two wheels and half of a geared motor
STIFFNESS = 21.92  # CommonRoad's -p_ky1: cornering stiffness per load, 1/rad
STEP, DRIFT_STEP = 0.002, 0.001  # s; wheels that spin against stiff tyres are quick
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
        tyres: cornering stiffness of the tyres as a multiple of CommonRoad's.
        drift: the drift model in place of the linear one.
    """

    offset: float = 0.0
    steering: float = 1.0
    speed: float = 1.0
    servo: float = 0.02
    motor: float = 0.06
    late: int = 0
    tyres: float = 1.0
    drift: bool = False

    @property
    def speed_lag(self) -> float:
        """Time constant of the speed in s: in the drift model the force for the car has to spin up wheels too."""
        spinning = 2 * AXLE_INERTIA / (ROBOT.mass * WHEEL_RADIUS**2) if self.drift else 0.0
        return self.motor * (1.0 + spinning)

    @property
    def curve(self) -> dict[str, dict[str, float]]:
        """Of the linear model, whose speed v is that of the middle and turns it by v δ / L.

        Along the heading that is u / cos β with a slip angle β of δ / 2 where the tyres hold, so
        κ L = δ (1 + δ²/8), and tan δ of a curve with c = 1/3 - 1/8.
        """
        return {} if self.drift else {"steering_curve": {"value": 1 / 3 - 1 / 8}}

    @property
    def compliance(self) -> float:
        """Slip angle of either axle per lateral acceleration, rad s²/m: stiffness goes by load, so both are alike."""
        return 1.0 / (STIFFNESS * self.tyres * GRAVITY)


class SingleTrackPlant(ForeignPlant):
    """CommonRoad's model, whose place is the centre of mass.

    Args:
        car: what is hidden in it.
        rng: of the sensors' noise.
    """

    def __init__(self, car: Car, rng: np.random.Generator) -> None:
        super().__init__(ROBOT, car.late, rng)
        self._car, self._numbers = car, _numbers(car.tyres)

    def _start(self, state: Array) -> Array:
        x, y, sine, cosine, vx, vy, rate = state
        speed = np.hypot(vx, vy)
        # place, steering angle, speed, yaw, yaw rate, slip angle; drift: wheels' rates
        wheels = [speed / WHEEL_RADIUS] * 2 if self._car.drift else []
        self._state = np.array([x, y, 0.0, speed, np.arctan2(sine, cosine), rate, 0.0, *wheels])
        return np.array([0.0, speed])

    def _hold(self, action: Array) -> None:
        steer, speed = self._car.steering * action[0] + self._car.offset, self._car.speed * action[1]
        step = DRIFT_STEP if self._car.drift else STEP
        for _ in range(round(self.dt / step)):
            self._advance(steer, speed, step)

    def _advance(self, steer: float, speed: float, step: float) -> None:
        from vehiclemodels.vehicle_dynamics_st import vehicle_dynamics_st
        from vehiclemodels.vehicle_dynamics_std import vehicle_dynamics_std

        dynamics = vehicle_dynamics_std if self._car.drift else vehicle_dynamics_st

        def slope(state: Array) -> Array:
            turning = (steer - state[2]) / self._car.servo
            # The motor turns wheels; the state's speed is that of the centre of mass, along its slip angle.
            pull = (speed - state[3] * np.cos(state[6])) / self._car.motor
            return np.array(dynamics(state, [turning, pull], self._numbers))

        self._state = runge_kutta(slope, self._state, step)

    def _true(self) -> Array:
        x, y, _, speed, yaw, rate, slip = self._state[:7]
        velocity = speed * np.cos(yaw + slip), speed * np.sin(yaw + slip)
        return np.array([x, y, np.sin(yaw), np.cos(yaw), *velocity, rate])


def _numbers(tyres: float) -> SimpleNamespace:
    """CommonRoad's parameter object with this car's numbers; its limits of steering and motor are not met."""
    half = WHEELBASE / 2
    limits = {"v_min": -NO_LIMIT, "v_max": NO_LIMIT, "v_switch": NO_LIMIT, "a_max": 3 * NO_LIMIT}
    rubber = _rubber()
    rubber["p_ky1"] *= tyres
    return SimpleNamespace(
        tire=SimpleNamespace(**rubber),
        a=half,
        b=half,
        h_s=0.05,
        m=ROBOT.mass,
        I_z=ROBOT.numbers["jz"],
        R_w=WHEEL_RADIUS,
        I_y_w=AXLE_INERTIA,
        T_sb=0.5,
        T_se=0.5,
        steering=SimpleNamespace(min=-0.6, max=0.6, v_min=-NO_LIMIT, v_max=NO_LIMIT),
        longitudinal=SimpleNamespace(**limits),
    )


def _rubber() -> dict[str, float]:
    """The coefficients of CommonRoad's tyre by name, from its own file."""
    import vehiclemodels

    lines = (Path(vehiclemodels.__file__).parent / "parameters" / "parameters_tire.yaml").read_text().splitlines()
    pairs = (line.partition(":") for line in lines)
    return {name.strip(): float(value) for name, _, value in pairs if name.strip()[:2] in ("p_", "r_")}
