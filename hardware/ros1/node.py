"""A node of ROS 1: it tells the master what it publishes and hears, and answers other nodes by XML-RPC.

Source: http://wiki.ros.org/ROS/Master_API, http://wiki.ros.org/ROS/Slave_API.
"""

import contextlib
import http.client
import os
import socket
from collections.abc import Callable
from typing import Any
from urllib.parse import urlsplit
from xmlrpc.client import Error, ServerProxy

from hardware.closing import Closing
from hardware.errors import LinkError
from hardware.ros1.messages import MessageType
from hardware.ros1.publisher import Publisher, Server
from hardware.ros1.rpc import SUCCESS, RpcServer, TimedTransport
from hardware.ros1.subscription import Heard, Subscription

MASTER = "http://localhost:11311"


class Node(Closing):
    """A node; as a context manager it says goodbye to the master.

    Args:
        name: in ROS, with a slash ahead.
        master: address of the master; ``ROS_MASTER_URI`` by default.
        host: address at which others reach this computer; ``ROS_IP`` or ``ROS_HOSTNAME``, else the one by which it
            reaches the master.

    Raises:
        LinkError: when no master answers.
    """

    def __init__(self, name: str, master: str | None = None, host: str | None = None) -> None:
        self.name, self.master = name, master or os.environ.get("ROS_MASTER_URI", MASTER)
        self.host = host or os.environ.get("ROS_IP") or os.environ.get("ROS_HOSTNAME") or self._own_address()
        self._publishers: dict[str, Publisher] = {}
        self._subscriptions: dict[str, Subscription] = {}
        self._ask_master("getPid")
        self._server = Server(self.host, self._publishers)
        self._slave = RpcServer(self.host, _Answers(self).methods())
        self.uri = f"http://{self.host}:{self._slave.port}/"

    def advertise(self, topic: str, kind: MessageType) -> Publisher:
        """Publish messages of a type under a topic."""
        publisher = self._publishers[topic] = Publisher(topic, kind, self.name)
        self._ask_master("registerPublisher", topic, kind.name, self.uri)
        return publisher

    def subscribe(self, topic: str, kind: MessageType, heard: Heard) -> Subscription:
        """Call ``heard`` with every message of a topic, from threads of this node's own."""
        subscription = self._subscriptions[topic] = Subscription(topic, kind, self.name, heard, self._where)
        subscription.follow(self._ask_master("registerSubscriber", topic, kind.name, self.uri))
        return subscription

    def close(self) -> None:
        """Tell the master and let go of all connections; it may be called twice."""
        for topic, publisher in self._publishers.items():
            publisher.close()  # first: subscribers whom the master tells of it hear no more
            self._leave("unregisterPublisher", topic)
        for topic, subscription in self._subscriptions.items():
            self._leave("unregisterSubscriber", topic)
            subscription.close()
        self._publishers.clear()
        self._subscriptions.clear()
        self._server.close()
        self._slave.close()

    def publisher_update(self, topic: str, publishers: list[str]) -> None:
        """The master tells who publishes a topic now."""
        if topic in self._subscriptions:
            self._subscriptions[topic].follow(publishers)

    def request_topic(self, topic: str) -> list[Any]:
        """Another node asks where a topic is sent; an empty list where it is not."""
        return ["TCPROS", self.host, self._server.port] if topic in self._publishers else []

    def _leave(self, method: str, topic: str) -> None:
        with contextlib.suppress(LinkError):  # the master may have gone before
            self._ask_master(method, topic, self.uri)

    def _where(self, publisher: str, topic: str) -> tuple[str, int]:
        answer = self._call(publisher, "requestTopic", topic, [["TCPROS"]])
        if not (isinstance(answer, list) and len(answer) == 3 and answer[0] == "TCPROS"):
            raise LinkError(f"{publisher} does not send {topic} by TCPROS")
        return str(answer[1]), int(answer[2])

    def _ask_master(self, method: str, *arguments: Any) -> Any:
        try:
            return self._call(self.master, method, *arguments)
        except LinkError as error:
            raise LinkError(f"{error}; is roscore running, and is ROS_MASTER_URI its address?") from None

    def _call(self, address: str, method: str, *arguments: Any) -> Any:
        try:
            proxy = ServerProxy(address, transport=TimedTransport())
            code, message, value = getattr(proxy, method)(self.name, *arguments)
        except (OSError, Error, http.client.HTTPException, TypeError, ValueError) as error:
            raise LinkError(f"{address} does not answer {method}: {error}") from None
        if code != SUCCESS:
            raise LinkError(f"{address} refuses {method}: {message}")
        return value

    def _own_address(self) -> str:
        """By which this computer reaches the master; a datagram socket that is connected sends nothing."""
        place = urlsplit(self.master)
        try:
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
                probe.connect((place.hostname or "localhost", place.port or 11311))
                return str(probe.getsockname()[0])
        except (OSError, ValueError) as error:
            raise LinkError(f"expected a ROS master at {self.master}, found no way there: {error}") from None


class _Answers:
    """What other nodes and the master may call; every answer is a code, words and a value."""

    def __init__(self, node: Node) -> None:
        self._node = node

    def methods(self) -> dict[str, Callable[..., list[Any]]]:
        """The methods by their names in ROS."""
        return {
            "requestTopic": self._request_topic,
            "publisherUpdate": self._publisher_update,
            "getPid": lambda _: [SUCCESS, "", os.getpid()],
            "getMasterUri": lambda _: [SUCCESS, "", self._node.master],
            "getBusInfo": lambda _: [SUCCESS, "", []],
            "getBusStats": lambda _: [SUCCESS, "", [[], [], []]],
        }

    def _request_topic(self, _: str, topic: str, protocols: list[list[Any]]) -> list[Any]:
        where = self._node.request_topic(topic) if ["TCPROS"] in [entry[:1] for entry in protocols] else []
        return [SUCCESS, "", where] if where else [0, f"no TCPROS for {topic}", 0]

    def _publisher_update(self, _: str, topic: str, publishers: list[str]) -> list[Any]:
        self._node.publisher_update(topic, publishers)
        return [SUCCESS, "", 0]
