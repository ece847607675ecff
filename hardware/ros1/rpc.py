"""XML-RPC as ROS speaks it: answers are a code, words and a value; calls end in time."""

import http.client
import threading
from collections.abc import Callable, Mapping
from socketserver import ThreadingMixIn
from typing import Any
from xmlrpc.client import Transport
from xmlrpc.server import SimpleXMLRPCRequestHandler, SimpleXMLRPCServer

ANSWER = 3.0  # s for the master or another node to answer
SUCCESS = 1


class TimedTransport(Transport):
    """Calls that end in time."""

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        return http.client.HTTPConnection(self.get_host_info(host)[0], timeout=ANSWER)


class RpcServer:
    """Answers calls in threads of its own, on a free port.

    Args:
        host: address to listen at.
        methods: by their names in ROS.
    """

    def __init__(self, host: str, methods: Mapping[str, Callable[..., list[Any]]]) -> None:
        self._server = _ThreadingServer((host, 0), requestHandler=_Handler, logRequests=False, allow_none=True)
        for name, method in methods.items():
            self._server.register_function(method, name)
        self.port: int = self._server.server_address[1]
        threading.Thread(target=self._server.serve_forever, args=(0.05,), name="XML-RPC", daemon=True).start()

    def close(self) -> None:
        """Answer no more."""
        self._server.shutdown()
        self._server.server_close()


class _Handler(SimpleXMLRPCRequestHandler):
    rpc_paths = ()  # nodes call "/" and "/RPC2"
    protocol_version = "HTTP/1.1"
    timeout = ANSWER


class _ThreadingServer(ThreadingMixIn, SimpleXMLRPCServer):
    daemon_threads = True  # a peer that keeps its connection open must not hold up the others
