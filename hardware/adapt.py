"""Adapt a model to a robot: a flight or drive with the present model, training on all so far, and again."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Generic

import numpy as np
import tyro
from rich.console import Console

from hardware.checks import require_ready
from hardware.command_line import main
from hardware.controller import require_model_of, warm_controller
from hardware.laboratory import Opened
from hardware.plant import HardwarePlant
from hardware.provenance import about_run
from hardware.recorder import Recorder
from hardware.robots import Kind, of_every_robot
from sym2real.cli.adapt import AdaptVerb
from sym2real.cli.positionals import TaskName
from sym2real.tasks import make_task

if TYPE_CHECKING:
    from sym2real.cli.adapt_target import Chosen
    from sym2real.neural import Model

RECORDS = "records"


@dataclass(frozen=True, kw_only=True)
class Adapt(AdaptVerb, Generic[Kind]):
    """Adapt a model to a robot: a flight or drive with the present model, training on all so far, and again.

    It is `sym2real adapt` with a robot as its target: the same options, the same folder. Every round goes to the
    task's start and begins there; a drone lands while a model is trained, a car is put back by hand. Ctrl-C lands or
    brakes. The same command goes on where it was: with a new battery, or after a flight that ended by a fault.

    OUT/records holds every control period of every flight, a file a command. --dry-run connects and checks the robot.
    """

    task: TaskName
    """hover, circle or lemniscate; of a car circle, reverse_circle, lemniscate, track or park."""
    laboratory: Annotated[Kind, tyro.conf.arg(name="")]
    """The robot and what sees it."""

    @contextmanager
    def chosen(self, model: Model, console: Console) -> Iterator[Chosen]:
        """The robot, connected and ready, as a plant; with --dry-run it is checked, and nothing is sent."""
        from sym2real.cli.adapt_target import Chosen  # noqa: PLC0415

        robot, say = self.laboratory.ROBOT, console.print
        require_model_of(model, self.model, robot)
        task = make_task(self.task, robot)
        with self.laboratory.open(task.start(np.random.default_rng(self.seed)), say, dry=self.dry_run) as opened:
            require_ready(opened.link, self.laboratory.checks, say)
            with self._plant(opened) as plant:
                yield Chosen(plant, task, robot, partial(warm_controller, say=say))

    @contextmanager
    def _plant(self, opened: Opened) -> Iterator[HardwarePlant]:
        """Episode after episode."""
        link, pilot = opened.link, self.laboratory.pilot()
        if self.dry_run:
            yield HardwarePlant(link, pilot, guard=False)
            return
        about = about_run(self.task, self.model, link, self.laboratory.about)
        with (
            Recorder(self._free_name(), self.laboratory.ROBOT, about) as recorder,
            HardwarePlant(link, pilot, record=recorder.add, put=opened.put, about=self.laboratory.target) as plant,
        ):
            yield plant

    def _free_name(self) -> Path:
        """A record of its own for every command that goes on with the run."""
        first = self.out / RECORDS / self.laboratory.RECORD
        number = 1 + len(list(first.parent.glob("*.yaml")))
        return first.with_stem(f"{first.stem}_{number}")


if __name__ == "__main__":
    main(of_every_robot(Adapt), "python -m hardware.adapt", __doc__)
