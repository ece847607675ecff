"""drone-models' Crazyflies as plants: thrust curves, rotors and drag that its authors identified from real flights.

M. Rath, M. Schuck, "drone-models", Learning Systems and Robotics Lab, TU Munich (MIT). Its first-principles model takes
four motor speeds; the rate loop in front of it is that of the Crazyflie the base model knows. Installed with the extra
``bench``; nothing of it is in this project.
"""

import tomllib
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from foreign_plant import ForeignPlant, runge_kutta

from sym2real.robots import ROBOTS
from sym2real.robots.robot import GRAVITY
from sym2real.trajectory import Array

ROBOT = ROBOTS["crazyflie"]
SUBSTEPS = 10
NOTICED = 0.05  # a rate loop that is weaker or stronger by less, because the inertia is another, shows in no flight
LEAST_THRUST = 1e-4  # N of a rotor: the curve has no speed for none
SIZES = ("mass", "L", "prop_inertia", "rpm2thrust", "rpm2torque", "mixing_matrix", "drag_matrix", "rotor_dyn_coef")


@cache
def numbers(name: str) -> Mapping[str, Any]:
    """The authors' table of a drone."""
    text = (resources.files("drone_models") / "data" / "params.toml").read_text()
    return tomllib.loads(text)[name]


@dataclass(frozen=True)
class IdentifiedQuadrotor:
    """One of the authors' drones.

    Args:
        name: of its table.
        immediate: its rotors follow at once.
        late: control periods that commands take to arrive.
    """

    name: str
    immediate: bool = False
    late: int = 0

    @property
    def truth(self) -> dict[str, dict[str, float]]:
        """What is hidden in it, in the catalogue's terms: rotors by the mean of their time constants up and down."""
        table = numbers(self.name)
        across, _, along = (-table["drag_matrix"][axis][axis] for axis in range(3))
        found = {
            "added_mass": {"value": table["mass"] - ROBOT.mass},
            "linear_drag": {"cx": across, "cy": across, "cz": along},
        }
        if not self.immediate:
            found["motor_lag"] = {"value": float(np.mean([1.0 / rate for rate in self._rates()]))}
        loop = [ROBOT.numbers[f"j{axis}"] / table["J"][place][place] for place, axis in enumerate("xyz")]
        if abs(float(np.mean(loop)) - 1.0) > NOTICED:
            found["rate_loop_gain"] = {"value": float(np.mean(loop))}
        if self.late:
            found["delay"] = {"value": self.late * ROBOT.dt}
        return found

    def hover(self) -> float:
        """Speed of a rotor that carries a quarter of the weight, rpm."""
        return float(speed_for(numbers(self.name), np.array(numbers(self.name)["mass"] * GRAVITY / 4)))

    def _rates(self) -> tuple[float, float]:
        """Of rotors near hover that speed up and that slow down, 1/s."""
        up, up_squared, down, down_squared = numbers(self.name)["rotor_dyn_coef"]
        return up + 2 * up_squared * self.hover(), down + 2 * down_squared * self.hover()


def speed_for(table: Mapping[str, Any], thrust: Array) -> Array:
    """Rotor speeds in rpm at which the authors' curve gives thrusts in N."""
    constant, linear, square = table["rpm2thrust"]
    wanted = np.maximum(thrust, LEAST_THRUST) - constant
    return (np.sqrt(linear**2 + 4 * square * wanted) - linear) / (2 * square)


class LsyPlant(ForeignPlant):
    """drone-models' first-principles dynamics.

    Args:
        quadrotor: which.
        rng: of the sensors' noise.
    """

    def __init__(self, quadrotor: IdentifiedQuadrotor, rng: np.random.Generator) -> None:
        from drone_models.first_principles import dynamics

        super().__init__(ROBOT, quadrotor.late, rng)
        self._quadrotor, self._table, self._dynamics = quadrotor, numbers(quadrotor.name), dynamics
        inertia = np.array(self._table["J"])
        self._told = {name: np.array(self._table[name]) for name in SIZES}
        self._told |= {"J": inertia, "J_inv": np.linalg.inv(inertia), "gravity_vec": np.array([0.0, 0.0, -GRAVITY])}
        turns, arm, drag = np.array(self._table["mixing_matrix"]), self._table["L"], self._table["thrust2torque"]
        self._rotors = np.linalg.inv(np.stack([np.ones(4), arm * turns[0], arm * turns[1], drag * turns[2]]))

    def _start(self, state: Array) -> Array:
        body = np.r_[state[:3], state[4:7], state[3], state[7:13]]  # the scalar of its quaternion is last
        self._state = np.r_[body, np.full(4, self._quadrotor.hover())]
        return ROBOT.rest.copy()

    def _hold(self, action: Array) -> None:
        for _ in range(SUBSTEPS):
            speeds = self._speeds(action)
            self._state = runge_kutta(lambda at, sent=speeds: self._slope(at, sent), self._state, self.dt / SUBSTEPS)
            self._state[3:7] /= np.linalg.norm(self._state[3:7])

    def _speeds(self, action: Array) -> Array:
        """What the rate loop sends to the rotors, rpm ``# (4,)``."""
        constants = ROBOT.numbers
        gains = np.array([constants[f"j{axis}"] * constants[f"k{axis}"] for axis in "xyz"])
        torques = gains * (action[1:] - self._state[10:13])
        return speed_for(self._table, self._rotors @ np.r_[action[0], torques])

    def _slope(self, at: Array, sent: Array) -> Array:
        attitude, rates = at[3:7] / np.linalg.norm(at[3:7]), at[10:13]
        rotors = None if self._quadrotor.immediate else at[13:]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # that rotors are immediate
            moved, _, pushed, turned, spun = self._dynamics(
                at[:3], attitude, at[7:10], rates, sent, rotor_vel=rotors, **self._told
            )
        vector, scalar = attitude[:3], attitude[3]
        turning = 0.5 * np.r_[scalar * rates + np.cross(vector, rates), -vector @ rates]
        return np.r_[moved, turning, pushed, turned, np.zeros(4) if spun is None else spun]

    def _true(self) -> Array:
        attitude = self._state[3:7] * np.sign(self._state[6])
        return np.r_[self._state[:3], attitude[3], attitude[:3], self._state[7:13]]
