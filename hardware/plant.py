"""A robot as a plant: what flies in simulation flies on hardware, with a pilot between the controller and the link.

Row k of a record: state k was measured at the beginning of a control period, then an action was sent; state k+1 is
read one period later, on a grid of the clock that never drifts. Where the controller falls silent, a second thread
lands the robot.
"""

import threading
from collections.abc import Callable, Mapping
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from hardware.clock import Clock, SystemClock
from hardware.errors import LinkError, UnreachableError
from hardware.interfaces import Pilot, RobotLink, Verdict
from hardware.piloted import PilotedLink
from hardware.row import Row
from sym2real.errors import ShapeError
from sym2real.layout import Layouts
from sym2real.robots import Robot
from sym2real.trajectory import Array

STANDING = 1.0  # s that a robot is looked at before it moves: some 50 poses, of which a few may be wrong


class HardwarePlant:
    """A :class:`~sym2real.protocols.Plant` that acts through a link; as a context manager it lands the robot.

    Args:
        link: connected.
        pilot: what may pass.
        clock: the computer's by default.
        record: called once a control period.
        guard: watch for a silent controller from a second thread; without it, call :meth:`watch`.
        put: has a person bring the robot near a start ``# (state,)``; a fault does not keep it from the next run then.
        about: what tells its robot from another, for a run that is continued: as JSON has it.

    Attributes:
        sent: the last step's action as the robot was told it, after pilot, rounding and saturation ``# (action,)``.
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
        put: Callable[[Array], None] | None = None,
        about: Mapping[str, Any] | None = None,
    ) -> None:
        self.link, self._pilot, self._put, self.about = link, pilot, put, about or {}
        self._clock = clock or SystemClock()
        self._lock = threading.RLock()
        self._moving = self._awaiting = self._holding = False
        self._acting = PilotedLink(link, pilot, self._clock, record)
        self.ended, self._fault, self._remedy = "", "", ""
        self.sent, self._held = np.zeros(link.robot.layouts.action.size), 0.0
        self._closing = threading.Event()
        if guard:
            threading.Thread(target=self._watching, name="landing guard", daemon=True).start()

    @property
    def robot(self) -> Robot:
        """Columns, limits and control period."""
        return self.link.robot

    @property
    def layouts(self) -> Layouts:
        """The robot's columns."""
        return self.robot.layouts

    @property
    def dt(self) -> float:
        """Control period in s."""
        return self.robot.dt

    @property
    def inputs(self) -> Array:
        """No push is known on hardware: zeros ``# (inputs,)``."""
        return np.zeros(self.layouts.inputs.size)

    @property
    def measured_at(self) -> float:
        """When the state was measured that was returned last, s."""
        return self._acting.periods.began

    @property
    def missed(self) -> int:
        """Control periods that went by without an action since the last :meth:`reset`."""
        return self._acting.periods.missed

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
            UnreachableError: for a state that the pilot refuses or did not reach in time (the robot lands then), where
                it must not take off, and after a flight that ended by a fault.
            LinkError: where no state arrives, or the robot does not arm.
        """
        goal = self.link.robot.start if state is None else np.asarray(state, dtype=np.float64)
        if goal.shape != (self.layouts.state.size,) or not np.isfinite(goal).all():
            raise ShapeError(f"expected a finite state with columns {self.layouts.state.columns}, found {goal}")
        if self._put is not None:
            self._land_or_cut("the robot is put back")
            self._put(goal)
            self._fault = ""
        with self._lock:
            self._acting.stage = "way to the start"
            self._go_to(goal)
            self._acting.periods.missed, self._held = 0, self._clock.now()
            self._awaiting = self._holding = True
            return self._acting.reading.state.copy()

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
                self._acting.stage = "task"
                self._awaiting = self._holding = False
                verdict = self._acting.tick(wanted).verdict
                self.sent = self._acting.sent  # on the state that this step began with; a landing's is in the record
                if verdict is Verdict.GO:
                    self._acting.periods.finish()
                    self._awaiting = True
                else:
                    self._finish()
        if not self.ended:
            self._acting.periods.wait()
        with self._lock:
            if not self.ended:
                self._acting.measure()
            return self._acting.reading.state.copy()

    def land(self, reason: str = "the task is over") -> None:
        """Land from wherever it is and switch the motors off; nothing where it stands on the ground."""
        with self._lock:
            if self._moving:
                self._acting.stage = "landing"
                self._finish(reason, faulty=False)

    def end_episode(self) -> None:
        """Land; refuse an episode that ended by what no model can help.

        Raises:
            LinkError: with what to do first, where the battery, the link or motion capture ended it.
        """
        self.land()
        if self._remedy:
            raise LinkError(
                f"{self.ended}: no fault of the model, so this episode does not count; {self._remedy}, then give the "
                "same command again"
            )

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

    def _begin(self) -> None:
        """Look at the robot for a second where it stands; no single reading says that it may fly."""
        self._require_no_fault()
        self._acting.periods.restart()
        readings = [self._acting.reading]
        for _ in range(round(STANDING / self.dt)):
            self._acting.next()
            readings.append(self._acting.reading)
        if not np.isfinite(readings[-1].state).all():
            raise LinkError("expected a whole state before a take-off: a pose and an attitude must arrive first")
        self._pilot.begin(readings)

    def _require_no_fault(self) -> None:
        if self._fault:
            raise UnreachableError(
                f"the last flight ended by a fault ({self._fault}): look at the robot, then start anew"
            )

    def _require_reset(self) -> None:
        if not self._moving:
            raise LinkError("expected a reset before the first step: the robot stands on the ground")

    def _go_to(self, goal: Array) -> None:
        self._acting.measure()
        if not self._moving:
            self._begin()
        seconds = self._pilot.approach(self._acting.reading, goal)
        if not self._moving:
            self.link.arm()
            self.ended, self._remedy, self._moving = "", "", True
        self._awaiting = self._holding = False
        self._acting.measure(anew=True)
        for _ in range(round(seconds / self.dt)):
            if self._pilot.arrived(self._acting.reading):
                return
            if self._acting.tick(self._pilot.towards(self._acting.reading)).verdict is not Verdict.GO:
                self._finish()
                raise UnreachableError(f"the start was not reached: {self.ended}")
            self._acting.next()
        self._finish(f"the start was not reached in {seconds:.0f} s")
        raise UnreachableError(self.ended)

    def _hold(self) -> None:
        """One control period at the start: a controller's first action may take long."""
        if self._clock.now() - self._held > self._pilot.holding:
            self._finish(f"no action in {self._pilot.holding:g} s after the start was reached", faulty=False)
            return
        self._acting.measure(anew=True)
        if self._acting.tick(self._pilot.towards(self._acting.reading)).verdict is not Verdict.GO:
            self._finish()

    def _finish(self, asked: str = "", *, faulty: bool = True) -> None:
        """Land until the motors are cut; where nobody asked, the pilot has the reason.

        Whoever asked, a landing that went wrong is a fault.
        """
        self._awaiting = self._holding = False
        self._fault = "its landing was broken off"
        self._acting.measure(anew=True)
        found = [command := self._acting.tick(None, asked)]
        while command.verdict is not Verdict.CUT:
            self._acting.next()
            found.append(command := self._acting.tick(None, asked))
        self._moving, self.ended, self._remedy = False, command.reason, found[0].remedy
        faults = [command.reason if faulty else "", *(each.fault for each in found)]
        self._fault = next(filter(None, faults), "")

    def _overdue(self) -> float:
        """How late the controller's next action is, s; below zero while it is not, or nobody waits for one."""
        return self._acting.periods.overdue() if self._awaiting else -self.dt

    def _watching(self) -> None:
        while not self._closing.wait(self.dt):
            self.watch()
