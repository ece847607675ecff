"""Two flights and a diagnosis: a drone too heavy and too weak is named, and flies better with what was found."""

from pathlib import Path

import pytest

from hardware.pilot import FlightPilot
from hardware.plant import HardwarePlant
from hardware.recorder import Recorder, task_of
from sym2real.control import mppi_controller
from sym2real.dataset import Dataset
from sym2real.diagnosis import add, diagnose
from sym2real.effects import effect
from sym2real.experiments.flying import Flight, fly
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic import Equations
from sym2real.tasks import make_task
from tests.hardware_link import SimulatedLink, TestClock

HIDDEN = {"added_mass": 0.005, "gain:thrust": 0.79}
SECONDS = 22.0


def flown(model: Equations, record: Path) -> Flight:
    """A flight on a clock that nobody waits for, through pilot, plant and recorder."""
    clock, task = TestClock(), make_task("circle", CRAZYFLIE)
    link = SimulatedLink(clock, [effect(key, CRAZYFLIE).inject(value=value) for key, value in HIDDEN.items()])
    controller = mppi_controller(model, CRAZYFLIE, task, samples=256)
    with (
        Recorder(record, CRAZYFLIE, {}) as recorder,
        HardwarePlant(link, FlightPilot(CRAZYFLIE), clock=clock, record=recorder.add, guard=False) as plant,
    ):
        return fly(plant, controller, task, seconds=SECONDS)


def test_the_second_flight_knows_what_the_first_has_shown(tmp_path: Path) -> None:
    base = CRAZYFLIE.nominal()
    first = flown(base, tmp_path / "first.parquet")
    log = task_of(tmp_path / "first.parquet", CRAZYFLIE, "circle")
    found = diagnose(base, Dataset([log]))
    assert found.verdict == "EFFECT", found.summary
    finding = next(one for one in found.findings if {one.effect, *one.group} >= {*HIDDEN})
    # Hovering, m g / T says what both make together.
    assert finding.effect == "added_mass"
    alike = (CRAZYFLIE.mass + HIDDEN["added_mass"]) / HIDDEN["gain:thrust"] - CRAZYFLIE.mass
    assert finding.values["value"] == pytest.approx(alike, rel=0.1)
    informed = add(base, [(one.effect, one.values) for one in found.findings])
    second = flown(informed, tmp_path / "second.parquet")
    assert (first.crashed, second.crashed) == (False, False)
    assert second.tracking < 0.4 * first.tracking
