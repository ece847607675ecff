"""TCPROS on one socket: a header of ``key=value`` fields, then messages, each behind its length (uint32).

Source: http://wiki.ros.org/ROS/TCPROS.
"""

import socket
import struct

from hardware.errors import LinkError

LENGTH = struct.Struct("<I")
LONGEST = 1 << 20  # bytes; poses and commands have a hundred


def write_header(connection: socket.socket, fields: dict[str, str]) -> None:
    """Send a connection's header."""
    texts = [f"{key}={value}".encode() for key, value in fields.items()]
    content = b"".join(LENGTH.pack(len(text)) + text for text in texts)
    connection.sendall(LENGTH.pack(len(content)) + content)


def read_header(connection: socket.socket) -> dict[str, str]:
    """A connection's header.

    Raises:
        LinkError: when it is none, or the other side closes.
    """
    content, fields, place = read_block(connection), {}, 0
    while place < len(content):
        if place + LENGTH.size > len(content):
            raise LinkError("expected a TCPROS header, found one that breaks off")
        (length,) = LENGTH.unpack_from(content, place)
        text = content[place + LENGTH.size : place + LENGTH.size + length].decode(errors="replace")
        key, separator, value = text.partition("=")
        if not separator:
            raise LinkError(f"expected key=value in a TCPROS header, found {text[:40]!r}")
        fields[key] = value
        place += LENGTH.size + length
    return fields


def read_block(connection: socket.socket) -> bytes:
    """The next bytes behind a length.

    Raises:
        LinkError: when the other side closes, or the length is absurd.
    """
    (length,) = LENGTH.unpack(_exactly(connection, LENGTH.size))
    if length > LONGEST:
        raise LinkError(f"expected a message of at most {LONGEST} bytes, found a length of {length}")
    return _exactly(connection, length)


def write_block(connection: socket.socket, content: bytes) -> None:
    """Send bytes behind their length."""
    connection.sendall(LENGTH.pack(len(content)) + content)


def _exactly(connection: socket.socket, count: int) -> bytes:
    parts = bytearray()
    while len(parts) < count:
        part = connection.recv(count - len(parts))
        if not part:
            raise LinkError("the other side closed the connection")
        parts += part
    return bytes(parts)
