"""The states of a flight: go, land, cut; what is sent in each. It knows no link and no clock, so tests set both."""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from hardware.errors import UnreachableError
from hardware.interfaces import Command, Reading, Verdict
from hardware.safe_flight import Line, SafeFlight
from hardware.safety import (
    BELOW_GROUND,
    FAR,
    LINK_ENDED,
    NEAR_GROUND,
    Condition,
    Judgement,
    Limits,
    blind_reason,
    judge,
    knows_attitude,
    knows_position,
    outside,
    require_possible,
    tilt_of,
)
from hardware.standing import unstable_reason
from sym2real.robots import Robot
from sym2real.trajectory import Array

ARRIVED, SETTLED = 0.1, 0.25  # m from the place and m/s, which must hold for:
DWELL = 0.5  # s
HOLDING = 2.0  # s: the battery empties
PATIENCE = 8.0  # s beyond the way's duration
CONSECUTIVE = 3  # poses in a row that say the same: one of motion capture may be wrong
SAME = 1e-6  # s: two arrivals that differ by less are one pose, read twice
BLIND = "it landed blind"  # and may lie anywhere
ASTRAY = 0.3  # m from the way down's present point: it began at a wrong pose, or something pushed the robot
LIMITS = Limits()
AT_REST = 0.05  # m/s, rad and rad/s: a start that moves more is out of reach


class FlightPilot:
    """A :class:`~hardware.interfaces.Pilot`: once it lands it lands, once the motors are cut they stay off.

    Args:
        robot: a quadrotor with thrust and body-rate commands.
        limits: of the flight.
        mass: for landings, kg; the robot's by default.

    Raises:
        ShapeError: for limits or a mass that no flight has.
    """

    def __init__(self, robot: Robot, limits: Limits = LIMITS, mass: float | None = None) -> None:
        require_possible(limits)
        self.robot, self.limits = robot, limits
        self.late, self.holding = limits.late, HOLDING
        self.safe = SafeFlight(robot, mass)
        self._start(0.0)

    def begin(self, readings: Sequence[Reading]) -> None:
        """A flight begins, from the height at which most of the readings have the robot.

        Raises:
            UnreachableError: where it would land at once, does not stand, or its battery has no reserve for a take-off.
        """
        self._start(float(np.nanmedian([reading.state[2] for reading in readings])))
        charged = replace(self.limits, battery=self.limits.battery + self.limits.reserve)
        *_, condition = map(self._condition, readings)
        if reason := judge(condition, charged).reason or unstable_reason(readings, self.limits):
            raise UnreachableError(f"no take-off: {reason}")

    def _start(self, ground: float) -> None:
        self._ground, self.judgement = ground, Judgement(Verdict.GO)
        self.safe.reset()
        self._volts: deque[tuple[float, float]] = deque()
        self._landing, self._blind = _Timer(self.robot.dt), _Timer(self.robot.dt)
        self._steered = False
        self._arrival, self._heights = -math.inf, deque([ground] * CONSECUTIVE, CONSECUTIVE)

    def approach(self, reading: Reading, state: Array) -> float:
        """Head for a state ``# (13,)`` on a straight line; s that it may take.

        Raises:
            UnreachableError: for a state that moves, leans or lies outside the fence.
        """
        if not max(float(np.abs(state[7:]).max()), tilt_of(state[3:7])) <= AT_REST:
            raise UnreachableError("a start on hardware is upright and at rest; this one moves or leans")
        place = state[:3].copy()
        if reason := outside(place, self.limits.low, self.limits.high):
            raise UnreachableError(f"the start lies {reason}")
        line = Line(reading.state[:3].copy(), place)
        self._place, self._dwelt = place, 0
        self.safe.follow(line)
        return line.duration + PATIENCE

    def towards(self, reading: Reading) -> Array:
        """Action of geometric tracking along that line ``# (4,)``."""
        return self.safe.act(reading.state) if _whole(reading) else self.robot.rest

    def arrived(self, reading: Reading) -> bool:
        """Whether it has been there, nearly at rest, for half a second of calls."""
        near = np.linalg.norm(reading.state[:3] - self._place) < ARRIVED
        slow = np.linalg.norm(reading.state[7:10]) < SETTLED
        self._dwelt = self._dwelt + 1 if near and slow else 0
        return self._dwelt * self.robot.dt >= DWELL

    def act(
        self, reading: Reading, wanted: Array | None, *, late: float = 0.0, overruns: int = 0, asked: str = ""
    ) -> Command:
        """The command of this control period; arguments as of the protocol."""
        finite = wanted is not None and bool(np.isfinite(wanted).all())
        condition = self._condition(reading, late=late, overruns=overruns, action_is_finite=finite, asked=asked)
        self._see(reading, condition)
        found = judge(condition, self.limits)
        landing = self.judgement.verdict is Verdict.LAND
        # The end of a link explains why nothing came before it.
        if found.verdict > self.judgement.verdict or (landing and found.reason == LINK_ENDED):
            self.judgement = found
        if self.judgement.verdict is Verdict.GO and wanted is not None:
            return self._command(wanted, "go")
        return self._land(reading, condition)

    def _condition(self, reading: Reading, **told: Any) -> Condition:
        return Condition(
            pose_age=reading.ages.get("pose", math.inf),
            attitude_age=reading.ages.get("attitude", math.inf),
            position=reading.state[0:3],
            attitude=reading.state[3:7],
            battery=self._battery(reading),
            flags=reading.flags,
            **told,
        )

    def _see(self, reading: Reading, condition: Condition) -> None:
        """Keep the height of a pose that has arrived since the last one."""
        arrival = reading.time - condition.pose_age
        if knows_position(condition, self.limits) and abs(arrival - self._arrival) > SAME:
            self._arrival = arrival
            self._heights.append(float(reading.state[2]))

    def _lies_below(self, height: float) -> bool:
        """Whether the robot was last seen less than so many m above the ground: one low pose may be wrong."""
        return max(self._heights) < self._ground + height

    def _land(self, reading: Reading, condition: Condition) -> Command:
        elapsed, blind = self._landing.advance(reading.time), bool(blind_reason(condition, self.limits))
        without = self._blind.advance(reading.time) if blind else self._blind.restart()
        down = self._lies_below(NEAR_GROUND if blind else self.limits.touchdown)
        over = elapsed > self.limits.landing or without > self.limits.blind
        if self.judgement.verdict is Verdict.CUT or down or over:
            fault = self._fault(down=down and not blind, over=over)
            self.judgement = replace(self.judgement, verdict=Verdict.CUT)
            return self._command(np.zeros(self.robot.layouts.action.size), "cut", fault)
        if blind or not _whole(reading):
            self._steered = False
            known = condition.attitude if knows_attitude(condition, self.limits) else None
            fault = BLIND if blind else ""
            return self._command(self.safe.level(known, self.limits.blind_thrust), "blind landing", fault)
        if not self._steered or self.safe.away(reading.state) > ASTRAY:
            self._steered = True
            self.safe.follow(self._way_down(reading.state[0:3]))
        return self._command(self.safe.act(reading.state), "land")

    def _way_down(self, place: Array) -> Line:
        inside = np.clip(place, self.limits.low, self.limits.high)
        under = np.array([inside[0], inside[1], self._ground - BELOW_GROUND])
        return Line(place.copy(), under, self.limits.descent)

    def _fault(self, *, down: bool, over: bool) -> str:
        """What ended a landing otherwise than on the ground."""
        if self.judgement.verdict is Verdict.CUT:
            return self.judgement.reason
        if down:
            return ""
        return "the landing took too long: the motors were cut" if over else BLIND

    def _command(self, action: Array, phase: str, fault: str = "") -> Command:
        robot, verdict = self.robot, self.judgement.verdict
        if verdict is not Verdict.CUT:
            action = np.clip(np.where(np.isfinite(action), action, robot.rest), robot.low, robot.high)
        return Command(action, verdict, phase, self.judgement.reason, fault, self.judgement.remedy)

    def _battery(self, reading: Reading) -> float:
        """The greatest voltage of the last while; a clock that went backwards begins a new while."""
        time, volts = reading.time, self._volts
        if volts and not time >= volts[-1][0]:
            volts.clear()
        volts.append((time, reading.battery))
        while len(volts) > 1 and not time - volts[1][0] < self.limits.battery_time:
            volts.popleft()
        return max((value for _, value in volts if not math.isnan(value)), default=math.nan)


def _whole(reading: Reading) -> bool:
    """Whether a state can be computed with: no NaN, and nothing so great that it overflows."""
    return bool((np.abs(reading.state) < FAR).all()) and not math.isnan(tilt_of(reading.state[3:7]))


class _Timer:
    """Time since the first call: by the clock, or by the calls where the clock stands still or goes backwards."""

    def __init__(self, dt: float) -> None:
        self._dt = dt
        self.restart()

    def restart(self) -> float:
        self._calls, self._start = 0, math.nan
        return 0.0

    def advance(self, time: float) -> float:
        if self._calls == 0:
            self._start = time
        elapsed = max(self._calls * self._dt, time - self._start)
        self._calls += 1
        return elapsed
