"""What the verbs connect to for a Crazyflie: a robot and its motion capture, or fakes beside the script."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from platformdirs import user_cache_path

from hardware.captures import capture_of
from hardware.checks import Check, below, inside, still, stream
from hardware.crazyflie.link import CrazyflieLink
from hardware.crazyflie.thrust_map import THRUST_MAPS, ThrustMap
from hardware.fakes.beside import beside
from hardware.fakes.capture import FakeCapture
from hardware.frame import Frame
from hardware.interfaces import MotionCapture, Reading
from hardware.laboratory import Laboratory, Opened, Say
from hardware.pilot import FlightPilot
from hardware.safety import CUTS, Limits
from hardware.standing import rate_among, tilt_among, yaw_off
from sym2real.errors import ModelError
from sym2real.robots import CRAZYFLIE, Robot
from sym2real.trajectory import Array

FAKE_MAP = "2025.02"
LIMITS = Limits()


@dataclass(frozen=True, kw_only=True)
class CrazyflieLaboratory(Laboratory):
    """A Crazyflie and what sees it."""

    ROBOT: ClassVar[Robot] = CRAZYFLIE
    RECORD: ClassVar[str] = "flight.parquet"
    GOING: ClassVar[str] = "arming, taking off, flying to the start"
    STOPPING: ClassVar[str] = "landing"

    uri: str = "radio://0/80/2M/E7E7E7E7E7"
    """Of the Crazyflie."""
    thrust_map: str | None = None
    """Its firmware and motors: paper, 2025.02, 2025.09[-upgrade], 2026.04[-upgrade, -brushless]. Must be said, but for
    --sim."""
    gain: float = 1.0
    """What `diagnose` found as gain:thrust: the robot gives so many times the thrust that the map says."""
    hover_counts: float | None = None
    """Mean thrust count of a hover (thrust_count in a record), which with --mass calibrates the map."""
    mass: float | None = None
    """Of the robot with all that it carries, kg; the model's robot's own by default. Take-off and landing know it."""
    route: Literal["packet", "commander"] = "packet"
    """How set-points go: an own packet (firmware from 2025.09 on), or port 3 (any)."""
    capture: str = "vicon"
    """Kind of motion capture, as the library `motioncapture` calls it (vicon, optitrack, qualisys, vrpn, …), or ros or
    ros2 for a topic."""
    body: str = "cf1"
    """Name of the robot's rigid body there."""
    settings: tuple[str, ...] = ()
    """Of the library: NAME=VALUE, as hostname=192.168.1.2; of ros topic, type, master, host; of ros2 topic, type."""
    limits: Limits = LIMITS
    """When a flight ends: the fence, ages, battery, tilt."""

    def map(self) -> ThrustMap:
        """The thrust map, calibrated and corrected.

        Raises:
            ModelError: where none is named, or hover counts come without a mass.
        """
        if self.thrust_map is None and not self.sim:
            raise ModelError(f"--thrust-map: name the robot's firmware and motors, one of {', '.join(THRUST_MAPS)}")
        chosen = THRUST_MAPS[self.thrust_map or FAKE_MAP]
        if self.hover_counts is not None:
            if self.mass is None:
                raise ModelError("--hover-counts needs --mass: what is it that hovers?")
            chosen = chosen.calibrated(self.mass, self.hover_counts)
        return chosen if self.gain == 1.0 else chosen.corrected(self.gain)

    @contextmanager
    def open(self, start: Array, say: Say, *, dry: bool = False) -> Iterator[Opened]:
        """A link; the drone flies to any start itself. Arguments and errors as of a laboratory."""
        if self.effects and not self.sim:
            raise ModelError("--effects are hidden in the fake of --sim")
        thrust_map = self.map()
        with ExitStack() as stack:
            capture, uri = self._capture(stack)
            cache = user_cache_path("sym2real") / "crazyflie"
            link = CrazyflieLink(uri, capture, thrust_map, route=self.route, cache=cache, dry=dry)
            yield Opened(stack.enter_context(link))

    def checks(self, readings: Sequence[Reading]) -> list[Check]:
        """What must hold before a take-off, judged on the ground."""
        last, limits = readings[-1], self.limits
        states = np.array([reading.state for reading in readings])
        charged = last.battery >= limits.battery + limits.reserve
        flagged = sorted(last.flags & set(CUTS))
        return [
            stream("motion capture", "pose", "pose_stamp", readings, limits.pose_age),
            stream("the robot's log", "attitude", "robot_stamp", readings, limits.attitude_age),
            still(states[:, :3]),
            below("tilt", tilt_among(readings), limits.standing_tilt, "rad", "stand it upright on level ground"),
            below("rate", rate_among(readings), limits.standing_rate, "rad/s", "let it stand still"),
            below("yaw against motion capture", yaw_off(readings), limits.facing, "rad", "turn its front along x"),
            inside(states[-1, :3], limits.low, limits.high),
            Check("battery", f"{last.battery:.2f} V", charged, "charge it"),
            Check("supervisor", " ".join(sorted(last.flags)) or "nothing set", not flagged, "restart the robot"),
        ]

    def pilot(self) -> FlightPilot:
        """Takes off, lands, and knows the mass."""
        return FlightPilot(CRAZYFLIE, self.limits, self.mass)

    @property
    def target(self) -> dict[str, Any]:
        """Real or fake, and what a thrust means."""
        return {"sim": self.sim, "effects": list(self.effects), "thrust_map": asdict(self.map())}

    @property
    def about(self) -> dict[str, Any]:
        """Mass and limits."""
        return {"mass": self.mass or CRAZYFLIE.mass, "limits": asdict(self.limits)}

    def _capture(self, stack: ExitStack) -> tuple[MotionCapture, str]:
        if not self.sim:
            settings = dict(_pair(setting) for setting in self.settings)
            return stack.enter_context(capture_of(self.capture, self.body, settings, Frame(self.axes))), self.uri
        capture = FakeCapture()
        options = ["--poses-to", str(capture.address[1])]
        options += ["--effects", *self.effects] if self.effects else []
        return capture, stack.enter_context(beside("hardware.fakes", options)).address


def _pair(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals:
        raise ModelError(f"--settings: expected NAME=VALUE, found {text!r}")
    return name, value
