"""A Crazyflie as a robot link: position from motion capture, attitude and rates from it, thrust and rates to it."""

import math
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hardware.clock import SystemClock
from hardware.closing import Closing
from hardware.crazyflie.connection import Connection
from hardware.crazyflie.estimator import begin_anew
from hardware.crazyflie.routes import ROUTES, Packet, wire_rates
from hardware.crazyflie.sender import NewestOnly
from hardware.crazyflie.telemetry import PERIOD_MS, Telemetry, block_for, read
from hardware.crazyflie.thrust_map import ThrustMap
from hardware.errors import LinkError
from hardware.frame import heading
from hardware.interfaces import MotionCapture, Reading, finite_action
from hardware.safety import LOST
from sym2real.robots import CRAZYFLIE
from sym2real.trajectory import Array

STOP, SET_POINT, REQUEST, POSITION = "stop", "set-point", "request", "position"
CONNECTING, ARMING, STOPPING = 20.0, 3.0, 0.5  # s


class CrazyflieLink(Closing):
    """A :class:`~hardware.interfaces.RobotLink`.

    The robot stands with its front along the world's x axis when it is connected: its yaw is its own estimate.

    Args:
        uri: of the Crazyflie.
        capture: sees it; connected first, because some clients hold Python still while they connect.
        thrust_map: of its firmware and motors.
        route: key of :data:`~hardware.crazyflie.routes.ROUTES`.
        cache: folder for tables of contents.
        dry: everything but arming and set-points.

    Raises:
        MissingDependencyError: without cflib.
        UnknownNameError: for a route that does not exist.
    """

    def __init__(
        self,
        uri: str,
        capture: MotionCapture,
        thrust_map: ThrustMap,
        *,
        route: str = "packet",
        cache: Path | None = None,
        dry: bool = False,
    ) -> None:
        self.robot, self.thrust_map, self.route, self.dry = CRAZYFLIE, thrust_map, ROUTES[route], dry
        self._clock, self._capture = SystemClock(), capture
        self.connection = Connection(uri, cache)
        self._sender: NewestOnly | None = None
        self._telemetry: Telemetry | None = None
        self._told = 0.0  # stamp of the last position that the robot was told
        self._count, self._saturated, self._locked = 0, False, False

    @property
    def about(self) -> dict[str, Any]:
        """Address, protocol, route and thrust map."""
        connection = {"uri": self.connection.uri, "protocol": self.connection.protocol}
        return connection | {"route": self.route.name, "thrust_map": asdict(self.thrust_map)}

    def connect(self) -> None:
        """Motion capture, then the robot, its log, and its estimator, which begins anew.

        Raises:
            LinkError: naming what did not answer, or what the firmware is too old for.
        """
        self._capture.connect()
        self.connection.open(CONNECTING)
        protocol = self.connection.protocol
        if protocol < self.route.protocol:
            raise LinkError(
                f"route {self.route.name!r} needs CRTP protocol {self.route.protocol}, the firmware speaks {protocol}: "
                "update it, or take the route 'commander'"
            )
        self.connection.set_parameters(self.route.parameters)
        self._block = block_for(self.connection.logged)
        self._sender = NewestOnly(STOP, SET_POINT, REQUEST, POSITION)
        self.connection.log(self._block.variables, PERIOD_MS, self._receive)
        self.connection.wait(lambda: self._telemetry is not None, CONNECTING, "log packet")
        self.connection.wait(lambda: bool(np.isfinite(self.state().state).all()), CONNECTING, "whole state")
        begin_anew(self.connection, self.state().state[:3])

    def arm(self) -> None:
        """Unlock and arm; nothing turns yet.

        Raises:
            LinkError: when the robot does not say that it is armed, with what it says.
        """
        if self.dry:
            return
        if self.route.unlocked_by_zero:
            self._put(self._setpoint(np.zeros(3), 0))
            self._require_sent()  # nothing newer may take its place
        self._put(lambda: self.connection.arm(True), REQUEST)
        wanted = "armed" if self._block.arming else "can_fly"
        said = ", ".join(sorted(self.state().flags)) or "nothing"
        self.connection.wait(
            lambda: wanted in self.state().flags, ARMING, f"the flag {wanted!r} (the robot says: {said})"
        )

    def state(self) -> Reading:
        """Position and velocity of motion capture, attitude and rates of the robot.

        The flag "lost" says that the connection has ended for good.
        """
        now, pose, told = self._clock.now(), self._capture.latest(), self._telemetry
        state = np.full(self.robot.layouts.state.size, math.nan)
        ages = {"pose": math.inf, "attitude": math.inf}
        extra = {"thrust_count": float(self._count), "saturated": float(self._saturated)}
        if pose is not None:
            state[0:3], state[7:10] = pose.position, pose.velocity
            ages["pose"], extra["pose_stamp"] = now - pose.arrival, pose.stamp
            if pose.attitude is not None:
                extra["capture_yaw"] = heading(pose.attitude)
        if told is None:
            return Reading(now, state, ages, extra=extra)
        state[3:7], state[10:13] = told.attitude, told.rates
        ages["attitude"], extra["robot_stamp"] = now - told.arrival, told.stamp
        flags = told.flags | {LOST} if self.connection.lost else told.flags
        return Reading(now, state, ages, told.battery, flags, extra)

    def send(self, action: ArrayLike) -> Array:
        """Thrust in N and body rates in rad/s ``# (4,)``; the same as the robot is told them; zeros once it is locked.

        Raises:
            ShapeError: for an action that is not finite or has other columns; nothing is sent then.
        """
        wanted = finite_action(action, self.robot)
        if self._locked:
            self._count, self._saturated = 0, False
            self._put(self._stop_and_lock, STOP)  # the one before may have been lost on the air
            return np.zeros_like(wanted)
        counts = self.thrust_map.counts(float(wanted[0]))
        self._count = self.route.reachable(counts.value)
        self._saturated = counts.saturated or self._count != counts.value
        degrees, rates = wire_rates(wanted[1:4])
        if not self.dry:
            self._put(self._setpoint(degrees, self._count))
        return np.array([self.thrust_map.newtons(self._count), *rates])

    def stop(self, *, emergency: bool = False) -> None:
        """Motors off and disarmed; after an emergency stop nothing else is sent until the robot is restarted."""
        if self._sender is not None and not self.dry:
            self._locked = self._locked or emergency
            # Alone: an arming request or a set-point that still waits would go out after it.
            self._sender.put_alone(STOP, self._stop_and_lock if self._locked else self._stop)
            self._sender.flush(STOPPING, STOP)

    def close(self) -> None:
        """Stop, and close both links."""
        if self._sender is not None:
            self.stop()
            self._sender.close()
            self._sender = None
            self.connection.close()
        self._capture.close()

    def _stop(self) -> None:
        self.connection.crazyflie.commander.send_stop_setpoint()
        self.connection.arm(False)

    def _stop_and_lock(self) -> None:
        self.connection.emergency_stop()

    def _setpoint(self, rates_deg: Array, counts: int) -> Callable[[], None]:
        return lambda: self.route.tell(self.connection.crazyflie, self._send_packet, rates_deg, counts)

    def _send_packet(self, packet: Packet) -> None:
        self.connection.send(packet)

    def _put(self, send: Callable[[], None], kind: str = SET_POINT) -> None:
        if self._sender is None:
            raise LinkError("expected an open link: connect first")
        self._sender.put(kind, send)

    def _require_sent(self) -> None:
        if self._sender is None or not self._sender.flush(ARMING, STOP, SET_POINT, REQUEST):
            raise LinkError(f"{self.connection.uri}: the radio takes no packets")

    def _tell_position(self) -> None:
        pose, sender = self._capture.latest(), self._sender
        if sender is not None and pose is not None and pose.stamp != self._told:
            self._told, place = pose.stamp, pose.position.tolist()
            sender.put(POSITION, lambda: self.connection.crazyflie.extpos.send_extpos(*place))

    def _receive(self, stamp_ms: int, values: dict[str, Any]) -> None:
        arrival, unpack = self._clock.now(), self.connection.unpack_quaternion
        self._telemetry = read(self._block, values, unpack, stamp_ms, arrival)
        self._tell_position()  # with every log packet, in flight or between two: its estimator must not drift away
