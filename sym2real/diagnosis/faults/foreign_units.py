"""Columns in another unit than the vocabulary's, known by how many times too large or small they are: deg/s, mm, mN.

What is measured twice tells: rates against the attitude that they turn, velocities against the position that they move,
and how a quadrotor accelerates sideways against where its thrust points. A column is judged alone, and only where both
go together so well that noise cannot make one seem larger; those that hardly move go with the others.

Of commands the model tells. With a thrust in mN, rates in deg/s or motors in percent it predicts worse by far than that
nothing changes: each is divided by every factor on a grid, and belongs to the unit whose factor is nearest to the one
by which a step ahead is predicted, each command with the sign by which it moves the robot: a wrong one hides no unit.
A gain or a limit of a few times is an effect; so units that are less than ten times apart are not distinguished here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, partial
from itertools import combinations
from math import inf, log

import numpy as np
import torch

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.fault import Breach
from sym2real.diagnosis.faults.mistakes.transformation import Exchanged, of_all
from sym2real.diagnosis.faults.units import Scaled, best_factor, factors, in_unit
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.along_logs import from_row_to_row
from sym2real.effects.filters import filter_commands
from sym2real.effects.visible import VisibleModel
from sym2real.logs.agreement import Agreement, rate_agreement, thrust_agreement, velocity_agreement
from sym2real.symbolic import Equations
from sym2real.vocabulary import POSITION

Judged = tuple[Mapping[str, float | None], str]  # column → logged over meant, and over what
THAN = "what moves the robot as the model says"
# Of factors, and between which one is that of a gain.
GRID, GAIN = np.geomspace(1e-5, 1e7, 120), (1.0 / SETTINGS.far, SETTINGS.far)
MOST_ROWS = 500


def _positions(data: Dataset) -> Judged:
    by_thrust = _ratio(thrust_agreement(list(data)))
    if by_thrust is not None and abs(log(by_thrust)) >= log(SETTINGS.unheard_of):  # nearer, thrust is of a fast turn
        columns = (name for name in POSITION.columns if name in data.layouts.state)
        return dict.fromkeys(columns, by_thrust), "how far thrust moves the robot"
    moved, rates = _ratios(velocity_agreement(list(data))), data.layouts.state.rates.items()
    inverse = {place: None if (ratio := moved[rate]) is None else 1.0 / ratio for place, rate in rates}
    level = [ratio for place in POSITION.columns[:2] if (ratio := inverse.get(place)) is not None]
    small = [ratio for ratio in level if by_thrust is not None and abs(log(ratio / by_thrust)) > abs(log(by_thrust))]
    for place, ratio in inverse.items():
        # Of a coordinate and its rate the larger numbers are wrong, but where thrust says that the smaller are.
        if ratio and (ratio < 1.0 or any(abs(log(ratio / other)) < log(SETTINGS.unit_near) for other in small)):
            inverse[place] = 1.0
    return inverse, "how far its rate moves it"


def _velocities(data: Dataset) -> Judged:
    return _ratios(velocity_agreement(list(data))), "what the position or joint changes by"


def _rates(data: Dataset) -> Judged:
    return _ratios(rate_agreement(list(data))), "what the robot turns by"


def _ratios(agreements: Mapping[str, Agreement]) -> dict[str, float | None]:
    return {name: _ratio(agreement) for name, agreement in agreements.items()}


def _by_log(judge: Callable[[Dataset], Judged], data: Dataset) -> list[Breach]:
    """What is so in all logs, or, where logs that can be judged contradict each other, what is so in each."""
    meant = data.layouts.state.units
    alone = [judge(Dataset([log])) for log in data] if len(data) > 1 else []
    judged = [{name: ratio for name, ratio in ratios.items() if ratio is not None} for ratios, _ in alone]
    large = [{name for name, ratio in own.items() if in_unit((name,), meant[name], ratio)} for own in judged]
    if any(set[str]().union(*large) & own.keys() - here for own, here in zip(judged, large, strict=True)):
        return [foreign.in_log(data, place) for place, own in enumerate(alone) for foreign in _foreign(*own, meant)]
    return _foreign(*judge(data), meant)


# Position and joints, by a quadrotor's thrust or by their rates; velocities, by how the position changes; body rates,
# by how the attitude or heading turns.
BY_SENSORS = tuple(partial(_by_log, judge) for judge in (_positions, _velocities, _rates))


def _foreign(ratios: Mapping[str, float | None], than: str, meant: Mapping[str, str]) -> list[Breach]:
    """One entry for each unit that columns are in; what cannot be judged is in the one that all others are in."""
    judged = {name: ratio for name, ratio in ratios.items() if ratio is not None}
    units = {name: in_unit((name,), meant[name], ratio) for name, ratio in judged.items()}
    entries = []
    for wanted, unit in sorted({(meant[name], scaled.unit) for name, scaled in units.items() if scaled is not None}):
        own = [name for name, scaled in units.items() if scaled and (meant[name], scaled.unit) == (wanted, unit)]
        alike = [name for name in ratios if meant[name] == wanted]
        columns = alike if all(name in own or ratios[name] is None for name in alike) else own
        ratio = float(np.exp(np.mean(np.log([judged[name] for name in own]))))
        factor = float(factors(wanted)[unit] ** np.sign(log(ratio))) if unit else ratio
        entries.append(Breach(Scaled(tuple(columns), factor, unit), scale_text(ratio, than)))
    return entries


def scale_text(ratio: float, than: str) -> str:
    """What shows a scale, one clause."""
    times = np.format_float_positional(ratio, precision=3, fractional=False, trim="-")
    return f"the logged numbers are {times} times {than}"


def _ratio(agreement: Agreement) -> float | None:
    """How many times as large as the derivative a column is; None where nobody can tell, or in another frame."""
    here, elsewhere = agreement.correlation, agreement.in_other_frame
    if here is None or abs(here) < SETTINGS.nearly or (elsewhere is not None and elsewhere > here):
        return None
    return agreement.ratio or None


class Steps:
    """Rows of logs one step apart, and what a model makes of them with commands divided by something."""

    def __init__(self, model: Equations, predict: VisibleModel, data: Dataset) -> None:
        self.model, self._predict, self.data = model, predict, data
        self._state, self._action = data.layouts.state, data.layouts.action
        rows = np.delete(np.arange(data.rows), np.cumsum([len(log) for log in data]) - 1)  # a log's last has no step
        self._rows = rows[:: max(1, len(rows) // MOST_ROWS)]
        parts = zip(*((log.state, log.step_inputs) for log in data), strict=True)
        state, inputs = (torch.as_tensor(np.concatenate(part)) for part in parts)
        self._now, self._later = state[self._rows], state[self._rows + 1]
        self._given = inputs[self._rows]
        self._changed = self._state.difference(self._later, self._now).square().mean(0)

    @classmethod
    def of(cls, model: Equations, data: Dataset) -> Steps | None:
        """None where the logs have other columns than the model, or nothing moves."""
        per_row = from_row_to_row(model, data)
        steps = None if per_row is None else cls(model, *per_row)
        return None if steps is None or not bool((steps._changed > 0).any()) else steps

    def only(self, place: int) -> Steps:
        """Those of the log at this place."""
        return Steps(self.model, self._predict, Dataset([self.data[place]]))

    def exchanged(self) -> float:
        """The least that is missed with two commands in each other's place, which is another mistake than a unit."""
        swaps = (Exchanged(pair, pair[::-1], (1, 1)) for pair in combinations(self._action, 2))
        swapped = (Steps(self.model, self._predict, of_all(swap, self.data)) for swap in swaps)
        return min((own.missed((), 1.0) for own in swapped), default=inf)

    def groups(self, settled: Sequence[str]) -> list[tuple[str, ...]]:
        """Columns that may share a unit: all that have one in common, and each by itself."""
        units, shared = self._action.units, dict[str, list[str]]()
        for name in self._action:
            if name not in settled:
                shared.setdefault(units[name], []).append(name)
        alone = [(name,) for columns in shared.values() if len(columns) > 1 for name in columns]
        return [*map(tuple, shared.values()), *alone]

    def around(self, columns: Sequence[str]) -> tuple[float, float]:
        """The factors on the grid between which least is missed."""
        place = int(self.errors(columns, GRID).mean(-1).argmin())
        return float(GRID[max(0, place - 1)]), float(GRID[min(len(GRID) - 1, place + 1)])

    def rise(self, columns: Sequence[str], factor: float) -> float:
        """How many times more is missed, in the column where most is, with columns divided by far more and far less."""
        here, *beside = self.errors(columns, [factor * by for by in (1.0, SETTINGS.far, 1.0 / SETTINGS.far)])
        return float((torch.minimum(*beside) / here).max())

    def missed(self, columns: Sequence[str], factor: float) -> float:
        """Mean of :meth:`errors`."""
        return float(self.errors(columns, [factor]).mean())

    def errors(self, columns: Sequence[str], factors: Sequence[float] | np.ndarray) -> torch.Tensor:
        """Mean square of a step's error over that of the step itself, of every column that moves.

        Args:
            columns: commands that are divided.
            factors: what they are divided by ``# (F,)``.

        Returns:
            ``# (F, k)``, in one rollout of all factors; infinite where it is no number.
        """
        places = self._action.indices(columns)
        by = torch.ones(len(factors), len(self._action), dtype=torch.float64)
        by[:, places] = torch.as_tensor(factors, dtype=torch.float64)[:, None] * self._signs[places]
        error = self._missing(by).square().mean(1)
        return (error / self._changed)[:, self._changed > 0].nan_to_num(nan=inf, posinf=inf)

    def _missing(self, by: torch.Tensor) -> torch.Tensor:
        """What a step is short of with commands divided by ``by`` ``# (F, A) -> (F, n, tangent)``."""
        logs = (torch.as_tensor(log.action) / by[:, None] for log in self.data)
        sent = torch.cat([filter_commands(self.model, log, dt=self.data.dt) for log in logs], dim=1)[:, self._rows]
        after = self._predict(self._now.expand(len(by), -1, -1), sent, self._given.expand(len(by), -1, -1))
        return self._state.difference(self._later.expand_as(after), after)

    @cached_property
    def _signs(self) -> torch.Tensor:
        """Which commands move the robot against what the model says, by what next to none of each moves most: -1.

        None of the others is sent, unless a command moves nothing then, as steering does of a car that stands. Others
        1 ``# (A,)``.
        """
        (short, moved), beside = self._next_to_none(inf), self._next_to_none(1.0)
        still = (moved == 0.0).flatten(1).all(1)[:, None, None]
        short, moved = torch.where(still, beside[0], short), torch.where(still, beside[1], moved)
        most = (moved.square().mean(1) / self._changed).nan_to_num(posinf=0.0).argmax(1)
        apart, alone = (part - part.mean(-2, keepdim=True) for part in (short, moved))
        alike = torch.cosine_similarity(alone, apart, dim=1)[range(len(most)), most]
        return torch.where(alike < -SETTINGS.mostly, -1.0, 1.0).to(torch.float64)

    def _next_to_none(self, others: float) -> tuple[torch.Tensor, torch.Tensor]:
        """What is missing without each command, and what so little of it moves that only its way counts.

        Args:
            others: what the other commands are divided by.

        Returns:
            ``# (A, n, tangent)`` each.
        """
        size = len(self._action)
        by = (torch.full((size, size), others, dtype=torch.float64).fill_diagonal_(own) for own in (inf, 1e6))
        short, left = self._missing(torch.cat([*by])).split(size)
        return short, short - left


def foreign_commands(model: Equations, data: Dataset, *, first: bool = False) -> list[Breach]:
    """Commands that stand in another unit, in all logs, or in each where what mends all makes one worse.

    Args:
        first: whether a mistake in all logs may still be there: where these ask for no unit, none of them alone does.
    """
    together = Steps.of(model, data)
    if together is None:
        return []
    alone, breaches = [together.only(place) for place in range(len(data))], _foreign_steps(together)
    pairs = ((own.missed((), 1.0), together.only(place).missed((), 1.0)) for place, own in enumerate(alone))
    settled = all(now <= SETTINGS.unit_near * before for before, now in pairs) if breaches else first
    if len(data) == 1 or settled:
        return breaches
    return [foreign.in_log(data, place) for place, own in enumerate(alone) for foreign in _foreign_steps(own)]


def _foreign_steps(steps: Steps) -> list[Breach]:
    """Those of one unit together where all of them are in another."""
    breaches, settled = list[Breach](), list[str]()
    while (most := _most_foreign(steps, settled)) is not None:
        scaled, ratio = most
        steps.data = of_all(scaled, steps.data)
        breaches.append(Breach(scaled, scale_text(ratio, THAN)))
        settled += scaled.columns
    return breaches


def _most_foreign(steps: Steps, settled: Sequence[str]) -> tuple[Scaled, float] | None:
    """The columns whose other unit mends most of what is missed, and how many times too large they are."""
    mass, (now,), least = steps.model.numbers.get("mass"), steps.errors((), [1.0]), SETTINGS.command_unit
    if not (now > 1.0).any():
        return None
    best: tuple[float, tuple[Scaled, float] | None] = (inf, None)
    for columns in steps.groups(settled):
        between = steps.around(columns)
        if max(between[1], 1.0 / between[0]) < least / SETTINGS.unit_near:
            continue  # of no unit, wherever between these
        gain, ratio = (best_factor(partial(steps.missed, columns), ends) for ends in (GAIN, between))
        then, *others = steps.errors(columns, [ratio, gain, -1.0])
        if (missed := float(then.mean())) < best[0] and steps.rise(columns, ratio) > SETTINGS.command_sides:
            scaled = in_unit(columns, steps.data.layouts.action.units[columns[0]], ratio, (least, least), mass)
            # Of an angle beyond half a turn the tangent is that of a smaller one, a gain or the other sign away.
            if scaled is not None and all(_mended(other, then) for other in (now, *others)):
                best = missed, (scaled, ratio)
    return None if best[1] is None or steps.exchanged() < best[0] else best[1]


def _mended(now: torch.Tensor, then: torch.Tensor) -> bool:
    """Whether a column that is missed by more than it changes is missed far less, and no other becomes one."""
    better, worse = now > SETTINGS.far * then, then > SETTINGS.unit_near * now
    return bool((better & (now > 1.0)).any() and not (worse & (then > 1.0)).any())
