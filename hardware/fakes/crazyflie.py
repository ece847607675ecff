"""A Crazyflie on UDP, with motion capture that sees it; cflib talks to it as to a real one."""

import math
import queue
import select
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Self

from hardware.closing import Closing
from hardware.fakes.capture import packed_pose
from hardware.fakes.firmware import Firmware
from hardware.fakes.vehicle import STEP, Truth, Vehicle
from sym2real.effects import effect
from sym2real.protocols import Change
from sym2real.robots import CRAZYFLIE

POSE_PERIOD = 0.01  # s
Address = tuple[str, int]


def hidden(effects: Sequence[tuple[str, dict[str, float]]]) -> list[Change]:
    """Effects by key and values as the vehicle's simulator takes them."""
    stepped = replace(CRAZYFLIE, dt=STEP)
    return [effect(key, stepped).inject(**values) for key, values in effects]


class FakeCrazyflie(Closing):
    """Serves one client from a thread of its own, between ``with`` and its end.

    Args:
        truth: what it is like.
        effects: hidden ones, by key and values.
        protocol: version of CRTP: 9, 10 or 12.
        port: UDP port; 0 takes one that is free.
        poses_to: where motion capture sends what it sees; None for nowhere.

    Attributes:
        muted: answers nothing and sends no log, as a radio out of reach.
        deaf: takes no packets either.
        blind: motion capture has lost the body.
        without_log: sends no log, and answers all else.
    """

    def __init__(
        self,
        truth: Truth | None = None,
        effects: Sequence[tuple[str, dict[str, float]]] = (),
        *,
        protocol: int = 12,
        port: int = 0,
        poses_to: Address | None = None,
    ) -> None:
        self.vehicle = Vehicle(truth or Truth(), hidden(effects), time.monotonic())
        self.firmware = Firmware(self.vehicle, protocol)
        self.muted = self.deaf = self.blind = self.without_log = False
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", port))
        self._poses = poses_to
        self._client: Address | None = None
        self._asked: queue.SimpleQueue[tuple[Callable[[Vehicle], None], threading.Event]] = queue.SimpleQueue()
        self._coming: deque[tuple[float, bytes]] = deque()
        self._going: deque[tuple[float, bytes, Address | None]] = deque()
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self.serve, name="fake Crazyflie", daemon=True)
        self._next_pose = self.vehicle.time

    @property
    def uri(self) -> str:
        """What a client connects to."""
        return f"udp://127.0.0.1:{self._socket.getsockname()[1]}"

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def close(self) -> None:
        """Stop, and close the port: this machine refuses what comes to it from now on."""
        self._closing.set()
        self._thread.join(5.0)
        self._socket.close()

    def do(self, change: Callable[[Vehicle], None]) -> None:
        """Change the vehicle between two of its steps; it is changed when this returns."""
        done = threading.Event()
        self._asked.put((change, done))
        done.wait()

    def serve(self) -> None:
        """Answer until it is closed."""
        while not self._closing.is_set():
            ready, _, _ = select.select([self._socket], [], [], max(0.0, min(0.1, self._until_due())))
            if ready:
                self._take()
            self._advance()
            self._send()
            while not self._asked.empty():
                change, done = self._asked.get()
                change(self.vehicle)
                done.set()

    def _until_due(self) -> float:
        coming, going = ((line[0][0] if line else math.inf) for line in (self._coming, self._going))
        return min(self.firmware.next_due, self._next_pose, coming, going) - time.monotonic()

    def _take(self) -> None:
        packet, self._client = self._socket.recvfrom(1024)
        if packet and not self.deaf:
            self._coming.append((time.monotonic() + self.vehicle.truth.latency, packet))

    def _advance(self) -> None:
        now, latency = time.monotonic(), self.vehicle.truth.latency
        while self._coming and self._coming[0][0] <= now:
            moment, packet = self._coming.popleft()
            self.vehicle.advance(moment)
            self._going += [(moment + latency, answer, self._client) for answer in self.firmware.answer(packet)]
        self.vehicle.advance(now)
        for packet in self.firmware.logged():
            if not self.without_log:
                self._going.append((now + latency, packet, self._client))
        if now >= self._next_pose:
            self._next_pose += POSE_PERIOD * (1 + int((now - self._next_pose) / POSE_PERIOD))
            if self._poses is not None and not self.blind:
                self._socket.sendto(packed_pose(now, self.vehicle.seen()), self._poses)

    def _send(self) -> None:
        now = time.monotonic()
        while self._going and self._going[0][0] <= now:
            _, packet, client = self._going.popleft()
            if client is not None and not self.muted:
                self._socket.sendto(packet, client)
