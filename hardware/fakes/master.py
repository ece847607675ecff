"""A ROS 1 master for ``--sim`` and tests, where no roscore is installed: it knows topics, and nothing else.

Source: http://wiki.ros.org/ROS/Master_API.
"""

import contextlib
import os
import threading
from collections import defaultdict
from collections.abc import Callable
from typing import Any
from xmlrpc.client import Error, ServerProxy

from hardware.closing import Closing
from hardware.ros1.rpc import SUCCESS, RpcServer, TimedTransport


class FakeMaster(Closing):
    """A master on a free port of this machine; as a context manager it ends."""

    def __init__(self) -> None:
        self._publishers: defaultdict[str, dict[str, str]] = defaultdict(dict)  # topic → address → type
        self._subscribers: defaultdict[str, dict[str, str]] = defaultdict(dict)
        self._lock = threading.Lock()
        self._server = RpcServer("127.0.0.1", self._methods())
        self.uri = f"http://127.0.0.1:{self._server.port}"

    def close(self) -> None:
        """End."""
        self._server.close()

    def _methods(self) -> dict[str, Callable[..., list[Any]]]:
        return {
            "getPid": lambda _: [SUCCESS, "", os.getpid()],
            "registerPublisher": self._register_publisher,
            "registerSubscriber": self._register_subscriber,
            "unregisterPublisher": self._unregister_publisher,
            "unregisterSubscriber": self._unregister_subscriber,
            "getTopicTypes": self._topic_types,
        }

    def _register_publisher(self, _: str, topic: str, kind: str, address: str) -> list[Any]:
        with self._lock:
            self._publishers[topic][address] = kind
            subscribers = list(self._subscribers[topic])
        self._tell(topic)
        return [SUCCESS, "", subscribers]

    def _register_subscriber(self, _: str, topic: str, kind: str, address: str) -> list[Any]:
        with self._lock:
            self._subscribers[topic][address] = kind
            return [SUCCESS, "", list(self._publishers[topic])]

    def _unregister_publisher(self, _: str, topic: str, address: str) -> list[Any]:
        with self._lock:
            gone = self._publishers[topic].pop(address, None)
        self._tell(topic)
        return [SUCCESS, "", int(gone is not None)]

    def _unregister_subscriber(self, _: str, topic: str, address: str) -> list[Any]:
        with self._lock:
            return [SUCCESS, "", int(self._subscribers[topic].pop(address, None) is not None)]

    def _topic_types(self, _: str) -> list[Any]:
        with self._lock:
            known = {**self._subscribers, **self._publishers}
            return [SUCCESS, "", [[topic, next(iter(users.values()))] for topic, users in known.items() if users]]

    def _tell(self, topic: str) -> None:
        """Subscribers hear who publishes now, each from a thread of its own: one that is gone delays nobody."""
        with self._lock:
            publishers, subscribers = list(self._publishers[topic]), list(self._subscribers[topic])
        for address in subscribers:
            threading.Thread(target=_update, args=(address, topic, publishers), daemon=True).start()


def _update(address: str, topic: str, publishers: list[str]) -> None:
    with contextlib.suppress(OSError, Error):
        ServerProxy(address, transport=TimedTransport()).publisherUpdate("/master", topic, publishers)
