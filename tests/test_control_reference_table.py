"""Rows of a reference that are looked up are those of the task, wherever a controller asks."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from torch import Tensor

from sym2real.control.at_steps import ROWS_AHEAD as AHEAD, ReferenceTable
from sym2real.robots import ROBOTS
from sym2real.tasks import make_task

DT, HORIZON = 0.02, 40


@pytest.mark.parametrize("step", [0, 1, 77, AHEAD - 1, AHEAD, 49 + AHEAD, 50 + AHEAD, 51 + AHEAD, 3 * AHEAD + 5, 12])
def test_rows_are_the_tasks_own_at_any_step_in_any_order(step: int) -> None:
    task = make_task("circle", ROBOTS["crazyflie"])
    table = ReferenceTable(task, DT, HORIZON, torch.empty(0))
    table.after(50)
    time = DT * torch.arange(step + 1, step + HORIZON + 1, dtype=torch.float64)
    assert torch.equal(table.after(step), task.reference(time).float())


def test_a_flight_of_twenty_seconds_computes_its_reference_once() -> None:
    task, asked = make_task("circle", ROBOTS["crazyflie"]), list[int]()

    def counted(time: Tensor) -> Tensor:
        asked.append(len(time))
        return task.reference(time)

    table = ReferenceTable(replace(task, reference=counted), DT, HORIZON, torch.empty(0))
    for step in range(AHEAD):
        table.after(step)
    assert asked == [HORIZON + AHEAD - 1]
