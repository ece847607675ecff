"""A link behind a pilot: in every control period measure, judge, send, and tell a record of it."""

from collections.abc import Callable

import numpy as np

from hardware.clock import Clock
from hardware.interfaces import Command, Pilot, RobotLink, Verdict
from hardware.periods import Periods
from hardware.row import Row
from sym2real.trajectory import Array


class PilotedLink:
    """What a plant acts through, period by period.

    Args:
        link: connected.
        pilot: what may pass.
        clock: of the periods.
        record: called once a control period.

    Attributes:
        periods: their grid.
        reading: of the present one.
        sent: the action that the robot was told last ``# (action,)``.
        stage: what the run is about, for the record.
    """

    def __init__(self, link: RobotLink, pilot: Pilot, clock: Clock, record: Callable[[Row], None]) -> None:
        self.periods = Periods(clock, link.robot.dt)
        self.sent, self.stage = np.zeros(link.robot.layouts.action.size), ""
        self._link, self._pilot, self._record = link, pilot, record
        self._overruns = 0

    def measure(self, *, anew: bool = False) -> None:
        """A period begins: read the state; anew, the grid begins with it."""
        if anew:
            self.periods.restart()
        else:
            self.periods.begin()
        self.reading = self._link.state()

    def tick(self, wanted: Array | None, asked: str = "") -> Command:
        """Send what the pilot makes of a wanted action, None where there is none.

        Args:
            wanted: ``# (action,)``.
            asked: why somebody wants to land.
        """
        overdue = 0.0 if wanted is None else self.periods.taken - self._link.robot.dt
        self._overruns = self._overruns + 1 if overdue > 0.0 else 0
        command = self._pilot.act(self.reading, wanted, late=overdue, overruns=self._overruns, asked=asked)
        if command.verdict is Verdict.CUT:
            self._link.stop()
            self.sent = command.action
        else:
            self.sent = self._link.send(command.action)
        asked_for = np.full(len(command.action), np.nan) if wanted is None else wanted
        late, taken, skipped = self.periods.late, self.periods.taken, self.periods.skipped
        self._record(Row(self.reading, asked_for, self.sent, command, self.stage, late, taken, skipped))
        return command

    def next(self) -> None:
        """Wait for the next period, and measure."""
        self.periods.finish()
        self.periods.wait()
        self.measure()
