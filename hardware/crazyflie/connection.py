"""A connection to a Crazyflie, opened with a time limit and errors in words.

The one file that imports cflib, inside its functions: it is an extra, and takes a second to load.
"""

import logging
import threading
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from hardware.clock import SystemClock
from hardware.crazyflie.routes import Packet
from hardware.errors import LinkError
from sym2real.errors import MissingDependencyError
from sym2real.trajectory import Array

# cflib closes a radio link for good after so many packets without an answer; each takes 2 ms or more: at least 3 s.
UNANSWERED = 1500
POLLED, CONFIRMING = 0.02, 5.0  # s
LOGGER = logging.getLogger(__name__)
LIBRARY = "cflib: pip install 'sym2real[crazyflie]'"


class Connection:
    """A Crazyflie by its URI.

    Args:
        uri: "radio://0/80/2M/E7E7E7E7E7", "udp://127.0.0.1:19850", …
        cache: folder for the tables of contents, whose download over the radio takes seconds.

    Raises:
        MissingDependencyError: without cflib.
    """

    def __init__(self, uri: str, cache: Path | None = None) -> None:
        try:
            with warnings.catch_warnings():  # it would have every library's deprecations told, for the whole process
                from cflib import crtp  # noqa: PLC0415
                from cflib.crazyflie import Crazyflie  # noqa: PLC0415
        except ImportError as error:
            raise MissingDependencyError(f"flying a Crazyflie needs {LIBRARY}") from error
        if not crtp.CLASSES:  # a second time would list every driver twice
            crtp.init_drivers()
        logging.getLogger("cflib").setLevel(logging.ERROR)  # what it warns of is told here, or is its own affair
        self.uri, self._clock = uri, SystemClock()
        self.crazyflie = Crazyflie(rw_cache=None if cache is None else str(cache))
        self._failure = ""

    def open(self, seconds: float) -> None:
        """Connect and download tables and parameters.

        Raises:
            LinkError: when that fails or takes longer; cflib itself would wait for ever.
        """
        ended = threading.Event()

        def failed(_: str, why: str) -> None:
            self._failure = why.strip().split("\n", maxsplit=1)[0]
            if ended.is_set():
                LOGGER.error("%s: the connection is lost, and nothing is sent any more: %s", self.uri, self._failure)
            ended.set()

        self.crazyflie.fully_connected.add_callback(lambda _: ended.set())
        self.crazyflie.connection_failed.add_callback(failed)
        self.crazyflie.connection_lost.add_callback(failed)
        self._outlast_gaps()
        self.crazyflie.open_link(self.uri)
        if ended.wait(seconds) and not self._failure:
            return
        self.close()
        why = self._failure or f"no whole answer in {seconds:g} s: is it switched on, in reach, on this address?"
        raise LinkError(f"{self.uri}: {why}")

    @property
    def lost(self) -> str:
        """Why the connection was lost; empty while it is there."""
        return self._failure

    @property
    def protocol(self) -> int:
        """Version of CRTP that the firmware speaks."""
        return int(self.crazyflie.platform.get_protocol_version())

    @property
    def logged(self) -> set[str]:
        """Names of all variables that the firmware can log."""
        return {f"{group}.{name}" for group, names in self.crazyflie.log.toc.toc.items() for name in names}

    def wait(self, ready: Callable[[], bool], seconds: float, what: str) -> None:
        """Return once something is there.

        Raises:
            LinkError: where it does not come in time, or the connection is lost meanwhile.
        """
        start = due = self._clock.now()
        while not ready():
            if self.lost or due - start > seconds:
                raise LinkError(f"{self.uri}: {self.lost or f'no {what} in {seconds:g} s'}")
            due += POLLED
            self._clock.sleep_until(due)

    def set_parameters(self, values: Mapping[str, float]) -> None:
        """Set parameters of the firmware, each once the one before is confirmed.

        Raises:
            LinkError: for one that it does not have, or does not confirm.
        """
        for name, value in values.items():
            if self.crazyflie.param.toc.get_element_by_complete_name(name) is None:
                raise LinkError(f"{self.uri}: this firmware has no parameter {name}")
            confirmed = threading.Event()
            self.crazyflie.param.add_update_callback(*name.split("."), lambda *_, told=confirmed: told.set())
            self.crazyflie.param.set_value(name, value)
            self.wait(confirmed.is_set, CONFIRMING, f"confirmation of {name}")

    def log(
        self, variables: Mapping[str, str], period_ms: int, receive: Callable[[int, dict[str, Any]], None]
    ) -> Callable[[], None]:
        """Receive a log block: ``receive`` is called from cflib's thread with the robot's ms and values by name.

        Returns:
            What ends it.

        Raises:
            LinkError: for a variable that the firmware does not log.
        """
        from cflib.crazyflie.log import LogConfig  # noqa: PLC0415

        if missing := sorted(set(variables) - self.logged):
            raise LinkError(f"{self.uri}: this firmware logs no {', '.join(missing)}")
        block = LogConfig("sym2real", period_ms)
        for name, kind in variables.items():
            block.add_variable(name, kind)
        self.crazyflie.log.add_config(block)
        block.data_received_cb.add_callback(lambda stamp, values, _: receive(stamp, values))
        block.start()
        end: Callable[[], None] = block.delete
        return end

    def send(self, packet: Packet) -> None:
        """Send data to a port's channel 0."""
        from cflib.crtp.crtpstack import CRTPPacket  # noqa: PLC0415

        made = CRTPPacket()
        made.set_header(packet[0], 0)
        made.data = packet[1]
        self.crazyflie.send_packet(made)

    def arm(self, armed: bool) -> None:
        """Ask the supervisor to arm or disarm."""
        with warnings.catch_warnings():  # it warns of older firmware, for which it has another way
            warnings.simplefilter("ignore")
            self.crazyflie.supervisor.send_arming_request(armed)

    def emergency_stop(self) -> None:
        """Motors off, and off until the robot is restarted."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self.crazyflie.supervisor.send_emergency_stop()

    def unpack_quaternion(self, packed: int) -> Array:
        """Quaternion x y z w ``# (4,)`` of the firmware's 32 bits."""
        from cflib.utils.encoding import decompress_quaternion  # noqa: PLC0415

        unpacked: Array = decompress_quaternion(packed)
        return unpacked

    def _outlast_gaps(self) -> None:
        """A gap of the radio that is shorter than the robot's own watchdog must not end the link."""
        if self.uri.startswith("radio:"):
            from cflib.crtp import radiodriver  # noqa: PLC0415

            radiodriver.set_retries_before_disconnect(UNANSWERED)

    def close(self) -> None:
        """Close the link; a set-point without thrust goes out first."""
        self.crazyflie.close_link()
