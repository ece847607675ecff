"""What the data are fit for, before a model is blamed: timing, saturation, excitation, feedback, and their faults."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from sym2real.dataset import Dataset, Logs
from sym2real.diagnosis.data.preparation import long_enough
from sym2real.diagnosis.faults.fault import Fault
from sym2real.diagnosis.faults.sanity import check, slow_notes
from sym2real.diagnosis.faults.variation import Excitation, exact, excitation
from sym2real.diagnosis.settings import SETTINGS
from sym2real.json_objects import fields_of
from sym2real.logs.agreement import Agreement, agreements
from sym2real.symbolic import Equations
from sym2real.upward import upward


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
        agreements: of rates with what they are the rates of, by state column, faults undone.
        exact: number of logs whose positions have no sensor noise.
        spacing: of the rows, where it is not the model's step.
        faults: what is wrong with the data, as a diagnosis finds and undoes it.
    """

    logs: int
    rows: int
    dt: float
    jitter: float
    gaps: int
    longest_gap: float
    commands: dict[str, Excitation]
    agreements: dict[str, Agreement]
    exact: int
    spacing: tuple[str, ...]
    faults: tuple[Fault, ...]

    @property
    def following(self) -> tuple[str, ...]:
        """Commands that follow the measured state."""
        return tuple(name for name, excitation in self.commands.items() if excitation.feedback > SETTINGS.mostly)

    def lines(self) -> list[str]:
        """What a person should know, a sentence each: :attr:`remarks`, and the faults."""
        return [*self.remarks, *(fault.sentence for fault in self.faults)]

    @property
    def remarks(self) -> list[str]:
        """How much data there are, and what is not as it should be and no fault."""
        return list(upward("data_remarks")(self))

    def to_dict(self) -> dict[str, Any]:
        """The object ``data`` that ``compare --json`` prints."""
        return {**fields_of(self), "feedback": bool(self.following)}


def data_report(data: Logs, model: Equations | None = None) -> DataReport:
    """Look at the data; of a model only what its commands do and what its sensors report is asked.

    Raises:
        ShapeError: when no log is long enough to say anything.
    """
    steps = np.concatenate([np.diff(log.time) for log in long_enough(data)])
    logs = list(long_enough(data, model))
    checked = check(model, Dataset(logs))
    dt = float(np.median(steps))
    gaps = steps[steps > SETTINGS.gap * dt]
    return DataReport(
        logs=len(logs),
        rows=sum(len(trajectory) for trajectory in logs),
        dt=dt,
        jitter=float(steps[steps <= SETTINGS.gap * dt].std() / dt),
        gaps=len(gaps),
        longest_gap=float(gaps.max()) if len(gaps) else 0.0,
        commands=excitation(logs),
        agreements=agreements(list(checked.data)),
        exact=sum(exact(trajectory) for trajectory in logs),
        spacing=tuple(slow_notes(model, checked.data, checked.commands_lost)),
        faults=checked.faults,
    )
