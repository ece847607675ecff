"""Training of a residual on a frozen base: Stage III of the paper.

::

    loss = mean over windows, steps and columns of (e / σ)² + λ · mean over rows and columns of (r / ρ)²

e: error of a rollout from a measured row (:mod:`sym2real.neural.batch`), one step or several; σ: root mean square of
the base's own, so that the base's loss is 1; r: residual; ρ: what a step lacks, by σ. Networks learn from short windows
first, with every λ, then with the best one from whole ones, whose errors are sums of what short ones tell. λ is chosen
by validation on whole windows, inside bounds, and so is the share of every column's residual
(:mod:`sym2real.neural.judged`). Sources: the paper, "Residual learning"; AdamW: I. Loshchilov, F. Hutter, "Decoupled
weight decay regularization", ICLR 2019.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import torch
from torch import Tensor

from sym2real.dataset import Transitions
from sym2real.errors import ModelError, ShapeError
from sym2real.layout import Layouts
from sym2real.neural.batch import Batch
from sym2real.neural.blocks import EVERY, blocks_of, windows_of
from sym2real.neural.bounded import bounded, unbounded
from sym2real.neural.composed import Base, Composed, state_of
from sym2real.neural.cyclic import cyclic_coordinates
from sym2real.neural.descent import Descent
from sym2real.neural.judged import CrossValidated
from sym2real.neural.leftover import leftover
from sym2real.neural.multi_step import Scales
from sym2real.neural.networks import Networks
from sym2real.neural.normal import Normal
from sym2real.neural.residual_mlp import ResidualMLP
from sym2real.threads import one_thread

SHORT = 5  # rows of the windows that networks learn from first
FIRST = 0.75  # share of the steps on them, with every λ; the rest is spent on whole rollouts with the best one
SLOWER = 0.3  # share of the learning rate with which the rest begins


@dataclass(frozen=True)
class TrainingReport:
    """What a training found.

    Args:
        penalty: λ that validated best; None where no residual did better than none.
        error: mean squared error on rows held out over the base's.
        columns: state columns that have a residual.
        rows: transitions in all.
        seconds: on the clock.
    """

    penalty: float | None
    error: float
    columns: tuple[str, ...]
    rows: int
    seconds: float


@dataclass(frozen=True)
class ResidualTraining:
    """A :class:`~sym2real.protocols.Learner` of residuals.

    Args:
        widths: of the hidden layers; :data:`~sym2real.neural.networks.PAPER` has the paper's. One more holds the
            bounds of the outputs.
        steps: rows of a rollout that the loss follows; with 1 it is of two, because the first one teaches nothing.
        penalties: λ to choose from. The largest leaves half of what the data ask for, the smallest nearly all; no
            residual at all is always among the choices.
        commands, states: past rows that the residual sees.
        seed: of the first weights, the folds and the order of windows.
        descent: how weights are found.

    Raises:
        ModelError: without a penalty above zero, or a step.

    Examples:
        >>> ResidualTraining(commands=10).widths
        (64, 64)
    """

    widths: Sequence[int] = (64, 64)
    steps: int = 20
    penalties: Sequence[float] = (1e-3, 1e-2, 1e-1)
    commands: int = 0
    states: int = 0
    seed: int = 0
    descent: Descent = field(default_factory=Descent)

    def __post_init__(self) -> None:
        if not self.penalties or min(self.penalties) <= 0 or self.steps < 1:
            raise ModelError(
                f"training needs penalties above 0 and at least one step, found {(*self.penalties,)} and {self.steps}"
            )

    def fit(self, transitions: Transitions, base: Base, start: Composed | None = None) -> Composed:
        """The base with a residual on top; see :meth:`fit_reported`."""
        return self.fit_reported(transitions, base, start)[0]

    def fit_reported(
        self, transitions: Transitions, base: Base, start: Composed | None = None
    ) -> tuple[Composed, TrainingReport]:
        """The base with a residual on top, and how that came about.

        Args:
            transitions: of the target.
            base: frozen.
            start: an earlier result, whose weights training begins with.

        Raises:
            ModelError: for too few consecutive transitions.
            ShapeError: for other columns than the base's, or a start of another shape.
        """
        began = time.perf_counter()
        with one_thread():
            residual, penalty, error = self._trained(transitions, base, start)
        on = tuple(c for c, size in zip(state_of(base), residual.output_scale.tolist(), strict=True) if size)
        seconds = time.perf_counter() - began
        return Composed(base, residual), TrainingReport(penalty if on else None, error, on, len(transitions), seconds)

    def _trained(
        self, transitions: Transitions, base: Base, start: Composed | None
    ) -> tuple[ResidualMLP, float, float]:
        """The residual, its λ, and its error on rows held out over the base's."""
        layouts = Layouts(state_of(base), base.layouts.action)
        rows = leftover(transitions, base, self.commands, self.states)
        steps = max(2, self.steps)
        blocks = blocks_of(rows.runs, steps, self.seed)
        starts, fold = windows_of(*blocks, steps)
        scales = Scales.of(rows, starts, steps)
        seen = [layouts.state, layouts.action, *[layouts.action] * self.commands, *[layouts.state] * self.states]
        normal = Normal.of(rows.seen, seen, scales.residual, cyclic_coordinates(base))
        batch = Batch.of(rows, starts, fold, normal, scales)
        starts, fold = windows_of(*blocks, few := min(SHORT, steps))
        short = Batch.of(rows, starts, fold, normal, Scales.of(rows, starts, few))
        networks = Networks((len(normal.mean), *self.widths, len(layouts.state)), (EVERY + 1) * len(self.penalties))
        numbers = torch.arange(networks.count)
        normal.begin_with(networks, self._residual(layouts, self.widths).layers(), numbers)
        if start is not None:
            normal.begin_with(networks, self._layers_of(start, layouts), numbers[-len(self.penalties) :])
        penalties, descent = torch.tensor(self.penalties, dtype=torch.float32), self.descent
        first = replace(descent, steps=round(FIRST * descent.steps))
        errors = CrossValidated(networks, short, batch, penalties, rows=descent.rows, seed=self.seed).descend(first)
        best = int(errors.argmin())
        networks = networks.only(numbers[best :: len(penalties)])
        judged = CrossValidated(networks, batch, batch, penalties[best : best + 1], rows=descent.rows, seed=self.seed)
        rest = replace(descent, steps=descent.steps - first.steps, learning_rate=SLOWER * descent.learning_rate)
        judged.descend(rest)
        share, error = judged.shares(layouts.state)
        with torch.no_grad():
            layers = [(weight[-1], bias[-1, 0]) for weight, bias in networks.pairs()]
            layers = bounded(layers, networks(batch.seen)[-1])
        residual = self._residual(layouts, (*self.widths, 2 * len(share)))
        normal.write(layers, residual, share)
        return residual, self.penalties[best], error

    def _residual(self, layouts: Layouts, widths: Sequence[int]) -> ResidualMLP:
        return ResidualMLP(layouts, widths, self.seed, self.commands, self.states)

    def _layers_of(self, start: Composed, layouts: Layouts) -> list[tuple[Tensor, Tensor]]:
        """Weights of an earlier result, over raw columns."""
        begin, widths = start.residual, (*self.widths, 2 * len(layouts.state))
        wanted = f"a start of widths {widths} that sees {self.commands} past commands, {self.states} states"
        if not isinstance(begin, ResidualMLP):
            raise ShapeError(f"expected {wanted}, found one of expressions")
        if (begin.widths, begin.commands, begin.states) != (widths, self.commands, self.states):
            raise ShapeError(f"expected {wanted}; found {begin.widths}, {begin.commands}, {begin.states}")
        return unbounded(begin.layers())
