"""Motion capture that sees the fake Crazyflie: a datagram for every pose, stamped on arrival as the real ones are."""

import socket
import struct
import threading

import numpy as np

from hardware.errors import LinkError
from hardware.seen import FIRST_POSE, SeenBody
from sym2real.trajectory import Array

LAYOUT = struct.Struct("<8d")  # the sender's time, position, quaternion w x y z


def packed_pose(time: float, pose: Array) -> bytes:
    """A datagram of a pose ``# (7,)``."""
    return LAYOUT.pack(time, *pose)


class FakeCapture(SeenBody):
    """A :class:`~hardware.interfaces.MotionCapture` that listens on UDP.

    Args:
        port: 0 takes one that is free.
    """

    def __init__(self, port: int = 0) -> None:
        super().__init__()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", port))
        self._socket.settimeout(0.2)
        self._closing = threading.Event()
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
        if not self.comes():
            raise LinkError(f"motion capture: no pose on UDP port {self.address[1]} in {FIRST_POSE:g} s")

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
            arrival, (_, *pose) = self.clock.now(), LAYOUT.unpack(datagram)
            self.tell(np.array(pose[:3]), np.array(pose[3:]), arrival)
