"""Predictions of all segments under many parameter sets in one rollout, and their derivatives by differences."""

from collections.abc import Sequence
from functools import cached_property

import torch
from torch import Tensor
from torch.nn.functional import pad

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import Segments, compared_fields, cut, padded
from sym2real.diagnosis.predict.filtered import FilteredCommands
from sym2real.diagnosis.predict.library import Library, hidden_start_of, output_of
from sym2real.effects.inputs import inputs_along
from sym2real.effects.sensors import Sensors
from sym2real.symbolic import rollout

# Parameter sets that go through one rollout, and difference steps in units of a parameter's scale.
BATCH = 48
STEP = 1e-3
# Difference steps of the start state, in the tangent's units.
START_STEP = 1e-5
Pushes = tuple[Tensor, Tensor] | None  # beside commands and inputs ``# (B, 1, N - 1, ·)``


class Problem:
    """A library of effects against a data set.

    Args:
        library: the candidates.
        data: logs with the base's columns.
        segments: pieces of the logs; all of them, cut without overlap, by default.
    """

    def __init__(self, library: Library, data: Dataset, segments: Segments | None = None) -> None:
        self.library = library
        self.data = data
        self.segments: Segments = cut(data) if segments is None else segments
        self._commands = FilteredCommands(library, data)
        inputs = library.equations.layouts.inputs
        self._inputs = padded(inputs.over_steps(inputs_along(inputs, log)) for log in data)
        self._defaults = torch.tensor(list(library.equations.parameters.values()), dtype=torch.float64)
        self._visible = data.layouts.state.size
        self._hidden = library.equations.layouts.state.size - self._visible
        self._compared = compared_fields(self.segments)
        measured = self.segments.measured[..., self._compared[1]].permute(2, 1, 0).contiguous()
        self._measured_columns = measured.permute(1, 2, 0)[:, None]  # (N, 1, S, columns)

    @property
    def log_names(self) -> tuple[str, ...]:
        """Name of every segment's log."""
        return tuple(self.data[log].name for log in self.segments.log)

    def residuals(self, sets: Tensor) -> Tensor:
        """Predicted less measured ``# (B, S, N·C)`` under parameter sets ``# (B, P)``."""
        parts = [self._residuals(part) for part in sets.split(BATCH)]
        return parts[0] if len(parts) == 1 else torch.cat(parts)

    def linearised(self, sets: Tensor, active: Sequence[Sequence[int]]) -> list[Tensor]:
        """Per set, residuals and their derivative by its active parameters ``# (S, R, 1 + A)``.

        Args:
            sets: parameter sets ``# (B, P)``.
            active: per set, slots of its free parameters; derivatives are in units of their scales.
        """
        rows, signs, (_, high) = [], [], self.library.bounds
        for values, slots in zip(sets, map(list, active), strict=True):
            step, moved = STEP * self.library.scale[slots], values.repeat(1 + len(slots), 1)
            signs.append(torch.where(values[slots] + step > high[slots], -1.0, 1.0).double())
            moved[range(1, len(moved)), slots] += signs[-1] * step
            rows.append(moved)
        everything = self.residuals(torch.cat(rows)).transpose(0, 1)  # (S, B, R)
        parts = everything.split([len(moved) for moved in rows], dim=1)
        for columns, sign in zip(parts, signs, strict=True):
            columns[:, 1:] -= columns[:, :1]
            columns[:, 1:] /= STEP * sign[:, None]
        return [columns.mT for columns in parts]

    def start_jacobian(self, values: Tensor) -> Tensor:
        """Derivative of residuals by the start state's tangent ``# (S, R, tangent)`` at one set ``# (P,)``."""
        size = self.segments.layout.tangent_size
        moves = torch.cat([torch.zeros(1, size), torch.eye(size)]).double() * START_STEP
        residuals = self._residuals(values.expand(size + 1, -1), moves=moves)
        return ((residuals[1:] - residuals[0]) / START_STEP).permute(1, 2, 0)

    def disturbance_jacobian(self, values: Tensor, disturbances: Sequence[tuple[str, float]], pieces: int) -> Tensor:
        """Derivative by disturbances, each held over one piece of a segment ``# (S, R, disturbances, pieces)``.

        Args:
            values: parameter set ``# (P,)``.
            disturbances: input or action column and the size that counts as one.
            pieces: per segment.
        """
        layouts, steps = self.library.equations.layouts, self.segments.length - 1
        edges, count = self.segments.edges(pieces), len(disturbances) * pieces + 1
        actions, inputs = (torch.zeros(count, 1, steps, len(group)) for group in (layouts.action, layouts.inputs))
        for i, (column, size) in enumerate(disturbances):
            target, layout = (inputs, layouts.inputs) if column in layouts.inputs else (actions, layouts.action)
            for j in range(pieces):
                target[1 + i * pieces + j, 0, edges[j] : edges[j + 1], layout.index(column)] = size * STEP
        moved = self._residuals(values.expand(count, -1), pushes=(actions.double(), inputs.double()))
        return ((moved[1:] - moved[0]) / STEP).reshape(len(disturbances), pieces, *moved.shape[1:]).permute(2, 3, 0, 1)

    def _residuals(self, sets: Tensor, moves: Tensor | None = None, pushes: Pushes = None) -> Tensor:
        layout, columns = self._compared
        states = self._states(sets, moves, pushes, columns)
        difference = layout.difference(states.permute(2, 0, 1, 3), self._measured_columns)  # (N, B, S, C), as it lies
        return difference.nan_to_num_(nan=1e3).clamp_(-1e3, 1e3).permute(1, 2, 0, 3).flatten(-2)

    def states(self, sets: Tensor) -> Tensor:
        """Predicted measurements of every row of the segments ``# (B, S, N, state)``."""
        return self._states(sets, None, None, range(self._visible))

    def states_by_segment(self, sets: Tensor, which: Tensor) -> Tensor:
        """Predicted measurements of every segment under a parameter set of its own ``# (S, N, state)``.

        Args:
            sets: ``# (K, P)``.
            which: row of ``sets`` for each segment ``# (S,)``.
        """
        states = torch.empty(len(self.segments), self.segments.length, self._visible, dtype=torch.float64)
        for number in which.unique():
            mine = which == number
            states[mine] = Problem(self.library, self.data, self.segments.of(mine)).states(sets[number][None])[0]
        return states

    def _states(self, sets: Tensor, moves: Tensor | None, pushes: Pushes, columns: Sequence[int]) -> Tensor:
        library, segments = self.library, self.segments
        parameters = self._defaults.repeat(len(sets), 1, 1)  # (B, 1, all)
        parameters[:, 0, list(library.columns)] = sets
        log, ahead = torch.as_tensor(segments.log)[:, None], torch.as_tensor(segments.ahead())
        commands = self._commands.of(sets)  # (U, logs, T, m), row of each set
        sent = commands[0][commands[1][:, None, None], log, ahead]
        known = self._inputs[log, ahead].expand(len(sets), -1, -1, -1)
        start = self._start(segments.start, sets, parameters, moves)
        if hidden_start_of(library.form) is not None:  # hidden states run through the rows before, where they matter
            start, busy = pad(start, (0, self._hidden)), library.busy(sets, library.remembering)
            if busy.any():
                hidden = self._warmed_up((commands[0], commands[1][busy]), sets[busy], parameters[busy])
                start[busy, ..., self._visible :] = hidden
        if pushes is not None:
            sent = sent + pushes[0].repeat(1, 1, 1, library.parts(self.data.dt))
            known = known + pushes[1]
        predicted = self._rolled_out(start, sent, known, parameters)
        turned = library.busy(sets, library.measuring)
        states = _with_first(start, predicted, columns)
        if turned.any():
            whole = _with_first(start[turned], predicted[turned], range(start.shape[-1]))
            states[turned] = self._measured(whole, parameters[turned][..., None, :])[..., columns]
        return states

    def _start(self, measured: Tensor, sets: Tensor, parameters: Tensor, moves: Tensor | None) -> Tensor:
        """State whose measurement is ``measured``, moved by a tangent step ``# (B, S, state)``."""
        layout = self.segments.layout
        start = measured.expand(len(parameters), -1, -1)
        turned = self.library.busy(sets, self.library.measuring)
        if turned.any():
            start = start.clone()
            start[turned] = self._unmeasured(measured, parameters[turned])
        return start if moves is None else layout.retract(start, moves[:, None].expand(-1, start.shape[1], -1))

    @cached_property
    def _unsensed(self) -> tuple[Tensor, Tensor]:
        """States that the base's own sensors report as the start ``# (S, state)``, and how they follow the report."""
        sensors = Sensors(self.library.base)
        start = sensors.state(self.segments.start)
        return start, sensors.inverse_slope(start)

    def _unmeasured(self, measured: Tensor, parameters: Tensor) -> Tensor:
        """State whose measurement is ``measured # (S, state)`` under parameters ``# (B, 1, all)``."""
        layout, (start, slope) = self.segments.layout, self._unsensed
        start = start.expand(len(parameters), -1, -1)
        for _ in range(2):
            reported = self._measured(pad(start, (0, self._hidden)), parameters)[..., : self._visible]
            start = layout.retract(start, -(slope @ layout.difference(reported, measured)[..., None])[..., 0])
        return start

    def _measured(self, states: Tensor, parameters: Tensor) -> Tensor:
        if (output := output_of(self.library.form)) is None:
            return states
        given = [states, parameters.expand(*states.shape[:-1], -1)] if parameters.shape[-1] else [states]
        measured: Tensor = output(*given)
        return measured

    def _warmed_up(self, commands: tuple[Tensor, Tensor], sets: Tensor, parameters: Tensor) -> Tensor:
        """Hidden states at the start: they run through the rows before it, from a start in rest.

        Args:
            commands: of :meth:`FilteredCommands.of`.
            sets: ``# (B, P)``.
            parameters: ``# (B, 1, all)``.
        """
        segments, first = self.segments, hidden_start_of(self.library.form)
        log, rows = torch.as_tensor(segments.log)[:, None], segments.rows_before()
        sent, known = commands[0][commands[1][:, None, None], log, rows], self._inputs[log, rows]
        whole = pad(self._start(segments.before, sets, parameters, None), (0, self._hidden))
        groups = [whole, sent[..., 0, : len(self.data.layouts.action)], known[:, 0], parameters]
        groups = [g.expand(*whole.shape[:-1], -1) for g in groups if g.shape[-1]]
        assert first is not None
        whole[..., self._visible :] = first(*groups)
        moved = self._rolled_out(whole, sent, known.expand(len(parameters), -1, -1, -1), parameters)
        return moved[:, torch.arange(len(segments)), torch.as_tensor(segments.warm_up) - 1, self._visible :]

    def _rolled_out(self, start: Tensor, actions: Tensor, inputs: Tensor, parameters: Tensor) -> Tensor:
        """States after each action ``# (B, S, N, state)``: the one place where the diagnosis rolls out."""
        with torch.no_grad():
            return rollout(self.library.model(self.data.dt), start, actions, inputs, parameters)


def _with_first(first: Tensor, others: Tensor, columns: Sequence[int]) -> Tensor:
    """Columns of the states of all rows ``# (B, S, N, columns)``, each in one piece of memory, row by row."""
    sets, segments, steps, _ = others.shape
    states = torch.empty(len(columns), steps + 1, sets, segments, dtype=others.dtype)
    for own, column in zip(states, columns, strict=True):
        own[0], own[1:] = first[..., column], others[..., column].movedim(-1, 0)
    return states.permute(2, 3, 1, 0)
