"""One control period as a plant tells of it."""

from dataclasses import dataclass

from hardware.interfaces import Command, Reading
from sym2real.trajectory import Array


@dataclass(frozen=True, eq=False)
class Row:
    """One control period for the record.

    Args:
        reading: at its beginning.
        asked: what the controller wanted ``# (action,)``; NaN where it wanted nothing.
        sent: what the robot was told ``# (action,)``.
        command: of the pilot.
        stage: what the flight was about ("way to the start", "task", "landing").
        late: s that the period began after it was due.
        taken: s from the reading to the sending.
        missed: periods left out before this one.
    """

    reading: Reading
    asked: Array
    sent: Array
    command: Command
    stage: str
    late: float
    taken: float
    missed: int
