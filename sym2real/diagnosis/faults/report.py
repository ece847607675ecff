"""What the data are fit for, before a model is blamed: timing, saturation, excitation, signs, frames, feedback.

Feedback is the part of a command's variance that a linear function of the measured state and the distance from the
reference explains: where it is large, state and command are not independent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.agreement import Agreement, rate_agreement, velocity_agreement
from sym2real.diagnosis.data.heading import against_the_path
from sym2real.diagnosis.data.lengths import long_enough
from sym2real.diagnosis.data.start import noise_level
from sym2real.diagnosis.faults.conventions import breaches
from sym2real.diagnosis.settings import SETTINGS
from sym2real.logs.dropouts import is_unasked
from sym2real.logs.extremes import at_extremes
from sym2real.symbolic import Equations
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
        unit: of the command.
    """

    deviation: float
    low: float
    high: float
    at_low: float
    at_high: float
    feedback: float
    unit: str

    @property
    def weak(self) -> bool:
        """Whether it hardly varies, so that effects on it cannot be seen."""
        return self.deviation <= SETTINGS.still * max(abs(self.low), abs(self.high))

    @property
    def saturated(self) -> bool:
        """Whether it stays at an end of its range for more than a twentieth of the rows."""
        return max(self.at_low, self.at_high) > SETTINGS.saturated and not self.weak

    def limits_said(self, name: str) -> list[str]:
        """A sentence for each end at which the command of this name is saturated."""
        if not self.saturated:
            return []
        return [
            f"{name} is at its limit {edge:.3g} {self.unit} in {100 * share:.0f} % of the rows"
            for edge, share in ((self.low, self.at_low), (self.high, self.at_high))
            if share > SETTINGS.saturated
        ]


@dataclass(frozen=True)
class DataReport:
    """What :func:`data_report` found.

    Args:
        logs, rows: how much there is.
        dt: median time step in s.
        jitter: spread of the time steps over their median, gaps left out.
        gaps: number of time steps that are longer than one and a half.
        longest_gap: in s; 0 without gaps.
        commands: by action column.
        rates, velocities: by state column.
        exact: number of logs whose positions have no sensor noise.
        heading_reversed: whether a car's heading turns against its path; rates are held against its opposite then.
        breaches: of units and of the quaternion's order; rates and velocities are compared without them.
    """

    logs: int
    rows: int
    dt: float
    jitter: float
    gaps: int
    longest_gap: float
    commands: dict[str, Excitation]
    rates: dict[str, Agreement]
    velocities: dict[str, Agreement]
    exact: int
    heading_reversed: bool
    breaches: tuple[str, ...]

    @property
    def feedback(self) -> bool:
        """Whether a command follows the measured state."""
        return bool(self.following)

    @property
    def following(self) -> tuple[str, ...]:
        """Commands that follow the measured state."""
        return tuple(name for name, excitation in self.commands.items() if excitation.feedback > SETTINGS.feedback)

    @property
    def constant(self) -> tuple[str, ...]:
        """Commands that hardly vary."""
        return tuple(name for name, excitation in self.commands.items() if excitation.weak)

    def lines(self) -> list[str]:
        """What a person should know, a sentence each; remarks only on what is not as it should be."""
        found = [f"{self.logs} log{'s' if self.logs > 1 else ''}, {self.rows} rows, time step {self.dt:.4g} s"]
        if self.jitter > SETTINGS.jitter:
            found.append(f"the time step varies by {100 * self.jitter:.0f} %")
        if self.gaps:
            found.append(f"{self.gaps} gaps, the longest {self.longest_gap:.3g} s")
        found += exactness(self.exact, self.logs)
        for name, excitation in self.commands.items():
            if excitation.weak:
                found.append(
                    f"{name} hardly varies (±{excitation.deviation:.2g} {excitation.unit}): "
                    "effects on it cannot be seen"
                )
            found += excitation.limits_said(name)
        if self.heading_reversed:
            found.append("the heading turns against the path: wrong sign")
        found += self.breaches
        checks = {**self.rates, **self.velocities}
        found += [_said(name, agreement) for name, agreement in checks.items() if _remarkable(agreement)]
        if self.feedback:
            sentence = (
                f"{', '.join(self.following)} {'goes' if len(self.following) == 1 else 'go'} with the measured state"
            )
            found.append(f"{sentence}: a closed loop, or a state that answers at once")
        return found

    def to_dict(self) -> dict[str, Any]:
        """The object ``data`` that ``compare --json`` prints."""
        commands = {
            name: {**asdict(excitation), "weak": excitation.weak, "saturated": excitation.saturated}
            for name, excitation in self.commands.items()
        }
        checks = {
            key: {name: {**asdict(agreement), "verdict": agreement.verdict} for name, agreement in found.items()}
            for key, found in (("rates", self.rates), ("velocities", self.velocities))
        }
        return {**asdict(self), "commands": commands, **checks, "feedback": self.feedback}


def _remarkable(agreement: Agreement) -> bool:
    return agreement.verdict in ("reversed", "other frame", "unclear")


def _said(name: str, agreement: Agreement) -> str:
    sentence = f"{name} and the derivative of the {agreement.of} correlate by {agreement.correlation:.2f}"
    return (
        sentence
        + {"reversed": ": wrong sign", "other frame": ": body axes, not world", "unclear": ""}[agreement.verdict]
    )


def data_report(data: Dataset | Trajectory, model: Equations | None = None) -> DataReport:
    """Look at the data alone; a model says only what its commands do and what its sensors report.

    Raises:
        ShapeError: when no log is long enough to say anything.
    """
    logs = list(long_enough(data))
    broken, conventional = breaches(Dataset(logs), model)
    steps = np.concatenate([np.diff(trajectory.time) for trajectory in logs])
    dt = float(np.median(steps)) if len(steps) else 0.0
    gaps = steps[steps > SETTINGS.gap * dt]
    regular = steps[steps <= SETTINGS.gap * dt]
    turned = against_the_path(conventional)
    return DataReport(
        logs=len(logs),
        rows=sum(len(trajectory) for trajectory in logs),
        dt=dt,
        jitter=float(regular.std() / dt) if len(regular) else 0.0,
        gaps=len(gaps),
        longest_gap=float(gaps.max()) if len(gaps) else 0.0,
        commands=excitation(logs),
        rates=rate_agreement([log if turned is None else turned.undone(log) for log in conventional]),
        velocities=velocity_agreement(list(conventional)),
        exact=sum(exact(trajectory) for trajectory in logs),
        heading_reversed=turned is not None,
        breaches=tuple(breach.evidence for breach in broken),
    )


def reading_said(data: Dataset) -> list[str]:
    """What was lost or changed of the logs when they were read, a sentence each."""
    return [f"{log.name}: {note}" for log in data for note in log.notes if is_unasked(note)]


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
    followed = _feedback(logs, values)
    found = {}
    for name, column, feedback in zip(layout, values.T, followed, strict=True):
        low, high = float(column.min()), float(column.max())
        at_low, at_high = at_extremes([trajectory.column(name) for trajectory in logs])
        found[name] = Excitation(float(column.std()), low, high, at_low, at_high, float(feedback), layout.units[name])
    return found


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
    layout = trajectory.layouts.state
    there = [name for name in layout if f"ref_{name}" in trajectory.extra]
    apart = [trajectory.column(name) - trajectory.extra[f"ref_{name}"] for name in there]
    return np.column_stack([trajectory.state, *apart])
