"""What a node hears of a topic: one connection to every publisher that the master tells of."""

import contextlib
import logging
import socket
import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

from hardware.errors import LinkError
from hardware.ros1.connection import read_block, read_header, write_header
from hardware.ros1.messages import Message, MessageType

LOGGER = logging.getLogger(__name__)
CONNECTING = 2.0  # s for a publisher to answer
SOONEST, LATEST = 0.1, 5.0  # s before a connection that broke is made again; doubled as long as nothing is heard
Heard = Callable[[Message], None]
Ask = Callable[[str, str], tuple[str, int]]


@dataclass(eq=False)
class Publisher:
    """A publisher that is listened to, by its XML-RPC address, until it is left; its connection while there is one."""

    address: str
    left: threading.Event = field(default_factory=threading.Event)
    connection: socket.socket | None = None

    def leave(self) -> None:
        """Who listens there still reads what has come, such as a car's last zeros, and closes it then."""
        self.left.set()
        if self.connection is not None:
            with contextlib.suppress(OSError):
                self.connection.shutdown(socket.SHUT_RDWR)


class Subscription:
    """A topic that a node listens to.

    Args:
        topic: its name.
        kind: of its messages.
        caller: name of the node.
        heard: called with every message, from a thread of its publisher's.
        ask: address of the socket at which a publisher (of this XML-RPC address) sends a topic.
    """

    def __init__(self, topic: str, kind: MessageType, caller: str, heard: Heard, ask: Ask) -> None:
        self.topic, self.kind, self._caller, self._heard, self._ask = topic, kind, caller, heard, ask
        self._publishers: dict[str, Publisher] = {}
        self._lock = threading.Lock()
        self._hearing = threading.RLock()  # who listens may close its node
        self._closed = False

    def follow(self, publishers: Iterable[str]) -> None:
        """Connect to those of these XML-RPC addresses that are new, and leave those that are gone."""
        wanted = set(publishers)
        with self._lock:
            known = self._publishers
            new = [] if self._closed else [Publisher(address) for address in wanted if address not in known]
            gone = [known.pop(address) for address in [*known] if address not in wanted]
            known |= {publisher.address: publisher for publisher in new}
        for publisher in gone:
            publisher.leave()
        for publisher in new:
            threading.Thread(target=self._listen, args=(publisher,), name=f"hears {self.topic}", daemon=True).start()

    def close(self) -> None:
        """Leave all publishers; nothing is heard afterwards."""
        with self._hearing:
            self._closed = True
        self.follow(())

    def _listen(self, publisher: Publisher) -> None:
        """Hear it until it is left; while the master tells of it, a connection that breaks is made again."""
        pause = 0.0
        while not publisher.left.wait(pause):
            try:
                with self._connect(publisher.address) as publisher.connection:
                    if publisher.left.is_set():  # meanwhile
                        return
                    while self._hear(self.kind.decode(read_block(publisher.connection))):
                        pause = 0.0
            except (OSError, LinkError) as error:
                if pause == 0.0 and not publisher.left.is_set():  # else it is known
                    LOGGER.warning("%s from %s: %s", self.topic, publisher.address, error)
            pause = min(max(SOONEST, 2.0 * pause), LATEST)

    def _hear(self, message: Message) -> bool:
        """Tell of a message, unless this is closed; whether it is open."""
        with self._hearing:
            if not self._closed:
                self._heard(message)
            return not self._closed

    def _connect(self, publisher: str) -> socket.socket:
        connection = socket.create_connection(self._ask(publisher, self.topic), CONNECTING)
        try:
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            about = {"type": self.kind.name, "md5sum": self.kind.md5sum, "message_definition": self.kind.definition}
            write_header(connection, {"callerid": self._caller, "topic": self.topic, "tcp_nodelay": "1", **about})
            answer: dict[str, Any] = read_header(connection)
            if "error" in answer or answer.get("md5sum") not in {"*", self.kind.md5sum}:
                raise LinkError(f"expected {self.kind.name}, found {answer.get('error') or answer.get('type')}")
        except BaseException:
            connection.close()
            raise
        connection.settimeout(None)
        return connection
