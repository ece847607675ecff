"""Drive after drive, with a person who puts the car back in between."""

import math

import numpy as np
from car_link import CarLink

from hardware.fakes.mushr import Car
from hardware.mushr import DriveLimits, DrivePilot
from hardware.plant import HardwarePlant
from hardware.row import Row
from sym2real.trajectory import Array
from tests.hardware_link import TestClock

NARROW = DriveLimits(low=(-1.0, -1.0), high=(0.5, 1.0))


def test_a_drive_that_ended_by_a_fault_does_not_keep_the_next_from_its_start() -> None:
    rows, asked, clock = list[Row](), list[list[float]](), TestClock()
    link = CarLink(clock, Car())

    def put(start: Array) -> None:
        asked.append(start[:2].tolist())
        link.car.put(*start[:2].tolist(), math.atan2(start[2], start[3]))
        clock.time += 0.2

    pilot = DrivePilot(link.robot, NARROW)
    with HardwarePlant(link, pilot, clock=clock, record=rows.append, guard=False, put=put) as plant:
        for _ in range(2):
            state = plant.reset([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
            assert np.hypot(*state[:2]) < 0.15
            assert not plant.crashed
            for _ in range(400):
                plant.step([0.0, 0.9])
                if plant.crashed:
                    break
            assert plant.ended.startswith("outside the fence: x = 0.5")
    assert asked == [[0.0, 0.0], [0.0, 0.0]]
    assert sum(row.stage == "task" for row in rows) > 20
    np.testing.assert_array_equal(rows[-1].sent, 0.0)
