"""A thread that sends the newest of each kind: a radio that blocks for seconds must not block the control loop.

cflib's queue to the radio holds one packet, and putting a second one waits up to 2 s. What is not yet sent when
something newer of its kind comes is replaced: an old set-point is worth nothing.
"""

import logging
import threading
from collections.abc import Callable

LOGGER = logging.getLogger(__name__)
Send = Callable[[], None]


class NewestOnly:
    """Sends what it is given, the newest of each kind, in the order of the kinds.

    Args:
        kinds: what is sent, the most urgent first.

    Attributes:
        replaced: how many were replaced before they were sent.
        sent: how many were sent.
    """

    def __init__(self, *kinds: str) -> None:
        self._waiting: dict[str, Send | None] = dict.fromkeys(kinds)
        self._changed = threading.Condition()
        self._open, self._busy = True, ""
        self.replaced = self.sent = 0
        self._thread = threading.Thread(target=self._run, name="newest-only sender", daemon=True)
        self._thread.start()

    def put(self, kind: str, send: Send) -> None:
        """Send this, unless something newer of its kind comes before its turn; it never waits."""
        with self._changed:
            self.replaced += self._waiting[kind] is not None
            self._waiting[kind] = send
            self._changed.notify_all()

    def put_alone(self, kind: str, send: Send) -> None:
        """Send this in place of all that waits; it never waits."""
        with self._changed:
            self.replaced += sum(waiting is not None for waiting in self._waiting.values())
            self._waiting = {**dict.fromkeys(self._waiting), kind: send}
            self._changed.notify_all()

    def flush(self, seconds: float, *kinds: str) -> bool:
        """Wait until all of these kinds, by default of every one, is sent, at most so long; whether it is."""
        kinds = kinds or tuple(self._waiting)
        with self._changed:
            return self._changed.wait_for(
                lambda: self._busy not in kinds and not any(self._waiting[kind] for kind in kinds), seconds
            )

    def close(self) -> None:
        """Send what waits and end the thread; one that is blocked is left behind."""
        with self._changed:
            self._open = False
            self._changed.notify_all()
        self._thread.join(1.0)

    def _next(self) -> Send | None:
        with self._changed:
            self._busy = ""
            self._changed.notify_all()
            self._changed.wait_for(lambda: any(self._waiting.values()) or not self._open)
            for kind, send in self._waiting.items():
                if send is not None:
                    self._waiting[kind], self._busy = None, kind
                    return send
            return None

    def _run(self) -> None:
        while (send := self._next()) is not None:
            try:
                send()
                self.sent += 1
            except Exception:  # the set-point that stops the motors may be the next
                LOGGER.exception("a packet could not be sent")
