"""How much commands varied, how far they follow the measured state, and whether a log has any noise.

Feedback is the part of a command's variance that a linear function of the measured state and the distance from the
reference explains: where it is large, state and command are not independent.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.kind import with_unit
from sym2real.logs.extremes import at_extremes, reversal
from sym2real.logs.noise import noise_level
from sym2real.trajectory import Array, Trajectory

# So many differences leave less of a path that a simulator followed than any sensor's noise.
ORDER = 6


@dataclass(frozen=True)
class Excitation:
    """How much a command varied.

    Args:
        deviation: standard deviation, in its unit.
        low, high: range.
        at_low, at_high: parts of the rows in which it stays at the ends of it, as a clipped command does.
        feedback: part of its variance that the measured state explains linearly.
        reversal: correlation of its changes with those a row later: -1 where every second row undoes the one before.
        unit: of the command.
    """

    deviation: float
    low: float
    high: float
    at_low: float
    at_high: float
    feedback: float
    reversal: float
    unit: str

    @property
    def weak(self) -> bool:
        """Whether it hardly varies, so that effects on it cannot be seen."""
        return self.deviation <= SETTINGS.negligible * max(abs(self.low), abs(self.high))

    def limit_notes(self, name: str) -> list[str]:
        """A sentence for each end at which it stays for over a twentieth of the rows; zero is rest, and no limit."""
        return [
            f"{name} stays at its end {with_unit(edge, self.unit)} in {100 * share:.0f} % of the rows: clipped, or held"
            for edge, share in ((self.low, self.at_low), (self.high, self.at_high))
            if share > SETTINGS.uneven and edge != 0.0 and self.high > self.low
        ]


def exact(log: Trajectory) -> bool:
    """Whether positions are smooth beyond any sensor; of a few rows nobody can tell."""
    layout = log.layouts.state
    if len(log) <= 2 * ORDER or not layout.has_field("position"):
        return False
    return bool((noise_level(log.state[:, layout.slice("position")], ORDER) < SETTINGS.exact).all())


def exactness(exact: int, logs: int) -> list[str]:
    """What a person should know where so many of the logs are exact."""
    if not exact:
        return []
    some = "" if exact == logs else f" in {exact} of {logs} logs"
    return [f"no sensor noise{some}, as of a simulation without --noise or behind a low-pass: errors of any size count"]


def excitation(logs: Sequence[Trajectory]) -> dict[str, Excitation]:
    """How much every command varied, by its column."""
    layout = logs[0].layouts.action
    values = np.concatenate([trajectory.action for trajectory in logs])
    varied = {}
    for name, column, feedback in zip(layout, values.T, _feedback(logs, values), strict=True):
        pieces = [trajectory.column(name) for trajectory in logs]
        spread = float(column.std()), float(column.min()), float(column.max())
        varied[name] = Excitation(*spread, *at_extremes(pieces), float(feedback), reversal(pieces), layout.units[name])
    return varied


def _feedback(logs: Sequence[Trajectory], commands: Array) -> Array:
    """Adjusted R² of a linear fit of every command on the state of its row ``# (action,)``."""
    rows = np.concatenate([_known(trajectory) for trajectory in logs])
    design = np.column_stack([rows, np.ones(len(rows))])
    solution = np.linalg.lstsq(design, commands, rcond=None)[0]
    left, all_of_it = np.square(commands - design @ solution).sum(0), np.square(commands - commands.mean(0)).sum(0)
    free = len(commands) - design.shape[1]
    if free <= 0:
        return np.zeros(commands.shape[1])
    explained: Array = 1.0 - (left / free) / np.maximum(all_of_it / max(len(commands) - 1, 1), 1e-300)
    return np.where(all_of_it > 0, np.maximum(explained, 0.0), 0.0)


def _known(trajectory: Trajectory) -> Array:
    """State, and its distance from the reference where there is one ``# (rows, k)``."""
    there = [name for name in trajectory.layouts.state if f"ref_{name}" in trajectory.extra]
    apart = [trajectory.column(name) - trajectory.extra[f"ref_{name}"] for name in there]
    return np.column_stack([trajectory.state, *apart])
