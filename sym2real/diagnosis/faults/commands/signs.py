"""Commands with the wrong sign: a model foretells a step better by far with the opposite of what was sent."""

from __future__ import annotations

from dataclasses import dataclass

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.scaled import divided
from sym2real.diagnosis.faults.commands.steps import Steps
from sym2real.diagnosis.settings import SETTINGS
from sym2real.symbolic import Equations


@dataclass(frozen=True)
class ReversedCommand:
    """A command whose sign is the opposite of the model's.

    Args:
        column: of the action.
        as_it_stands, reversed, without: squares missed one step ahead over those of the step, with the command as it is
            logged, with its opposite, and with none.
    """

    column: str
    as_it_stands: float
    reversed: float
    without: float

    @property
    def evidence(self) -> str:
        """What shows it, one clause."""
        return (
            f"{self.column} with the wrong sign: one step ahead the model misses {self.as_it_stands:.3g} of the step's "
            f"squares, {self.without:.3g} without it, {self.reversed:.3g} with its opposite"
        )

    @property
    def fix(self) -> str:
        """What to change."""
        return f"turn it where it is logged, or flip its column in a specification of the log ({self.column})"

    def undone(self, data: Dataset) -> Dataset:
        """The logs with the opposite."""
        return divided(data, (self.column,), -1.0)


def reversed_commands(model: Equations, data: Dataset) -> list[ReversedCommand]:
    """Commands that move the robot the other way than the model says, beyond what a delay or a gain can do."""
    steps = Steps.of(model, data)
    commands = [] if steps is None else [_compared(steps, column) for column in steps.signed]
    return [command for command in commands if command is not None]


def _compared(steps: Steps, column: str) -> ReversedCommand | None:
    """The command, if its opposite foretells what it moves, and nothing else much worse."""
    as_it_stands, other, without = steps.errors((column,), (1.0, -1.0, float("inf")))
    better = as_it_stands - other
    most = int(better.nan_to_num().argmax())
    command = ReversedCommand(column, *(float(errors[most]) for errors in (as_it_stands, other, without)))
    sure = command.reversed < command.without < command.as_it_stands > SETTINGS.command_sign * command.reversed
    return command if sure and float(-better.min()) < SETTINGS.others_worse * float(better[most]) else None
