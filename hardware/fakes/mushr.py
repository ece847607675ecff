"""A MuSHR on ROS 1 with MuJoCo behind it: the command multiplexer, limits of servo and speed controller, poses."""

import math
import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from hardware.clock import SystemClock
from hardware.closing import Closing
from hardware.mushr.limits import CarLimits
from hardware.mushr.link import COMMANDS
from hardware.ros1 import ACKERMANN, POSE, Message, Node
from sym2real.plants import MujocoPlant
from sym2real.protocols import Change
from sym2real.robots import MUSHR
from sym2real.trajectory import Array

INPUTS = COMMANDS.rsplit("/", 1)[0]
# The multiplexer's inputs and their priorities; the one with the greatest that is not too old drives.
PRIORITIES = {"safety": 10, "teleop": 5, "navigation": 1, "default": 0}
TIMEOUT = 0.2  # s that the multiplexer holds an input's command
POSES = "/car/car_pose"
PERIOD = 0.01  # s between poses
WALL = 1_700_000_000.0  # s: the motion capture's clock is not the computer's


@dataclass(frozen=True)
class Truth:
    """What the car is like, whatever a link believes.

    Args:
        limits: of servo and speed controller.
        latency: s from a command's arrival to the wheels.
        position_noise, yaw_noise: of motion capture, m and rad, standard deviations.
        start: x, y, yaw.
        seed: of the noise.
    """

    limits: CarLimits = field(default_factory=CarLimits)
    latency: float = 0.0
    position_noise: float = 0.0005
    yaw_noise: float = 0.002
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)
    seed: int = 0


class Car:
    """The car and its multiplexer; time goes on when :meth:`advance` is called.

    Args:
        truth: what it is like.
        changes: hidden effects, as :class:`~sym2real.plants.MujocoPlant` takes them.
    """

    def __init__(self, truth: Truth | None = None, changes: Sequence[Change] = ()) -> None:
        self.truth = truth or Truth()
        self.plant = MujocoPlant(replace(MUSHR, dt=PERIOD), changes)
        self.button = True  # that a person holds: without it, navigation does not drive
        self._rng = np.random.default_rng(self.truth.seed)
        self.put(*self.truth.start)

    def put(self, x: float, y: float, yaw: float) -> None:
        """A person puts it down, at rest, m and rad; no command is under way."""
        self.plant.reset([x, y, math.sin(yaw), math.cos(yaw), 0.0, 0.0, 0.0])
        self._inputs: dict[str, tuple[float, Array]] = {}
        self._under_way: deque[tuple[float, Array]] = deque()
        self._arrived, self._driven = np.zeros(2), np.zeros(2)

    def command(self, source: str, action: Array, now: float) -> None:
        """An input of the multiplexer has told it an action ``# (2,)``."""
        self._inputs[source] = (now, action)

    def advance(self, now: float) -> Array:
        """One period later: the pose that motion capture sees, ``x y yaw``."""
        self._under_way.append((now, self._chosen(now)))
        while self._under_way and self._under_way[0][0] <= now - self.truth.latency + 1e-9:
            self._arrived = self._under_way.popleft()[1]
        self._driven = self.truth.limits.reachable(self._arrived, self._driven, PERIOD)
        x, y, sine, cosine = self.plant.step(self._driven)[:4]
        scale = [self.truth.position_noise, self.truth.position_noise, self.truth.yaw_noise]
        seen: Array = np.array([x, y, math.atan2(sine, cosine)]) + self._rng.normal(size=3) * scale
        return seen

    @property
    def state(self) -> Array:
        """The true state ``# (7,)``."""
        return self.plant.true_state

    @property
    def driven(self) -> Array:
        """What servo and speed controller do now ``# (2,)``."""
        return self._driven.copy()

    def _chosen(self, now: float) -> Array:
        alive = {
            source: action
            for source, (stamp, action) in self._inputs.items()
            if now - stamp <= TIMEOUT and (self.button or source != "navigation")
        }
        return alive[max(alive, key=PRIORITIES.__getitem__)] if alive else np.zeros(2)


class FakeMushr(Closing):
    """The car as a node: it hears the multiplexer's inputs and tells poses, in real time.

    Args:
        node: of ROS; closed with this.
        car: behind it.
    """

    def __init__(self, node: Node, car: Car) -> None:
        self.car, self._node, self._clock = car, node, SystemClock()
        self._lock, self._closing = threading.Lock(), threading.Event()
        self.poses_lost = False  # motion capture sees the car no more
        self.time = self._clock.now()  # of the car's newest period; on a busy machine it comes late
        self._poses = node.advertise(POSES, POSE)
        for source in PRIORITIES:
            node.subscribe(f"{INPUTS}/{source}", ACKERMANN, self._hearing(source))
        self._thread = threading.Thread(target=self._run, name="fake MuSHR", daemon=True)
        self._thread.start()

    def put(self, x: float, y: float, yaw: float) -> None:
        """A person puts the car down, m and rad."""
        with self._lock:
            self.car.put(x, y, yaw)

    def close(self) -> None:
        """Stop."""
        self._closing.set()
        self._thread.join()
        self._node.close()

    def _hearing(self, source: str) -> Callable[[Message], None]:
        def heard(message: Message) -> None:
            with self._lock:
                action = np.array([message.numbers[0], message.numbers[2]])
                self.car.command(source, action, self._clock.now())

        return heard

    def _run(self) -> None:
        start = self.time
        while not self._closing.is_set():
            with self._lock:
                x, y, yaw = self.car.advance(self.time)
            if not self.poses_lost:
                turned = (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
                self._poses.publish(Message(WALL + self.time - start, "map", (), (x, y, 0.0, *turned)))
            self._clock.sleep_until(self.time + PERIOD)
            self.time += PERIOD
