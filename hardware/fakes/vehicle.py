"""What flies behind the fake Crazyflie: MuJoCo, and the firmware's rate loop, battery, watchdogs and supervisor.

It knows nothing of packets. Set-points are in the firmware's meaning: a thrust count and body rates about forward,
left, up. The yaw-rate command is integrated into a yaw target, which a proportional loop follows, as the firmware
does; the thrust that a count gives is a truth of this vehicle, which the thrust map of a link may miss.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hardware.fakes.estimator import Estimator
from hardware.fakes.supervisor import Supervisor
from hardware.frame import heading
from sym2real.plants import MujocoPlant
from sym2real.protocols import Change
from sym2real.robots import CRAZYFLIE
from sym2real.trajectory import Array

STEP = CRAZYFLIE.description.physics_dt
FULL_SCALE = 65535
LEVEL, OFF = 0.5, 2.0  # s without a set-point until the firmware turns level, and until it stops the motors
LEVELLING = 6.0  # 1/s, of attitude (and of the yaw target always)
YAW_LOOP = 6.0  # 1/s


@dataclass(frozen=True)
class Truth:
    """What the vehicle is like, whatever a link believes.

    Args:
        counts_per_newton: of total thrust.
        volts: of the battery at rest, at the start.
        drain: V lost per N of thrust and s.
        load: V lost per N of thrust, as long as it is given.
        compensated: whether the firmware makes up for the voltage; else thrust goes with it, relative to 4 V.
        astray: what the attitude of the robot's filter is off by before it is reset, rotation vector, world axes, rad.
        attitude_noise, rate_noise: standard deviations, rad and rad/s.
        position_noise: of motion capture, m.
        latency: s from the radio to the motors, and back.
        start: m, world axes, on the ground.
        seed: of the noise.
    """

    counts_per_newton: float = 111342.0
    volts: float = 4.1
    drain: float = 0.004
    load: float = 0.5
    compensated: bool = True
    astray: tuple[float, float, float] = (0.1, -0.1, 0.5)
    attitude_noise: float = 0.003
    rate_noise: float = 0.02
    position_noise: float = 0.0003
    latency: float = 0.005
    start: tuple[float, float] = (0.0, 0.0)
    seed: int = 0


@dataclass(frozen=True, eq=False)
class SetPoint:
    """What the firmware holds: a thrust count and body rates in rad/s ``# (3,)``, and when it came, s."""

    counts: int
    rates: Array
    time: float


class Vehicle:
    """A Crazyflie whose time goes on when :meth:`advance` is called.

    Args:
        truth: what it is like.
        changes: hidden effects, as :class:`~sym2real.plants.MujocoPlant` takes them.
        now: present time, s.
    """

    def __init__(self, truth: Truth, changes: Sequence[Change] = (), now: float = 0.0) -> None:
        self.truth, self.supervisor, self.estimator = truth, Supervisor(now), Estimator(truth.astray, now)
        self.plant = MujocoPlant(replace(CRAZYFLIE, dt=STEP), changes)
        self.plant.reset([*truth.start, 0.0125, 1.0, *[0.0] * 9])
        self.time, self._rng = now, np.random.default_rng(truth.seed)
        self._set_point: SetPoint | None = None
        self._heard = now
        self._volts, self.thrust, self._yaw_target = truth.volts, 0.0, 0.0

    def command(self, counts: int, rates: Array) -> None:
        """A set-point has come."""
        self._heard = self.time
        self._set_point = SetPoint(min(max(counts, 0), FULL_SCALE), rates, self.time)

    def stop(self) -> None:
        """A set-point that stops the motors has come."""
        self._set_point = None

    def place(self, state: Array) -> None:
        """Put it at a state ``# (13,)``, as it is: armed or not, with the set-point that it holds."""
        self.plant.reset(state)

    def drain_to(self, volts: float) -> None:
        """Empty the battery to this voltage under the present load."""
        self._volts = volts + self.truth.load * self.thrust

    @property
    def silence(self) -> float:
        """Time since the last set-point, s; since the start where none has come."""
        return self.time - self._heard

    def advance(self, now: float) -> None:
        """Let time go on to this moment, s."""
        while self.time + STEP <= now:
            self._step()

    @property
    def state(self) -> Array:
        """The true state ``# (13,)``."""
        return self.plant.true_state

    @property
    def battery(self) -> float:
        """Voltage under load, V."""
        return self._volts - self.truth.load * self.thrust

    def attitude(self) -> Array:
        """What the estimator says, quaternion w x y z ``# (4,)``."""
        half = 0.5 * self.truth.attitude_noise * self._rng.standard_normal(3)
        (w, x, y, z), (a, b, c) = self.estimator.attitude(self.state[3:7]), half
        noisy = np.array([w - x * a - y * b - z * c, x + w * a + y * c - z * b, y + w * b + z * a - x * c,
                          z + w * c + x * b - y * a])  # fmt: skip
        unit: Array = noisy / np.linalg.norm(noisy)
        return unit

    def rates(self) -> Array:
        """What the gyroscope says about forward, left, up, rad/s ``# (3,)``."""
        noisy: Array = self.state[10:13] + self.truth.rate_noise * self._rng.standard_normal(3)
        return noisy

    def seen(self) -> Array:
        """Position and attitude that motion capture sees ``# (7,)``."""
        noise = self.truth.position_noise * self._rng.standard_normal(3)
        return np.concatenate([self.state[0:3] + noise, self.state[3:7]])

    def _step(self) -> None:
        counts, rates = self._held()
        turning = self.supervisor.allows(self.time, counts, self.state)
        self.thrust = self._thrust(counts) if turning else 0.0
        if self.thrust == 0.0:
            self._yaw_target = heading(self.state[3:7])
        # Rates that are what they are make no torque: motors that stand still turn nothing.
        self.plant.step([self.thrust, *(self._with_yaw_target(rates) if self.thrust else self.state[10:13])])
        self._volts -= self.truth.drain * self.thrust * STEP
        self.time += STEP

    def _held(self) -> tuple[int, Array]:
        """Set-point, level after half a second without a new one, none after two."""
        held = self._set_point
        if held is None:
            return 0, np.zeros(3)
        age = self.time - held.time
        if age > OFF:
            self.supervisor.lock_in_flight()
            self._set_point = None
            return 0, np.zeros(3)
        return held.counts, self._levelling() if age > LEVEL else held.rates

    def _levelling(self) -> Array:
        x, y, z, w = self.state[[4, 5, 6, 3]]
        return LEVELLING * np.array([-2.0 * (y * z + w * x), -2.0 * (w * y - x * z), 0.0])

    def _with_yaw_target(self, rates: Array) -> Array:
        yaw = heading(self.state[3:7])
        self._yaw_target += rates[2] * STEP
        error = math.remainder(self._yaw_target - yaw, 2.0 * math.pi)
        limits = CRAZYFLIE.high[1:4]
        turned: Array = np.clip([rates[0], rates[1], YAW_LOOP * error], -limits, limits)
        return turned

    def _thrust(self, counts: int) -> float:
        newtons = counts / self.truth.counts_per_newton
        return newtons if self.truth.compensated else newtons * max(self.battery, 0.0) / 4.0
