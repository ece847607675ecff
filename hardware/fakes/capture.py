"""Motion capture that sees the fake Crazyflie: a datagram for every pose, stamped on arrival as the real ones are."""

import socket
import struct
import threading

import numpy as np

from hardware.clock import Clock, SystemClock
from hardware.errors import LinkError
from hardware.interfaces import Pose
from hardware.velocity import Velocity
from sym2real.trajectory import Array

LAYOUT = struct.Struct("<8d")  # the sender's time, position, quaternion w x y z
FIRST_POSE = 5.0  # s


def packed_pose(time: float, pose: Array) -> bytes:
    """A datagram of a pose ``# (7,)``."""
    return LAYOUT.pack(time, *pose)


class FakeCapture:
    """A :class:`~hardware.interfaces.MotionCapture` that listens on UDP.

    Args:
        port: 0 takes one that is free.
        clock: the computer's by default.
    """

    def __init__(self, port: int = 0, clock: Clock | None = None) -> None:
        self._clock = clock or SystemClock()
        self._pose: Pose | None = None
        self._velocity = Velocity()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", port))
        self._socket.settimeout(0.2)
        self._first, self._closing = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._receive, name="fake motion capture", daemon=True)

    @property
    def address(self) -> tuple[str, int]:
        """Where poses are to be sent."""
        host, port = self._socket.getsockname()
        return host, port

    def connect(self) -> None:
        """Wait for the first pose.

        Raises:
            LinkError: when none comes.
        """
        self._thread.start()
        if not self._first.wait(FIRST_POSE):
            raise LinkError(f"motion capture: no pose on UDP port {self.address[1]} in {FIRST_POSE:g} s")

    def latest(self) -> Pose | None:
        """The newest pose."""
        return self._pose

    def close(self) -> None:
        """Stop to listen."""
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join(1.0)
        self._socket.close()

    def _receive(self) -> None:
        while not self._closing.is_set():
            try:
                datagram = self._socket.recv(LAYOUT.size)
            except TimeoutError:
                continue
            arrival, (_, *pose) = self._clock.now(), LAYOUT.unpack(datagram)
            place = np.array(pose[:3])
            self._pose = Pose(place, np.array(pose[3:]), arrival, arrival, self._velocity.add(arrival, place))
            self._first.set()
