"""Drive after drive, with a person who puts the car back in between."""

from __future__ import annotations

import math

import numpy as np

from hardware.fakes.master import FakeMaster
from hardware.fakes.mushr import Car, FakeMushr
from hardware.mushr import DriveLimits, DrivePilot
from hardware.mushr.laboratory import MushrLaboratory
from hardware.plant import HardwarePlant
from hardware.ros1 import Node
from hardware.row import Row
from sym2real.robots import MUSHR
from sym2real.trajectory import Array

NARROW = DriveLimits(low=(-1.0, -1.0), high=(0.5, 1.0), pose_age=5.0, late=5.0, overruns=10000)


def test_a_drive_that_ended_by_a_fault_does_not_keep_the_next_from_its_start() -> None:
    rows, asked = list[Row](), list[list[float]]()
    with (
        FakeMaster() as master,
        FakeMushr(Node("/fake", master.uri), Car()) as fake,
        MushrLaboratory(master=master.uri).open(MUSHR.start, print) as opened,
    ):
        link = opened.link
        link.connect()

        def put(start: Array) -> None:
            asked.append(start[:2].tolist())
            fake.put(*start[:2].tolist(), math.atan2(start[2], start[3]))
            before = link.state().extra["pose_stamp"]
            while link.state().extra["pose_stamp"] < before + 0.2:
                pass

        with HardwarePlant(link, DrivePilot(link.robot, NARROW), record=rows.append, put=put) as plant:
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
