"""Vicon, OptiTrack, Qualisys, VRPN … through the `motioncapture` library, and its mock.

The library tells no stamps: a pose is stamped when it arrives. Its ``connect`` holds Python's lock until a server
answers, so it comes before anything is armed; waiting for a frame does not.
"""

import threading
from collections.abc import Mapping
from typing import Any

import numpy as np

from hardware.clock import Clock, SystemClock
from hardware.errors import LinkError
from hardware.frame import Frame
from hardware.interfaces import Pose
from hardware.velocity import Velocity
from sym2real.errors import MissingDependencyError

FIRST_POSE = 5.0  # s
CLOSING = 1.0  # s


class LaboratoryCapture:
    """A :class:`~hardware.interfaces.MotionCapture` of one rigid body.

    Args:
        kind: of the system, as the library calls it: "vicon", "optitrack", "qualisys", "vrpn", "mock", …
        body: name of the rigid body there.
        settings: of the library for that kind, such as {"hostname": "192.168.1.2"}.
        frame: of the system in the world.
        clock: the computer's by default.
    """

    def __init__(
        self,
        kind: str,
        body: str,
        settings: Mapping[str, str],
        frame: Frame | None = None,
        clock: Clock | None = None,
    ) -> None:
        self.kind, self.body, self.settings = kind, body, dict(settings)
        self._frame, self._clock = frame or Frame(), clock or SystemClock()
        self._pose: Pose | None = None
        self._velocity = Velocity()
        self._bodies: tuple[str, ...] = ()
        self._first, self._closing = threading.Event(), threading.Event()
        self._thread: threading.Thread | None = None

    def connect(self) -> None:
        """Connect, and wait for a pose of the body.

        Raises:
            MissingDependencyError: without the library.
            LinkError: where the library refuses, or no such body is seen; naming those that are.
        """
        try:
            import motioncapture  # noqa: PLC0415 — an extra
        except ImportError as error:
            raise MissingDependencyError("motion capture needs pip install 'sym2real[mocap]'") from error
        try:
            source = motioncapture.connect(self.kind, self.settings)
        except RuntimeError as error:
            raise LinkError(f"motion capture {self.kind!r} with {self.settings}: {error}") from error
        self._thread = threading.Thread(target=self._receive, args=(source,), name="motion capture", daemon=True)
        self._thread.start()
        if not self._first.wait(FIRST_POSE):
            seen = ", ".join(self._bodies) or "none"
            self.close()
            raise LinkError(
                f"motion capture {self.kind!r}: no pose of {self.body!r} in {FIRST_POSE:g} s (seen: {seen})"
            )

    def latest(self) -> Pose | None:
        """The newest pose, in the world's axes."""
        return self._pose

    def close(self) -> None:
        """Stop to receive; a client that waits for a frame for ever is left behind."""
        self._closing.set()
        if self._thread is not None:
            self._thread.join(CLOSING)

    def _receive(self, source: Any) -> None:
        while not self._closing.is_set():
            source.waitForNextFrame()
            arrival, bodies = self._clock.now(), source.rigidBodies
            self._bodies = tuple(bodies)
            if self.body in bodies:
                self._pose = self._pose_of(bodies[self.body], arrival)
                self._first.set()

    def _pose_of(self, body: Any, arrival: float) -> Pose | None:
        position = np.asarray(body.position, dtype=np.float64)
        turned = body.rotation
        attitude = np.array([turned.w, turned.x, turned.y, turned.z], dtype=np.float64)
        if not np.isfinite(position).all():  # some systems tell of a lost body in this way
            return self._pose
        seen = self._frame.attitude(attitude) if abs(attitude @ attitude - 1.0) < 0.1 else None
        place = self._frame.position(position)
        return Pose(place, seen, arrival, arrival, self._velocity.add(arrival, place))
