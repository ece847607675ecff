"""Real ROS 1 beside the tests: rosmaster, and scripts on rospy, in processes of the system's Python."""

import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event, Thread

import pytest

from hardware.errors import LinkError
from hardware.fakes.master import FakeMaster
from hardware.ros1 import Node

SYSTEM_PYTHON = "/usr/bin/python3"  # Debian's rospy belongs to it
PATIENCE = 120.0  # s; a busy machine takes its time
PACKAGES = "python3-rospy python3-rosmaster python3-geometry-msgs python3-rosbag"


def require_ros() -> None:
    """Skip where ROS 1 is not installed."""
    if shutil.which("rosmaster") is None:
        pytest.skip(f"ROS 1 is not here: apt-get install --no-install-recommends {PACKAGES}")


@contextmanager
def master() -> Iterator[str]:
    """The address of a rosmaster on a free port; of the fake one where ROS is not installed."""
    if shutil.which("rosmaster") is None:
        with FakeMaster() as fake:
            yield fake.uri
        return
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    uri = f"http://127.0.0.1:{port}"
    process = subprocess.Popen(
        ["rosmaster", "--core", "-p", str(port)], env=environment(uri), stdout=subprocess.DEVNULL
    )
    try:
        wait_for(lambda: answers(uri))
        yield uri
    finally:
        process.terminate()
        process.wait(PATIENCE)


def environment(uri: str) -> dict[str, str]:
    """For processes of ROS: without this Python's paths."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    return {**kept, "ROS_MASTER_URI": uri, "ROS_IP": "127.0.0.1", "PATH": f"/usr/bin:{kept.get('PATH', '')}"}


def answers(uri: str) -> bool:
    """Whether a master answers there."""
    try:
        Node("/probe", uri, "127.0.0.1").close()
    except LinkError:
        return False
    return True


def rospy_script(uri: str, text: str, *arguments: str | Path) -> subprocess.Popen[str]:
    """A script on the system's Python with rospy; its words come by the pipe."""
    require_ros()
    command = [SYSTEM_PYTHON, "-u", "-c", text, *map(str, arguments)]
    return subprocess.Popen(command, env=environment(uri), stdout=subprocess.PIPE, stderr=sys.stderr, text=True)


def wait_for(done: Callable[[], object], meanwhile: Callable[[], object] = lambda: None) -> None:
    """Wait until a call is true, doing something all the while; fail after :data:`PATIENCE`."""
    end = time.monotonic() + PATIENCE
    while not done():
        meanwhile()
        if time.monotonic() > end:
            pytest.fail(f"waited {PATIENCE:g} s in vain")
        time.sleep(0.01)


@contextmanager
def repeated(tell: Callable[[], object]) -> Iterator[None]:
    """A hundred times a second from a thread of its own, as long as the context lasts."""
    over = Event()

    def telling() -> None:
        while not over.wait(0.01):
            tell()

    thread = Thread(target=telling)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
