"""A robot as a plant: what flies in simulation flies on hardware, with a pilot between the controller and the link.

Row k of a record: state k was measured at the beginning of a control period, then an action was sent; state k+1 is
read one period later, on a grid of the clock that never drifts. Where the controller falls silent, a second thread
lands the robot.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from hardware.clock import Clock, SystemClock
from hardware.errors import LinkError, UnreachableError
from hardware.interfaces import Command, Pilot, Reading, RobotLink, Verdict
from sym2real.errors import ShapeError
from sym2real.layout import Layouts
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


class HardwarePlant:
    """A :class:`~sym2real.protocols.Plant` that acts through a link; as a context manager it lands the robot.

    Args:
        link: connected.
        pilot: what may pass.
        clock: the computer's by default.
        record: called once a control period.
        guard: watch for a silent controller from a second thread; without it, call :meth:`watch`.

    Attributes:
        sent: the action that the robot was told last, after the pilot, rounding and saturation ``# (action,)``.
        missed: control periods that went by without an action since the last :meth:`reset`.
        ended: why the last flight ended; empty while it goes on.
    """

    def __init__(
        self,
        link: RobotLink,
        pilot: Pilot,
        *,
        clock: Clock | None = None,
        record: Callable[[Row], None] = lambda _: None,
        guard: bool = True,
    ) -> None:
        self.link, self._pilot, self._record = link, pilot, record
        self._clock = clock or SystemClock()
        self._lock = threading.RLock()
        self._moving = self._awaiting = self._holding = self._faulty = False
        self._stage, self.ended, self.sent = "", "", np.zeros(link.robot.layouts.action.size)
        self._overruns = self._skipped = self.missed = 0
        self._due = self._began = self._held = 0.0
        self._closing = threading.Event()
        if guard:
            threading.Thread(target=self._watching, name="landing guard", daemon=True).start()

    @property
    def layouts(self) -> Layouts:
        """The robot's columns."""
        return self.link.robot.layouts

    @property
    def dt(self) -> float:
        """Control period in s."""
        return self.link.robot.dt

    @property
    def inputs(self) -> Array:
        """No push is known on hardware: zeros ``# (inputs,)``."""
        return np.zeros(self.layouts.inputs.size)

    @property
    def crashed(self) -> bool:
        """Whether the flight has ended, by a landing or otherwise."""
        return bool(self.ended)

    def reset(self, state: ArrayLike | None = None, seed: int | None = None) -> Array:
        """Go to a state by the pilot's safe controller and stay there; from the ground, arm and take off first.

        Args:
            state: where to begin ``# (state,)``; the robot's own start by default.
            seed: nothing is random here.

        Raises:
            ShapeError: for another number of columns, or a state that is not finite.
            UnreachableError: for a state that the pilot refuses or did not reach in time (the robot lands then), and
                after a flight that ended by a fault.
            LinkError: where no state arrives, or the robot does not arm.
        """
        goal = self.link.robot.start if state is None else np.asarray(state, dtype=np.float64)
        if goal.shape != (self.layouts.state.size,) or not np.isfinite(goal).all():
            raise ShapeError(f"expected a finite state with columns {self.layouts.state.columns}, found {goal}")
        with self._lock:
            self._stage = "way to the start"
            self._go_to(goal)
            self.missed, self._held = 0, self._clock.now()
            self._awaiting = self._holding = True
            return self._reading.state.copy()

    def step(self, action: ArrayLike) -> Array:
        """Send an action ``# (action,)`` as far as it is safe; the state ``# (state,)`` one control period later.

        Where the flight ends, the landing is flown to its end before this returns; :attr:`crashed` is true then.

        Raises:
            ShapeError: for another number of columns.
            LinkError: before a :meth:`reset`.
        """
        wanted = np.asarray(action, dtype=np.float64)
        if wanted.shape != (self.layouts.action.size,):
            raise ShapeError(f"an action has columns {self.layouts.action.columns}, found shape {wanted.shape}")
        with self._lock:
            if not self.ended:
                self._require_reset()
                self._stage = "task"
                self._awaiting = self._holding = False
                if self._tick(wanted).verdict is Verdict.GO:
                    self._schedule()
                    self._awaiting = True
                else:
                    sent = self.sent  # on the state that this step began with; the landing's own is in the record
                    self._finish()
                    self.sent = sent
        if not self.ended:
            self._clock.sleep_until(self._due)
        with self._lock:
            if not self.ended:
                self._measure()
            return self._reading.state.copy()

    def land(self, reason: str = "the task is over") -> None:
        """Land from wherever it is and switch the motors off; nothing where it stands on the ground."""
        with self._lock:
            if self._moving:
                self._stage = "landing"
                self._finish(reason, faulty=False)

    def watch(self) -> None:
        """Hold the start until the first action comes; land where an action has been due for too long."""
        if self._overdue() <= (0.0 if self._holding else self._pilot.late):
            return
        with self._lock:
            overdue = self._overdue()  # it may have come while this waited for the lock
            if self._holding and overdue > 0.0:
                self._hold()
            elif overdue > self._pilot.late:
                self._finish(f"no action for {overdue:.2f} s after it was due", faulty=False)

    def close(self) -> None:
        """Land and stop the guard; interrupted while it lands, it cuts the motors."""
        self._land_or_cut("the plant was closed")
        self._closing.set()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None:
            self._land_or_cut("Ctrl-C" if kind is KeyboardInterrupt else f"{kind.__name__}: {error}")
        self.close()

    def _land_or_cut(self, reason: str) -> None:
        try:
            self.land(reason)
        except BaseException:
            self.link.stop(emergency=True)
            raise

    def _require_whole_state(self) -> None:
        if self._faulty:
            raise UnreachableError(
                f"the last flight ended by a fault ({self.ended}): look at the robot, then start anew"
            )
        if not np.isfinite(self._reading.state).all():
            raise LinkError("expected a whole state before a take-off: a pose and an attitude must arrive first")

    def _require_reset(self) -> None:
        if not self._moving:
            raise LinkError("expected a reset before the first step: the robot stands on the ground")

    def _go_to(self, goal: Array) -> None:
        self._measure()
        if not self._moving:
            self._require_whole_state()
            self._pilot.begin(self._reading)
        seconds = self._pilot.approach(self._reading, goal)
        if not self._moving:
            self.link.arm()
            self.ended, self._moving, self._overruns = "", True, 0
        self._awaiting = self._holding = False
        self._measure()
        self._due = self._began
        for _ in range(round(seconds / self.dt)):
            if self._pilot.arrived(self._reading):
                return
            if self._tick(self._pilot.towards(self._reading)).verdict is not Verdict.GO:
                self._finish()
                raise UnreachableError(f"the start was not reached: {self.ended}")
            self._next()
        self._finish(f"the start was not reached in {seconds:.0f} s")
        raise UnreachableError(self.ended)

    def _hold(self) -> None:
        """One control period at the start: a controller's first action may take long."""
        if self._clock.now() - self._held > self._pilot.holding:
            self._finish(f"no action in {self._pilot.holding:g} s after the start was reached", faulty=False)
            return
        self._measure()
        self._due = self._began
        if self._tick(self._pilot.towards(self._reading)).verdict is not Verdict.GO:
            self._finish()

    def _finish(self, asked: str = "", *, faulty: bool = True) -> None:
        """Land until the motors are cut; where nobody asked, the pilot has the reason."""
        self._awaiting = self._holding = False
        self._faulty = faulty
        self._measure()
        self._due = self._began
        while (command := self._tick(None, asked)).verdict is not Verdict.CUT:
            self._next()
        self._moving, self.ended = False, command.reason

    def _tick(self, wanted: Array | None, asked: str = "") -> Command:
        overdue = 0.0 if wanted is None else self._clock.now() - self._began - self.dt
        self._overruns = self._overruns + 1 if overdue > 0.0 else 0
        command = self._pilot.act(self._reading, wanted, late=overdue, overruns=self._overruns, asked=asked)
        if command.verdict is Verdict.CUT:
            self.link.stop()
            self.sent = command.action
        else:
            self.sent = self.link.send(command.action)
        self._note(command, np.full(len(command.action), np.nan) if wanted is None else wanted)
        return command

    def _note(self, command: Command, asked: Array) -> None:
        late, taken = self._began - self._due, self._clock.now() - self._began
        self._record(Row(self._reading, asked, self.sent, command, self._stage, late, taken, self._skipped))

    def _next(self) -> None:
        self._schedule()
        self._clock.sleep_until(self._due)
        self._measure()

    def _schedule(self) -> None:
        """The next period is due; those that have gone by already are left out, and counted."""
        self._due += self.dt
        # From one measurement to the next at least half a period passes.
        self._skipped = max(0, math.ceil((self._began - self._due) / self.dt + 0.5))
        self.missed += self._skipped
        self._due += self._skipped * self.dt

    def _measure(self) -> None:
        self._began = self._clock.now()
        self._reading = self.link.state()

    def _overdue(self) -> float:
        """How late the controller's next action is, s; below zero while it is not, or nobody waits for one."""
        return self._clock.now() - max(self._began, self._due) - self.dt if self._awaiting else -self.dt

    def _watching(self) -> None:
        while not self._closing.wait(self.dt):
            self.watch()
