"""What is asked of a model and logs, and the same once the logs have been checked."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isclose
from statistics import median

from sym2real.dataset import Dataset, Logs
from sym2real.diagnosis.data.preparation import long_enough
from sym2real.diagnosis.data.windows import rows_ahead
from sym2real.diagnosis.faults.sanity import Checked, check
from sym2real.effects.along_logs import with_filtered_commands
from sym2real.effects.catalogue import require_patterns
from sym2real.effects.inputs import with_common_clock
from sym2real.errors import ModelError
from sym2real.plants import MujocoPlant
from sym2real.symbolic import Equations

SAME_FACTOR = 1e-3  # relative difference of two factors of a command


@dataclass(frozen=True, eq=False)
class Question:
    """A model, logs, and how they are held against each other; arguments as of :func:`sym2real.diagnosis.diagnose`.

    Args:
        include: keys of effects that compete whatever the rules for candidates say.

    Raises:
        ShapeError: when the horizon is below one step, or not finite.
        UnknownNameError: for a pattern to exclude that no effect can match.
        ModelError: for a plant that is none.
    """

    model: Equations
    data: Logs
    plant: MujocoPlant | None = None
    calibrate: bool = True
    held_out: Dataset | None = None
    exclude: Collection[str] = ()
    include: Sequence[str] = ()
    horizon: float | None = None

    def __post_init__(self) -> None:
        require_patterns(self.exclude)
        if self.plant is not None and not isinstance(self.plant, MujocoPlant):
            raise ModelError(f"plant: expected a simulator, as MujocoPlant(robot) is one, found {self.plant!r:.80}")
        if self.horizon is not None:
            rows_ahead(self.horizon, max(self.model.dt, long_enough(self.data, self.model).dt))


@dataclass(frozen=True, eq=False)
class Examined:
    """A question whose data are fit to be searched.

    Args:
        question: what was asked.
        checked: the data, faults undone, commands as they reach the robot.
        aside: the same of logs that were kept aside, if any.
    """

    question: Question
    checked: Checked
    aside: Checked | None = None

    @property
    def scaled(self) -> tuple[str, ...]:
        """Commands in no known unit, whose factor a first look told; none where more has been done to them since."""
        if self.checked.commands_lost or self.question.model.filters:
            return ()
        return tuple(name for fault in self.checked.faults for name in fault.columns)

    def rescaled(self, gains: Mapping[str, float]) -> Examined | None:
        """With the factors of such commands as a search knows them, by the gains that it found; None for the same."""
        scaled = ((fault.columns, fault.value) for fault in self.checked.faults if {*fault.columns} & gains.keys())
        known = [(columns, value) for columns, value in scaled if value is not None]
        beside = [median(gains[name] for name in columns if name in gains) for columns, _ in known]
        if all(isclose(gain, 1.0, rel_tol=SAME_FACTOR) for gain in beside):
            return None
        factors = {columns: value / gain for (columns, value), gain in zip(known, beside, strict=True)}
        aside = None if self.aside is None else self.aside.rescaled(factors)
        return replace(self, checked=self.checked.rescaled(factors), aside=aside)


def check_data(question: Question) -> Examined:
    """Faults of the data undone, of the logs that are kept aside too; commands as they reach a robot with filters.

    Raises:
        ShapeError: when no log is long enough to judge.
    """
    parts = [long_enough(part, question.model) for part in (question.data, question.held_out) if part is not None]
    # Logs that go on from those of the search have their battery.
    logs = list(with_common_clock(Dataset(log for part in parts for log in part)).told_apart())
    results = [check(question.model, Dataset(half)) for half in (logs[: len(parts[0])], logs[len(parts[0]) :]) if half]
    checked, *aside = (replace(result, data=with_filtered_commands(question.model, result.data)) for result in results)
    return Examined(question, checked, *aside)
