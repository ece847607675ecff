"""What the launch scripts of the Crazyflie connect to: a robot and its motion capture, or fakes beside the script."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Literal

from platformdirs import user_cache_path

from hardware.crazyflie.link import CrazyflieLink
from hardware.crazyflie.thrust_map import THRUST_MAPS, ThrustMap
from hardware.fakes.beside import beside
from hardware.fakes.capture import FakeCapture
from hardware.frame import Frame
from hardware.interfaces import MotionCapture
from hardware.motion_capture import LaboratoryCapture
from sym2real.errors import ModelError

FAKE_MAP = "2025.02"


@dataclass(frozen=True)
class Laboratory:
    """The robot and what sees it."""

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
    route: Literal["packet", "manual", "commander"] = "packet"
    """How set-points go: an own packet or cflib's manual set-point (firmware from 2025.09 on), or port 3 (any)."""
    capture: str = "vicon"
    """Kind of motion capture, as the library `motioncapture` calls it: vicon, optitrack, qualisys, vrpn, …"""
    body: str = "cf1"
    """Name of the robot's rigid body there."""
    settings: tuple[str, ...] = ()
    """Of the library: NAME=VALUE, such as hostname=192.168.1.2."""
    axes: tuple[str, str, str] = ("x", "y", "z")
    """Which of its axes are the world's x, y and z (z up); x -z y where y points upward."""
    sim: bool = False
    """A fake Crazyflie and fake motion capture start beside this script, in a process of their own."""
    effects: tuple[str, ...] = ()
    """Hidden in the fake: each KIND or KIND:COLUMN, then its PARAMETER=VALUE (`sym2real effects` lists them)."""

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
    def link(self, *, dry: bool = False) -> Iterator[CrazyflieLink]:
        """A link that is not yet connected, closed in the end.

        Raises:
            ModelError: for options that do not fit together.
            LinkError: where the fake does not start.
        """
        if self.effects and not self.sim:
            raise ModelError("--effects are hidden in the fake of --sim")
        with ExitStack() as stack:
            capture, uri = self._capture(stack)
            cache = user_cache_path("sym2real") / "crazyflie"
            made = CrazyflieLink(uri, capture, self.map(), route=self.route, cache=cache, dry=dry)
            yield stack.enter_context(made)

    def _capture(self, stack: ExitStack) -> tuple[MotionCapture, str]:
        if not self.sim:
            settings = dict(_pair(setting) for setting in self.settings)
            return LaboratoryCapture(self.capture, self.body, settings, Frame(self.axes)), self.uri
        capture = FakeCapture()
        options = ["--poses-to", str(capture.address[1])]
        options += ["--effects", *self.effects] if self.effects else []
        return capture, stack.enter_context(beside("hardware.fakes", options))


def _pair(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals:
        raise ModelError(f"--settings: expected NAME=VALUE, found {text!r}")
    return name, value
