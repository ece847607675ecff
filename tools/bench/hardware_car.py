"""The car over ROS 1: how even its commands arrive, what a bag keeps of them, what kill -9 costs, and how it adapts.

Timing and bag: rosmaster, rospy and rosbag as Debian ships them, in processes of the system's Python. Adaptation:
drives in real time over ROS on a fake car whose steering is off by 0.1 rad and whose commands take 200 ms, put back to
the start by hand in between.

    python tools/bench/hardware_car.py
"""

import json
import logging
import math
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tyro
from figures import Figure, report

from hardware.errors import LinkError
from hardware.fakes.master import FakeMaster
from hardware.fakes.mushr import POSES, Car, FakeMushr, Truth
from hardware.interfaces import RobotLink
from hardware.mushr import DriveLimits, DrivePilot
from hardware.mushr.laboratory import BEHIND, MushrLaboratory
from hardware.mushr.link import COMMANDS
from hardware.plant import HardwarePlant, Row
from hardware.ros1 import Node
from sym2real.adaptation.episode_report import position_errors
from sym2real.logs import LogSpec, read_log
from sym2real.logs.table import read_table
from sym2real.robots import MUSHR
from sym2real.symbolic.storage import save_model

ROOT = Path(__file__).resolve().parents[2]
LOOPBACK, SYSTEM_PYTHON = "127.0.0.1", "/usr/bin/python3"
MESSAGES, WAITING = 100, 60.0
# Room for a first drive with a wrong model; lateness is measured, not punished.
ROOMY = DriveLimits(low=(-6.0, -6.0), high=(6.0, 6.0), pose_age=1.0, late=2.0, overruns=1000)
ROOMY_OPTIONS = ["--limits.low", "-6", "-6", "--limits.high", "6", "6", "--limits.pose-age", "1"]
ROOMY_OPTIONS += ["--limits.late", "2", "--limits.overruns", "1000"]
START = (1.5, -BEHIND, math.pi / 2)
OFFSET, LATENCY, DRIVES = 0.1, 0.2, 3
COLUMNS = f'[columns]\nsteer = "{COMMANDS}.drive.steering_angle"\nspeed = "{COMMANDS}.drive.speed"\n' + "".join(
    f'{axis} = "{POSES}.pose.position.{axis}"\n' for axis in "xy"
)
LISTEN = """
import json, sys, time
import rospy
stamps = []
rospy.init_node("listener", disable_signals=True)
rospy.Subscriber(sys.argv[1], rospy.AnyMsg, lambda _: stamps.append(time.monotonic()), tcp_nodelay=True)
print("ready")
while len(stamps) <= int(sys.argv[2]):
    time.sleep(0.01)
print(json.dumps(stamps))
"""


@dataclass(frozen=True)
class Options:
    """Measure the car's commands over ROS, and adapt a model to a car that differs.

    Args:
        adapt_only: leave ROS and kill -9 out.
        seconds: length of a drive; the paper authors' take 20 s.
        seeds: of the starts, MPPI's samples and the networks: an adaptation for each.
        json: write the figures to this file (- is standard output).
    """

    adapt_only: bool = False
    seconds: float = 20.0
    seeds: int = 3
    json: Path | None = None


@contextmanager
def rosmaster() -> Iterator[tuple[str, dict[str, str]]]:
    """Address of a real master, and the environment of those who are to find it."""
    with socket.socket() as free:
        free.bind((LOOPBACK, 0))
        port = free.getsockname()[1]
    uri = f"http://{LOOPBACK}:{port}"
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    known = {**kept, "ROS_MASTER_URI": uri, "ROS_IP": LOOPBACK, "PATH": f"/usr/bin:{kept.get('PATH', '')}"}
    process = subprocess.Popen(["rosmaster", "--core", "-p", str(port)], env=known, stdout=subprocess.DEVNULL)
    try:
        wait_for(lambda: _answers(uri))
        yield uri, known
    finally:
        process.terminate()
        process.wait()


def _answers(uri: str) -> bool:
    try:
        Node("/probe", uri, LOOPBACK).close()
    except LinkError:
        return False
    return True


def wait_for(done: Callable[[], bool]) -> None:
    """Wait until a call is true."""
    end = time.monotonic() + WAITING
    while not done():
        if time.monotonic() > end:
            raise LinkError(f"waited {WAITING:g} s in vain")
        time.sleep(0.005)


@contextmanager
def connected(uri: str, car: Car) -> Iterator[RobotLink]:
    """A link to a fake car."""
    there = MushrLaboratory(master=uri, host=LOOPBACK).open(MUSHR.start, print)
    with FakeMushr(Node("/fake_mushr", uri, LOOPBACK), car), there as opened:
        opened.link.connect()
        yield opened.link


def over_ros(folder: Path) -> list[Figure]:
    """A drive of constant commands that rospy hears and rosbag records."""
    bag, rows = folder / "drive.bag", list[Row]()
    with rosmaster() as (uri, known), connected(uri, Car(Truth(start=START))) as link:
        listener = subprocess.Popen([SYSTEM_PYTHON, "-u", "-c", LISTEN, COMMANDS, str(MESSAGES)], env=known,
                                    stdout=subprocess.PIPE, text=True)  # fmt: skip
        recorder = subprocess.Popen(["rosbag", "record", "-O", str(bag), COMMANDS, POSES], env=known,
                                    stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip
        listener.stdout.readline()
        wait_for(lambda: link._publisher.subscribers == 3)  # the car, rospy, rosbag
        with HardwarePlant(link, DrivePilot(link.robot, ROOMY), record=rows.append) as plant:
            plant.reset([1.5, -0.2, 1.0, 0.0, 0.0, 0.0, 0.0])
            for number in range(MESSAGES + 60):
                plant.step([0.15 + 0.05 * math.sin(0.2 * number), 0.6])
        arrived = np.array(json.loads(listener.stdout.readline()))
        recorder.send_signal(signal.SIGINT)
        recorder.wait(WAITING)
    periods = 1000.0 * np.diff(arrived)[-MESSAGES:]
    return [
        Figure(f"commands at rospy, mean period of {MESSAGES}", float(periods.mean()), "ms", "49.5 to 50.5"),
        Figure("their standard deviation", float(periods.std()), "ms", "<= 0.5"),
        *kept(bag, rows),
    ]


def kept(bag: Path, rows: list[Row]) -> list[Figure]:
    """What a bag holds of what was sent."""
    log = read_log(bag, LogSpec.parse(COLUMNS))
    sent = {tuple(row.sent.tolist()) for row in rows if row.stage == "task"}
    seen = {tuple(action) for action in log.action.tolist()}
    return [
        Figure("rows read back from rosbag's bag", len(log), "", f">= {MESSAGES}"),
        Figure("different commands sent that it holds, bit by bit", len(sent & seen) / len(sent), "", ">= 0.99"),
    ]


def killed(folder: Path) -> list[Figure]:
    """kill -9 of the launch script in the task: how long until the wheels stand, and what the record holds."""
    with FakeMaster() as master, FakeMushr(Node("/fake_mushr", master.uri), Car(Truth(start=START))) as fake:
        command = [sys.executable, "-m", "hardware.run", "mushr", str(folder / "model"), "circle"]
        command += ["--seconds", "300", "--master", master.uri, "--out", str(folder / "killed"), *ROOMY_OPTIONS]
        script = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL)
        wait_for(lambda: fake.car.driven[1] > 0.8 or script.poll() is not None)
        speed = float(fake.car.driven[1])
        script.kill()
        begin = time.monotonic()
        wait_for(lambda: not fake.car.driven[1])
        after = time.monotonic() - begin
        script.wait()
    rows = len(read_table(folder / "killed" / "drive.arrow"))
    most = 0.2 + speed / 2.5
    return [
        Figure(f"kill -9: the wheels stand, beyond 0.2 s and braking ({most:.2f} s)", after - most, "s", "<= 0.5"),
        Figure("kill -9: rows of the record", rows, "", ">= 20"),
    ]


def adapted(folder: Path, seconds: float, seed: int) -> list[Figure]:
    """Drives with MPPI on the command line: with the model as it was given, then with what it has learned."""
    out, steps = folder / f"adapted_{seed}", round(seconds / MUSHR.dt)
    command = [sys.executable, "-m", "hardware.adapt", "mushr", str(folder / "model"), "circle", "--sim", "--effects"]
    command += ["offset:steer", f"value={OFFSET}", "--latency", str(LATENCY), "--rounds", str(DRIVES - 1)]
    command += ["--all-rounds", "--seconds", str(seconds), "--seed", str(seed), "--out", str(out), *ROOMY_OPTIONS]
    subprocess.run(command, cwd=ROOT, stdout=subprocess.DEVNULL, check=True)
    reports = json.loads((out / "adaptation.json").read_text())["rounds"]
    settled = [_second_half(out / "rounds" / f"{number:02d}" / "log.parquet") for number in range(DRIVES)]
    missed = read_table(out / "records" / "drive_1.parquet").columns["missed"].sum()
    named = f"offset 0.1 rad and 200 ms, seed {seed}"
    bars = [""] * (DRIVES - 1) + ["<= 0.15"]
    return [
        *(
            Figure(f"{named}, drive {one['number'] + 1}", one["error"], "m", bar)
            for one, bar in zip(reports, bars, strict=True)
        ),
        *(Figure(f"{named}, second half of drive {number}", value, "m") for number, value in enumerate(settled, 1)),
        Figure(f"{named}, periods missed", float(missed), f"of {DRIVES * steps}"),
    ]


def _second_half(log: Path) -> float:
    errors = position_errors(read_log(log, layouts=MUSHR.layouts))
    return float(errors[len(errors) // 2 :].mean())


def car(options: Options) -> list[Figure]:
    """All figures of the car."""
    logging.getLogger("hardware.ros1").setLevel(logging.ERROR)  # nodes come and go
    figures = []
    with tempfile.TemporaryDirectory() as name:
        save_model(MUSHR.nominal(), Path(name) / "model")
        if not options.adapt_only:
            figures += over_ros(Path(name)) if shutil.which("rosmaster") else []
            figures += killed(Path(name))
        for seed in range(options.seeds):
            figures += adapted(Path(name), options.seconds, seed)
        return figures


def main(options: Options) -> None:
    """Print the table; write the figures."""
    report("The car over ROS 1", car(options), range(options.seeds), options.json)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
