"""What ends a script in flight: a landing first; and the fake of --sim lives as long as its script."""

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from ros_peers import PATIENCE, wait_for

FLYING = """
import signal, time
from dataclasses import dataclass
from hardware.command_line import main

@dataclass
class Flying:
    "Flies."
    json: None = None

    def run(self, console):
        try:
            print("flying", flush=True)
            time.sleep(60)
        finally:
            print("landing", flush=True)
            time.sleep(1.0)
            print("landed", flush=True)

signal.signal(signal.SIGHUP, signal.SIG_DFL)  # whatever has started the tests may ignore it, as nohup does
main(Flying, "fly", "", [])
"""
BESIDE = """
import signal, time
from hardware.fakes.beside import beside
signal.signal(signal.SIGINT, signal.SIG_IGN)
with beside("hardware.fakes", []) as fake:
    print(fake.address, flush=True)
    time.sleep(600)
"""


@contextmanager
def started(text: str) -> Iterator[subprocess.Popen[str]]:
    """A script in a process group of its own, as a shell starts it; its words come by the pipe."""
    command, root = [sys.executable, "-c", text], Path(__file__).parents[1]
    with subprocess.Popen(command, cwd=root, stdout=subprocess.PIPE, text=True, process_group=0) as script:
        try:
            yield script
        finally:
            script.kill()


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGQUIT", "SIGHUP"])
def test_whatever_ends_a_script_lands_first(name: str) -> None:
    with started(FLYING) as script:
        assert script.stdout is not None and script.stdout.readline() == "flying\n"
        script.send_signal(signal.SIGTSTP)
        script.send_signal(signal.Signals[name])
        assert script.stdout.readline() == "landing\n"
        if name == "SIGHUP":  # the kernel's, after the shell's
            script.send_signal(signal.SIGHUP)
        assert script.stdout.readline() == "landed\n"
        assert script.wait(PATIENCE) == 130


def answers(address: str) -> bool:
    """Whether a fake robot is there."""
    host, port = address.removeprefix("udp://").split(":")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.settimeout(2.0)
        client.connect((host, int(port)))
        try:
            client.send(b"\xff")
            return bool(client.recv(100))
        except OSError:
            return False


def test_ctrl_c_does_not_reach_the_fake_which_ends_with_its_script() -> None:
    """The landing that it rehearses was blind; a script that is killed leaves nothing behind."""
    with started(BESIDE) as script:
        assert script.stdout is not None
        address = script.stdout.readline().strip()
        wait_for(lambda: answers(address))
        os.killpg(script.pid, signal.SIGINT)
        time.sleep(2.0)  # a fake that it reached would be gone
        assert answers(address)
        script.kill()
        script.wait(PATIENCE)
    wait_for(lambda: not answers(address))
