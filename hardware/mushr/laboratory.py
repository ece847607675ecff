"""What the verbs connect to for a MuSHR: a car and its motion capture on ROS, or fakes beside the script."""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from hardware import ros2
from hardware.captures import KINDS
from hardware.checks import Check, inside, still, stream
from hardware.errors import LinkError
from hardware.fakes.beside import Fake, beside
from hardware.frame import Frame
from hardware.interfaces import Reading
from hardware.laboratory import Laboratory, Opened, Say
from hardware.mushr.limits import CarLimits
from hardware.mushr.link import COMMANDS, UNHEARD, MushrLink
from hardware.mushr.pilot import DriveLimits, DrivePilot
from hardware.ros import RosNode
from hardware.ros1 import Node
from hardware.ros1.capture import RosCapture, Topic
from sym2real.errors import ModelError
from sym2real.robots import MUSHR, Robot
from sym2real.trajectory import Array

NODE = "/sym2real"
LOOPBACK = "127.0.0.1"
BEHIND = 0.3  # m from the start, where a person might have put the fake car
PUT = 0.3  # s until filters see the place where it was put, and no way there
STOCK, LIMITS = CarLimits(), DriveLimits()


@dataclass(frozen=True, kw_only=True)
class MushrLaboratory(Laboratory):
    """A MuSHR and what sees it."""

    ROBOT: ClassVar[Robot] = MUSHR  # MPPI may ask for more than its drivers take, so that its mean reaches what they do
    RECORD: ClassVar[str] = "drive.parquet"
    GOING: ClassVar[str] = "driving to the start"
    STOPPING: ClassVar[str] = "braking"

    master: str | None = None
    """Address of the ROS master; ROS_MASTER_URI by default."""
    host: str | None = None
    """Address at which the car reaches this computer; ROS_IP or ROS_HOSTNAME, else that towards the master."""
    poses: str = "/car/car_pose"
    """Topic of the car's poses, such as /vicon/mushr/mushr."""
    kind: Literal["PoseStamped", "TransformStamped"] = "PoseStamped"
    """Type of its messages, of geometry_msgs; Vicon's bridge sends TransformStamped."""
    ros: Literal[1, 2] = 1
    """Version of ROS. 2 needs rclpy and finds others by ROS_DOMAIN_ID, without a master."""
    commands: str = COMMANDS
    """Topic of the commands: an input of the car's multiplexer."""
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Of motion capture in the world, m: tasks are around the world's origin."""
    car: CarLimits = STOCK
    """What the car's drivers take."""
    latency: float = 0.0
    """Of the fake: from a command's arrival to the wheels, s."""
    limits: DriveLimits = LIMITS
    """When a drive ends: the fence, ages, lateness."""

    @contextmanager
    def open(self, start: Array, say: Say, *, dry: bool = False) -> Iterator[Opened]:
        """A link; a person puts the car back before a drive. Arguments and errors as of a laboratory."""
        if (self.effects or self.latency) and not self.sim:
            raise ModelError("--effects and --latency are hidden in the fake of --sim")
        if self.ros == 2 and (self.sim or self.master or self.host):
            raise ModelError("--ros 2 has no --master and no --host, and the fake of --sim speaks ROS 1")
        with ExitStack() as stack:
            fake = (
                stack.enter_context(beside("hardware.fakes.mushr_process", self._hidden(start))) if self.sim else None
            )
            node = Node(NODE, fake.address, LOOPBACK) if fake else self._node()
            capture = RosCapture(node, Topic(self.poses, KINDS[self.kind]), Frame(self.axes, origin=self.origin))
            link = stack.enter_context(MushrLink(node, capture, limits=self.car, topic=self.commands, dry=dry))
            yield Opened(link, _by_program(fake) if fake else _by_hand(say))

    def checks(self, readings: Sequence[Reading]) -> list[Check]:
        """What must hold before a drive, judged while the car stands."""
        last, states = readings[-1], np.array([reading.state for reading in readings])
        heard = UNHEARD not in last.flags
        listening = "the car listens" if heard else "nobody listens"
        return [
            stream("motion capture", "pose", "pose_stamp", readings, self.limits.pose_age),
            still(states[:, :2], measured=False),
            inside(states[-1, :2], self.limits.low, self.limits.high),
            Check("commands", listening, heard, "start the car's multiplexer; is the topic right?"),
        ]

    def pilot(self) -> DrivePilot:
        """Drives to the start, and brakes."""
        return DrivePilot(MUSHR, self.limits, self.car)

    @property
    def target(self) -> dict[str, Any]:
        """Real or fake, and what its drivers make of commands."""
        return {"sim": self.sim, "effects": list(self.effects), "latency": self.latency, "car": asdict(self.car)}

    @property
    def about(self) -> dict[str, Any]:
        """Limits."""
        return {"limits": asdict(self.limits)}

    def _node(self) -> RosNode:
        return ros2.Node(NODE) if self.ros == 2 else Node(NODE, self.master, self.host)

    def _hidden(self, start: Array) -> list[str]:
        options = ["--start", *map(repr, _behind(start)), "--latency", repr(self.latency)]
        return [*options, "--effects", *self.effects] if self.effects else options


def _behind(start: Array) -> tuple[float, float, float]:
    """A place ``x y yaw`` a little behind a start ``# (7,)``."""
    x, y, sine, cosine = start[:4].tolist()
    return x - BEHIND * cosine, y - BEHIND * sine, math.atan2(sine, cosine)


def _by_program(fake: Fake) -> Callable[[Array], None]:
    def put(start: Array) -> None:
        """Put the fake car back, and wait until it stands there."""
        fake.tell(" ".join(map(repr, _behind(start))))
        time.sleep(PUT)

    return put


def _by_hand(say: Say) -> Callable[[Array], None]:
    def put(start: Array) -> None:
        """Ask a person to put the car back, and wait for it."""
        x, y, yaw = _behind(start)
        say(f"put the car near x {x:.2f} m, y {y:.2f} m, yaw {math.degrees(yaw):.0f}°, then press Enter")
        try:
            input()
        except EOFError as error:
            raise LinkError("expected a person at the keyboard who puts the car back; found no input") from error

    return put
