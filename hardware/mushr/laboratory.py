"""What the launch scripts of the MuSHR connect to: a car and its motion capture on ROS 1, or fakes beside them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Literal

from hardware.fakes.beside import beside
from hardware.frame import Frame
from hardware.mushr.limits import CarLimits
from hardware.mushr.link import COMMANDS, MushrLink
from hardware.ros1 import POSE, TRANSFORM, Node
from hardware.ros1.capture import RosCapture, Topic
from sym2real.errors import ModelError
from sym2real.robots import MUSHR
from sym2real.trajectory import Array

NODE = "/sym2real"
LOOPBACK = "127.0.0.1"
KINDS = {"PoseStamped": POSE, "TransformStamped": TRANSFORM}
BEHIND = 0.3  # m from the start, where a person might have put the fake car
STOCK = CarLimits()


@dataclass(frozen=True)
class Laboratory:
    """The robot and what sees it."""

    master: str | None = None
    """Address of the ROS master; ROS_MASTER_URI by default."""
    host: str | None = None
    """Address at which the car reaches this computer; ROS_IP or ROS_HOSTNAME, else that towards the master."""
    poses: str = "/car/car_pose"
    """Topic of the car's poses, such as /vicon/mushr/mushr."""
    kind: Literal["PoseStamped", "TransformStamped"] = "PoseStamped"
    """Type of its messages, of geometry_msgs; Vicon's bridge sends TransformStamped."""
    commands: str = COMMANDS
    """Topic of the commands: an input of the car's multiplexer."""
    axes: tuple[str, str, str] = ("x", "y", "z")
    """Which of motion capture's axes are the world's x, y and z (z up); x -z y where y points upward."""
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Of motion capture in the world, m: tasks are around the world's origin."""
    car: CarLimits = STOCK
    """What the car's drivers take."""
    sim: bool = False
    """A ROS master, a fake MuSHR and its poses start beside this script, in a process of their own."""
    effects: tuple[str, ...] = ()
    """Hidden in the fake: each KIND or KIND:COLUMN, then its PARAMETER=VALUE (`sym2real effects` lists them)."""
    latency: float = 0.0
    """Of the fake: from a command's arrival to the wheels, s."""

    @contextmanager
    def link(self, *, dry: bool = False, near: Array = MUSHR.start) -> Iterator[MushrLink]:
        """A link that is not yet connected, closed in the end.

        Args:
            dry: nothing is sent.
            near: state ``# (7,)`` a little behind which the fake stands.

        Raises:
            ModelError: for options that do not fit together.
            LinkError: where no master answers, or the fake does not start.
        """
        if (self.effects or self.latency) and not self.sim:
            raise ModelError("--effects and --latency are hidden in the fake of --sim")
        with ExitStack() as stack:
            node = Node(NODE, *self._network(stack, near))
            topic = Topic(self.poses, KINDS[self.kind])
            capture = RosCapture(node, topic, Frame(self.axes, origin=self.origin))
            yield stack.enter_context(MushrLink(node, capture, limits=self.car, topic=self.commands, dry=dry))

    def _network(self, stack: ExitStack, near: Array) -> tuple[str | None, str | None]:
        if not self.sim:
            return self.master, self.host
        x, y, sine, cosine = near[:4].tolist()
        place = [x - BEHIND * cosine, y - BEHIND * sine, math.atan2(sine, cosine)]
        options = ["--start", *map(repr, place), "--latency", repr(self.latency)]
        options += ["--effects", *self.effects] if self.effects else []
        return stack.enter_context(beside("hardware.fakes.mushr_process", options)), LOOPBACK
