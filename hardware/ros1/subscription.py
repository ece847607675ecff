"""What a node hears of a topic: one connection to every publisher that the master tells of."""

import contextlib
import logging
import socket
import threading
from collections.abc import Callable, Iterable
from typing import Any

from hardware.errors import LinkError
from hardware.ros1.connection import read_block, read_header, write_header
from hardware.ros1.messages import Message, MessageType

LOGGER = logging.getLogger(__name__)
CONNECTING = 2.0  # s for a publisher to answer
Heard = Callable[[Message], None]
Ask = Callable[[str, str], tuple[str, int]]


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
        self._connections: dict[str, socket.socket | None] = {}
        self._lock = threading.Lock()
        self._hearing = threading.RLock()  # who listens may close its node
        self._closed = False

    def follow(self, publishers: Iterable[str]) -> None:
        """Connect to those of these XML-RPC addresses that are new, and leave those that are gone."""
        wanted = set(publishers)
        with self._lock:
            new = [] if self._closed else [address for address in wanted if address not in self._connections]
            gone = [self._connections.pop(address) for address in [*self._connections] if address not in wanted]
            self._connections |= dict.fromkeys(new)
        for connection in gone:
            _hang_up(connection)
        for address in new:
            threading.Thread(target=self._listen, args=(address,), name=f"hears {self.topic}", daemon=True).start()

    def close(self) -> None:
        """Leave all publishers; nothing is heard afterwards."""
        with self._hearing:
            self._closed = True
        self.follow(())

    def _listen(self, publisher: str) -> None:
        connection = None
        try:
            connection = self._connect(publisher)
            with self._lock:
                if publisher not in self._connections:  # it has left meanwhile
                    return
                self._connections[publisher] = connection
            while self._hear(self.kind.decode(read_block(connection))):
                pass
        except (OSError, LinkError) as error:
            if not self._closed:
                LOGGER.warning("%s from %s: %s", self.topic, publisher, error)
        finally:
            if connection is not None:
                connection.close()
            with self._lock:
                if self._connections.get(publisher) is connection:
                    self._connections.pop(publisher, None)

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


def _hang_up(connection: socket.socket | None) -> None:
    """Who listens there still reads what has come, such as a car's last zeros, and closes it then."""
    if connection is not None:
        with contextlib.suppress(OSError):
            connection.shutdown(socket.SHUT_RDWR)
