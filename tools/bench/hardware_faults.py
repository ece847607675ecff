"""What happens when a part of the hardware loop fails in flight, over UDP.

A geometric hover, broken in flight; the time is from the fault to the first control period that is no longer "go". A
killed script is seen from the robot: level, then motors off.

    python tools/bench/hardware_faults.py
"""

from __future__ import annotations

import math
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tyro
from figures import Figure, report
from repeated import print_table

from hardware.crazyflie.link import CrazyflieLink
from hardware.crazyflie.thrust_map import THRUST_MAPS
from hardware.fakes.capture import FakeCapture
from hardware.fakes.crazyflie import FakeCrazyflie
from hardware.fakes.vehicle import LEVEL, OFF
from hardware.pilot import FlightPilot
from hardware.plant import HardwarePlant
from hardware.recorder import Recorder
from hardware.safety import Limits
from sym2real.control import geometric_controller
from sym2real.logs.table import read_table
from sym2real.protocols import Controller, Memoryless
from sym2real.robots import CRAZYFLIE
from sym2real.tasks import make_task
from sym2real.trajectory import Array

LIMITS, MAP = Limits(), THRUST_MAPS["2025.02"]
KILLED = "killed.parquet"
BEFORE, LONGEST = 1.5, 20.0  # s of hover before a fault, and of waiting for what follows


class Scene(Memoryless):
    """A hover that something is going to happen to, seen as a controller.

    Attributes:
        fake: the robot.
        broken: when the fault was injected, s; NaN before.
        pause: s that an action takes longer than it must.
    """

    def __init__(self, fake: FakeCrazyflie, controller: Controller) -> None:
        self.fake, self._controller, self.broken = fake, controller, math.nan
        self.pause = 0.0

    def suffer(self, fault: Fault) -> None:
        """Let it happen, and note when."""
        self.broken = time.monotonic()
        fault.inject(self)

    def act(self, state: Array, step: int, inputs: Array | None = None) -> Array:
        """The controller's action, late where that is the fault."""
        time.sleep(self.pause)
        return self._controller.act(state, step)


@dataclass(frozen=True)
class Fault:
    """What happens, what must follow, and how long its documented threshold is in s."""

    name: str
    inject: Callable[[Scene], None]
    phase: str
    threshold: float


def _put(*pose: float) -> Callable[[Scene], None]:
    """Put the robot at a position and attitude, at rest."""
    return lambda scene: scene.fake.do(lambda vehicle: vehicle.place(np.array([*pose, *[0.0] * 6])))


def _break(what: str) -> Callable[[Scene], None]:
    return lambda scene: setattr(scene.fake, what, True)


def _empty(scene: Scene) -> None:
    scene.fake.do(lambda vehicle: vehicle.drain_to(LIMITS.battery - 0.1))


def _dawdle(scene: Scene) -> None:
    scene.pause = 0.3


BLIND = "blind landing"
FAULTS = (
    Fault("motion capture lost", _break("blind"), BLIND, LIMITS.pose_age),
    Fault("log stale", _break("without_log"), BLIND, LIMITS.attitude_age),
    Fault("link muted", _break("muted"), BLIND, LIMITS.attitude_age),
    Fault("port refused", lambda scene: scene.fake.close(), BLIND, LIMITS.pose_age),
    Fault("battery low", _empty, "land", LIMITS.battery_time),
    Fault("fence", _put(1.6, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0), "land", 0.0),
    Fault("tumble", _put(0.0, 0.0, 0.8, 0.0, 1.0, 0.0, 0.0), "cut", 0.0),
    Fault("overrun", _dawdle, "land", LIMITS.late + CRAZYFLIE.dt),
    Fault("Ctrl-C", lambda scene: signal.raise_signal(signal.SIGINT), "land", 0.0),
)


def flown_until(fault: Fault, folder: Path) -> tuple[float, str, int]:
    """Seconds from a fault until the flight is no longer "go", its phase then, and the record's rows."""
    capture, record = FakeCapture(), folder / f"{fault.name}.parquet"
    with FakeCrazyflie(poses_to=capture.address) as fake, CrazyflieLink(fake.uri, capture, MAP) as link:
        link.connect()
        scene = Scene(fake, hover_controller())
        try:
            with Recorder(record, CRAZYFLIE, {}) as recorder, pilot_of(link, recorder) as plant:
                hover(plant, scene, lambda: scene.suffer(fault))
        except KeyboardInterrupt:
            pass
    log = read_table(record)
    ended = int(np.flatnonzero(log.columns["verdict"] > 0)[0])
    return float(log.columns["clock"][ended]) - scene.broken, phase_at(record, ended), len(log)


def phase_at(record: Path, row: int) -> str:
    """The phase in words, which readers of numbers leave out."""
    from sym2real.logs.parquet_file import read

    names, cells, *_ = read(record)
    return str(cells[names.index("phase")][row])


def pilot_of(link: CrazyflieLink, recorder: Recorder) -> HardwarePlant:
    """A plant that records."""
    return HardwarePlant(link, FlightPilot(CRAZYFLIE), record=recorder.add)


def hover_controller() -> Controller:
    """Geometric, half a metre up: its actions cost nothing."""
    return geometric_controller(CRAZYFLIE, make_task("hover", CRAZYFLIE, goal=(0.0, 0.0, 0.5)).reference)


def hover(plant: HardwarePlant, controller: Controller, happen: Callable[[], None] = lambda: None) -> None:
    """Hover until the flight ends; after a while something happens, once."""
    place = CRAZYFLIE.start.copy()
    place[2] = 0.5
    state = plant.reset(place)
    for step in range(round(LONGEST / CRAZYFLIE.dt)):
        if step == round(BEFORE / CRAZYFLIE.dt):
            happen()
        state = plant.step(controller.act(state, step))
        if plant.crashed:
            return


def killed(folder: Path) -> tuple[float, float, int]:
    """Seconds from kill -9 of a flying script until the robot levels, until its motors stop, and the record's rows."""
    capture = FakeCapture()
    port = capture.address[1]
    capture.close()
    with FakeCrazyflie(poses_to=("127.0.0.1", port)) as fake:
        code = f"import hardware_faults; hardware_faults.fly_on({fake.uri!r}, {port}, {str(folder / KILLED)!r})"
        script = subprocess.Popen([sys.executable, "-c", code], cwd=Path(__file__).parent)
        begin = time.monotonic()
        while fake.vehicle.state[2] < 0.45 and script.poll() is None and time.monotonic() - begin < 60.0:
            time.sleep(0.02)
        time.sleep(BEFORE)
        script.kill()
        script.wait()
        quiet = [_when(fake, lambda: fake.vehicle.silence > LEVEL), _when(fake, lambda: fake.vehicle.thrust == 0.0)]
        return quiet[0], quiet[1], len(read_table((folder / KILLED).with_suffix(".arrow")))


def _when(fake: FakeCrazyflie, holds: Callable[[], bool]) -> float:
    """Seconds of silence after which something holds."""
    begin = time.monotonic()
    while not holds() and time.monotonic() - begin < LONGEST:
        time.sleep(0.002)
    return fake.vehicle.silence


def fly_on(uri: str, port: int, record: str) -> None:
    """Hover until somebody kills this process."""
    with CrazyflieLink(uri, FakeCapture(port), MAP) as link:
        link.connect()
        with Recorder(record, CRAZYFLIE, {}) as recorder, pilot_of(link, recorder) as plant:
            hover(plant, hover_controller())


def faults() -> list[Figure]:
    """Inject every fault once; a figure for how late each was answered."""
    figures, rows = [], list[Sequence[str]]()
    with tempfile.TemporaryDirectory() as name:
        for fault in FAULTS:
            after, phase, kept = flown_until(fault, Path(name))
            rows.append((fault.name, phase, f"{after:.3f}", f"{fault.threshold:.2f}", str(kept)))
            beyond = after - fault.threshold if phase == fault.phase else math.inf
            figures.append(Figure(f"{fault.name}: {fault.phase}, beyond its threshold", beyond, "s", "<= 0.5"))
        level, off, kept = killed(Path(name))
    rows.append(("kill -9 of the script", "level, then off", f"{level:.3f}, {off:.3f}", f"{LEVEL}, {OFF}", str(kept)))
    print_table("Faults injected", ("fault", "state entered", "after s", "threshold s", "rows of the record"), rows)
    figures.append(Figure("kill -9: level, beyond 0.5 s", level - LEVEL, "s", "<= 0.5"))
    return [*figures, Figure("kill -9: motors off, beyond 2 s", off - OFF, "s", "<= 0.5")]


def main(json: Path | None = None) -> None:
    """Inject every fault once.

    Args:
        json: write the figures to this file (- is standard output).
    """
    report("Faults in flight, over UDP", faults(), [], json)


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
