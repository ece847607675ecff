"""Vicon, OptiTrack, Qualisys, VRPN … through the `motioncapture` library, and its mock.

The library tells no stamps: a pose is stamped when it arrives. Its ``connect`` holds Python's lock until a server
answers, so it comes before anything is armed; waiting for a frame does not.
"""

import threading
from collections.abc import Mapping
from typing import Any

import numpy as np

from hardware.errors import LinkError
from hardware.frame import Frame
from hardware.seen import FIRST_POSE, SeenBody
from sym2real.errors import needing

CLOSING = 1.0  # s


class LaboratoryCapture(SeenBody):
    """A :class:`~hardware.interfaces.MotionCapture` of one rigid body.

    Args:
        kind: of the system, as the library calls it: "vicon", "optitrack", "qualisys", "vrpn", "mock", …
        body: name of the rigid body there.
        settings: of the library for that kind, such as {"hostname": "192.168.1.2"}.
        frame: of the system in the world.
    """

    def __init__(
        self,
        kind: str,
        body: str,
        settings: Mapping[str, str],
        frame: Frame | None = None,
    ) -> None:
        super().__init__(frame)
        self.kind, self.body, self.settings = kind, body, dict(settings)
        self._bodies: tuple[str, ...] = ()
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None

    def connect(self) -> None:
        """Connect, and wait for a pose of the body.

        Raises:
            MissingDependencyError: without the library.
            LinkError: where the library refuses, or no such body is seen; naming those that are.
        """
        with needing("motion capture needs", "mocap"):
            import motioncapture  # noqa: PLC0415 — an extra
        try:
            source = motioncapture.connect(self.kind, self.settings)
        except RuntimeError as error:
            raise LinkError(f"motion capture {self.kind!r} with {self.settings}: {error}") from error
        self._thread = threading.Thread(target=self._receive, args=(source,), name="motion capture", daemon=True)
        self._thread.start()
        if not self.comes():
            seen = ", ".join(self._bodies) or "none"
            self.close()
            raise LinkError(
                f"motion capture {self.kind!r}: no pose of {self.body!r} in {FIRST_POSE:g} s (seen: {seen})"
            )

    def close(self) -> None:
        """Stop to receive; a client that waits for a frame for ever is left behind."""
        self._closing.set()
        if self._thread is not None:
            self._thread.join(CLOSING)

    def _receive(self, source: Any) -> None:
        while not self._closing.is_set():
            source.waitForNextFrame()
            arrival, bodies = self.clock.now(), source.rigidBodies
            self._bodies = tuple(bodies)
            if self.body in bodies:
                place, turned = bodies[self.body].position, bodies[self.body].rotation
                attitude = np.array([turned.w, turned.x, turned.y, turned.z], dtype=np.float64)
                self.tell(np.asarray(place, dtype=np.float64), attitude, arrival)
