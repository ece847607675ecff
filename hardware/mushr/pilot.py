"""The states of a drive: go, brake, stand. What is sent in each follows from readings alone, so that tests set them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from hardware.errors import UnreachableError
from hardware.interfaces import Command, Reading, Verdict
from hardware.mushr.limits import CarLimits
from hardware.mushr.link import UNHEARD
from hardware.safety import fresh, outside
from sym2real.control.pure_pursuit import PurePursuit
from sym2real.errors import ShapeError
from sym2real.robots import Robot
from sym2real.trajectory import Array

ARRIVED, TURNED = 0.15, math.radians(30.0)  # m and rad from the start that a controller corrects by itself
STANDS = 0.05  # m/s
APPROACH = 0.5  # m/s
PATIENCE = 8.0  # s beyond the way's duration
HOLDING = 60.0  # s: a new model is compiled meanwhile
DETOUR = 3.0  # times the straight way: a car turns round in an arc


@dataclass(frozen=True)
class DriveLimits:
    """Limits of a drive; the area is as large as the paper authors' floor, 4 × 6.4 m.

    Args:
        low, high: corners of the area that the car stays in, m, world axes with their origin in the middle.
        pose_age: s without a pose before it brakes.
        late: s that an action may be late before the drive is ended without it.
        overruns: actions in a row that may come after their period.
        braking: m/s² while it brakes; without poses too, since the speed is commanded.
        longest: s that braking may take before the car is told to stand.
    """

    low: tuple[float, float] = (-2.0, -3.2)
    high: tuple[float, float] = (2.0, 3.2)
    pose_age: float = 0.3
    late: float = 0.1
    overruns: int = 5
    braking: float = 2.5
    longest: float = 2.0


class DrivePilot:
    """A :class:`~hardware.interfaces.Pilot`: once it brakes it brakes, once it stands it stands.

    Args:
        robot: a car with steering and speed commands.
        limits: of the drive.
        car: what its drivers take: braking begins at what they do, not at what a controller asked for.

    Raises:
        ShapeError: for limits by which no drive would end well.
    """

    def __init__(self, robot: Robot, limits: DriveLimits | None = None, car: CarLimits | None = None) -> None:
        self.robot, self.limits, self.car = robot, limits or DriveLimits(), car or CarLimits()
        fence = all(low < high for low, high in zip(self.limits.low, self.limits.high, strict=True))
        rates = self.limits.braking, self.car.acceleration, self.car.steer_rate
        sizes = self.car.steer, self.car.forward, self.car.reverse
        if not (fence and all(rate > 0.0 for rate in rates) and all(size >= 0.0 for size in sizes)):
            raise ShapeError(
                "limits: expected low corners below the high ones, rates and a braking above 0, and no negative angle "
                f"or speed, found {self.limits}, {self.car}"
            )
        self.late, self.holding = self.limits.late, HOLDING
        self._start()

    def begin(self, readings: Sequence[Reading]) -> None:
        """A drive begins."""
        self._start()

    def _start(self) -> None:
        self._verdict, self._reason, self._remedy = Verdict.GO, "", ""
        self._last = self.robot.rest.copy()
        self._braked = 0.0

    def approach(self, reading: Reading, state: Array) -> float:
        """Head for a state ``# (7,)`` by pure pursuit; s that it may take.

        Raises:
            UnreachableError: for a state that moves or lies outside the area.
        """
        if not float(np.abs(state[4:]).max()) <= STANDS:
            raise UnreachableError("a start on hardware is at rest; this one moves")
        if reason := self._outside(state):
            raise UnreachableError(f"the start lies {reason}")
        self._goal, self._steps = state.copy(), 0
        robot, wheelbase = self.robot, self.robot.numbers["wheelbase"]
        low, high = robot.low.copy(), robot.high.copy()
        low[1], high[1] = max(low[1], -APPROACH), min(high[1], APPROACH)
        self._controller = PurePursuit(wheelbase, low, high, robot.dt, self._there)
        return DETOUR * float(np.linalg.norm(state[:2] - reading.state[:2])) / APPROACH + PATIENCE

    def towards(self, reading: Reading) -> Array:
        """Action of pure pursuit ``# (2,)``."""
        self._steps += 1
        whole = bool(np.isfinite(reading.state).all())
        return self._controller.act(reading.state, self._steps) if whole else self.robot.rest

    def arrived(self, reading: Reading) -> bool:
        """Whether the car stands where it was to go.

        Raises:
            UnreachableError: where it stands there and points elsewhere: it cannot turn on the spot.
        """
        away = reading.state[:2] - self._goal[:2]
        if not (np.hypot(*away) < ARRIVED and np.hypot(*reading.state[4:6]) < STANDS):
            return False
        turned = math.atan2(*reading.state[2:4]) - math.atan2(*self._goal[2:4])
        if abs(math.remainder(turned, 2.0 * math.pi)) > TURNED:
            raise UnreachableError(
                f"the car stands at the start and points {math.degrees(turned):.0f}° elsewhere: turn it by hand"
            )
        return True

    def act(
        self, reading: Reading, wanted: Array | None, *, late: float = 0.0, overruns: int = 0, asked: str = ""
    ) -> Command:
        """The command of this control period; arguments as of the protocol."""
        reason, remedy = (asked, "") if asked else self._wrong(reading, wanted, late, overruns)
        if self._verdict is Verdict.GO and (reason or wanted is None):
            self._verdict, self._reason, self._remedy = Verdict.LAND, reason or "no action", remedy
        if self._verdict is Verdict.GO and wanted is not None:
            inside = np.clip(wanted, self.robot.low, self.robot.high)
            self._last = self.car.reachable(inside, self._last, self.robot.dt)
            return Command(self._last, Verdict.GO, "go", "")
        return self._brake(reading)

    def _brake(self, reading: Reading) -> Command:
        """Straight on with the wheels as they are, slower and slower; then stand."""
        step = self.limits.braking * self.robot.dt
        self._braked += self.robot.dt
        speed = float(self._last[1])
        slower = math.copysign(max(abs(speed) - step, 0.0), speed)
        self._last = np.array([self._last[0], slower])
        stands = slower == 0.0 and not float(np.hypot(*reading.state[4:6])) > STANDS
        if self._verdict is Verdict.CUT or stands or self._braked > self.limits.longest:
            self._verdict = Verdict.CUT
            return Command(self.robot.rest.copy(), Verdict.CUT, "stand", self._reason, remedy=self._remedy)
        return Command(self._last, Verdict.LAND, "brake", self._reason, remedy=self._remedy)

    def _wrong(self, reading: Reading, wanted: Array | None, late: float, overruns: int) -> tuple[str, str]:
        """A reason to brake, and the remedy where it is not what was commanded; both empty where there is none."""
        limits, age = self.limits, reading.ages.get("pose", math.inf)
        unheard, finite = UNHEARD in reading.flags, wanted is None or bool(np.isfinite(wanted).all())
        found = (
            (
                "" if fresh(age, limits.pose_age) else f"no pose from motion capture for {age:.2f} s",
                "look at its cameras",
            ),
            ("nobody hears the commands" if unheard else "", "start the car's multiplexer"),
            (self._outside(reading.state), ""),
            ("" if late <= limits.late else f"no action for {late:.2f} s after it was due", ""),
            ("" if overruns <= limits.overruns else f"{overruns} actions in a row were late", ""),
            ("" if finite else "the controller gave no action of finite numbers", ""),
        )
        return next((each for each in found if each[0]), ("", ""))

    def _outside(self, state: Array) -> str:
        return outside(state[:2], self.limits.low, self.limits.high)

    def _there(self, time: Tensor) -> Tensor:
        return torch.from_numpy(self._goal).to(time).expand(*time.shape, len(self._goal))
