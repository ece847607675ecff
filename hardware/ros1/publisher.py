"""What a node publishes: every subscriber gets the newest message; one that is slow misses some and delays nobody."""

import contextlib
import socket
import threading
import time

from hardware.errors import LinkError
from hardware.ros1.connection import read_header, write_block, write_header
from hardware.ros1.messages import Message, MessageType

GOODBYE = 0.5  # s for the last messages: a car's zeros
GIVE_UP = 2.0  # s that a subscriber may take to accept a message, or to say who it is


class Publisher:
    """A topic of a node.

    Args:
        topic: its name.
        kind: of its messages.
        caller: name of the node.
    """

    def __init__(self, topic: str, kind: MessageType, caller: str) -> None:
        self.topic, self.kind, self._caller = topic, kind, caller
        self._subscribers: set[_Subscriber] = set()
        self._lock = threading.Lock()
        self._sequence = 0
        self._closed = False

    @property
    def subscribers(self) -> int:
        """How many are connected."""
        with self._lock:
            return len(self._subscribers)

    def publish(self, message: Message) -> None:
        """Hand a message to all who are connected; it never waits for them."""
        content = self.kind.encode(message, self._sequence)
        self._sequence += 1
        with self._lock:
            for subscriber in self._subscribers:
                subscriber.offer(content)

    def serve(self, connection: socket.socket, asked: dict[str, str]) -> None:
        """Answer a subscriber's header, and send it messages until it goes.

        Raises:
            LinkError: when it means other messages.
        """
        if asked.get("md5sum") not in {"*", self.kind.md5sum}:
            write_header(connection, {"error": f"{self.topic} is {self.kind.name} with md5sum {self.kind.md5sum}"})
            raise LinkError(f"a subscriber of {self.topic} expects md5sum {asked.get('md5sum')}")
        about = {"type": self.kind.name, "md5sum": self.kind.md5sum, "message_definition": self.kind.definition}
        write_header(connection, {"callerid": self._caller, "topic": self.topic, "latching": "0", **about})
        subscriber = _Subscriber(connection)
        with self._lock:
            if self._closed:
                return
            self._subscribers.add(subscriber)
        try:
            subscriber.run()
        finally:
            subscriber.gone.set()
            with self._lock:
                self._subscribers.discard(subscriber)

    def close(self) -> None:
        """Send what is waiting, for a moment at most, then let go of all subscribers."""
        with self._lock:
            self._closed = True
            leaving = list(self._subscribers)
        for subscriber in leaving:
            subscriber.finish()
        deadline = time.monotonic() + GOODBYE
        for subscriber in leaving:
            subscriber.gone.wait(max(0.0, deadline - time.monotonic()))


class _Subscriber:
    """One connection, with room for one message that is not sent yet."""

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self._changed = threading.Condition()
        self._waiting: bytes | None = None
        self._finished = False
        self.gone = threading.Event()

    def offer(self, content: bytes) -> None:
        with self._changed:
            self._waiting = content
            self._changed.notify()

    def finish(self) -> None:
        with self._changed:
            self._finished = True
            self._changed.notify()

    def run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting is not None or self._finished)
                content, self._waiting = self._waiting, None
            if content is None:
                return
            write_block(self._connection, content)


class Server:
    """The socket at which a node's subscribers come in.

    Args:
        host: address that they reach this computer at.
        publishers: by topic; may grow.
    """

    def __init__(self, host: str, publishers: dict[str, Publisher]) -> None:
        self._publishers = publishers
        self._socket = socket.create_server((host, 0))
        self.port: int = self._socket.getsockname()[1]
        threading.Thread(target=self._accept, name="TCPROS server", daemon=True).start()

    def close(self) -> None:
        """Take no more."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._socket.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(connection,), name="TCPROS publisher", daemon=True).start()

    def _serve(self, connection: socket.socket) -> None:
        with connection, contextlib.suppress(OSError, LinkError):  # a subscriber that goes, or that we cannot serve
            connection.settimeout(GIVE_UP)
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            asked = read_header(connection)
            publisher = self._publishers.get(asked.get("topic", ""))
            if publisher is None:
                write_header(connection, {"error": f"this node does not publish {asked.get('topic')}"})
            else:
                publisher.serve(connection, asked)
