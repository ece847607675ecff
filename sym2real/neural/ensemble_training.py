"""Training of an ensemble on transitions alone: the paper's neural base, from scratch or further from where it stands.

Each member sees rows of its own, drawn with replacement (bootstrap), so that members differ where data are few, and
leaves out a fold, by which it ends early. A deterministic ensemble minimises the squared error of the state's change, a
probabilistic one the Gaussian negative log-likelihood with learned bounds of the variance. Source: K. Chua et al.
(PETS), NeurIPS 2018, section 4 and A.1.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, field

import torch
from torch import Tensor

from sym2real.dataset import Transitions
from sym2real.effects.along_logs import require_step
from sym2real.errors import ShapeError
from sym2real.generator import generator_of
from sym2real.layout import Layouts
from sym2real.neural.blocks import blocks_of
from sym2real.neural.descent import Descent, descend
from sym2real.neural.ensemble import Ensemble
from sym2real.neural.leftover import runs_of
from sym2real.neural.networks import PAPER
from sym2real.neural.normal import Normal
from sym2real.threads import one_thread

BOUNDS = 0.01  # weight of the width between the variance's bounds (PETS, A.1)


@dataclass(frozen=True)
class EnsembleTraining:
    """A :class:`~sym2real.protocols.Learner` of ensembles.

    Args:
        members: networks.
        widths: of their hidden layers; the paper's by default.
        probabilistic: predict variances too.
        robot: name to note in the ensemble.
        seed: of the first weights and the rows that each member sees.
        descent: how weights are found.
    """

    members: int = 4
    widths: Sequence[int] = PAPER
    probabilistic: bool = False
    robot: str = ""
    seed: int = 0
    descent: Descent = field(default_factory=lambda: Descent(steps=2000, learning_rate=1e-3, rows=256))

    def fit(self, transitions: Transitions, base: Ensemble | None = None, start: Ensemble | None = None) -> Ensemble:
        """An ensemble for these transitions.

        Args:
            transitions: rows; a wrench among their inputs is not seen.
            base: fine-tuned where it is given: training begins with its weights and scales. It stays as it is.
            start: an earlier result, that training goes on from instead.

        Raises:
            ModelError: for too few consecutive transitions.
            ShapeError: for a base or start of other columns, members or widths, or of another time step.
        """
        with one_thread():
            ensemble = self._begin(transitions, start or base)
            rows = _Rows.of(transitions, ensemble, self.seed)
            descend(
                ensemble.networks,
                lambda _: rows.loss(ensemble, self.descent.rows) + BOUNDS * _width(ensemble),
                lambda: rows.validation(ensemble),
                self.descent,
                beside=[ensemble.lowest, ensemble.highest] if self.probabilistic else (),
            )
        return ensemble.requires_grad_(requires_grad=False)

    def _begin(self, transitions: Transitions, start: Ensemble | None) -> Ensemble:
        layouts = Layouts(transitions.layouts.state, transitions.layouts.action)
        ensemble = Ensemble(
            layouts,
            self.members,
            self.widths,
            self.seed,
            probabilistic=self.probabilistic,
            dt=transitions.dt,
            robot=self.robot,
        )
        if start is not None:
            shape = [(e.columns, e.networks.count, e.widths, e.probabilistic) for e in (ensemble, start)]
            if shape[0] != shape[1]:
                raise ShapeError(f"expected an ensemble of columns, members and widths {shape[0]}, found {shape[1]}")
            require_step(start.dt, transitions.dt)
            ensemble = copy.deepcopy(start).float()
            return ensemble.requires_grad_(requires_grad=True)
        state, action = (torch.as_tensor(v).float() for v in (transitions.state, transitions.action))
        change = _change(transitions)
        size = change.square().mean(0).sqrt()
        normal = Normal.of(torch.cat([state, action], dim=-1), [layouts.state, layouts.action], size)
        ensemble.input_mean.copy_(normal.mean)
        ensemble.input_scale.copy_(normal.scale)
        ensemble.output_scale.copy_(torch.where(size > 0, size, 1.0))
        return ensemble


@dataclass(frozen=True, eq=False)
class _Rows:
    """What is seen and the change that followed; which rows each member draws from, and which validate it."""

    seen: Tensor
    change: Tensor
    drawn: Tensor
    held: Tensor
    generator: torch.Generator

    @classmethod
    def of(cls, transitions: Transitions, ensemble: Ensemble, seed: int) -> _Rows:
        """The bootstrap of every member over all folds but one, of which as many rows validate each."""
        blocks, folds = blocks_of(runs_of(transitions), 1, 0)
        generator = generator_of(seed)
        rows = torch.cat([torch.arange(*block) for block in blocks])
        fold = torch.cat([torch.full((end - first,), at) for (first, end), at in zip(blocks, folds, strict=True)])
        count = max(folds) + 1  # the middle of a log first: of its beginning the rest tells least
        out = [fold == (member + count // 2) % count for member in range(ensemble.networks.count)]
        fewest = min(int(mine.sum()) for mine in out)
        drawn = [
            rows[~mine][torch.randint(int((~mine).sum()), (len(rows) - fewest,), generator=generator)] for mine in out
        ]
        held = [rows[mine][torch.randperm(int(mine.sum()), generator=generator)[:fewest]] for mine in out]
        seen = torch.cat([torch.as_tensor(v).float() for v in (transitions.state, transitions.action)], dim=-1)
        seen = (seen - ensemble.input_mean) / ensemble.input_scale
        change = _change(transitions) / ensemble.output_scale
        return cls(seen, change, torch.stack(drawn), torch.stack(held), generator)

    def loss(self, ensemble: Ensemble, size: int) -> Tensor:
        """Of each member on rows of its own ``# (members,)``."""
        count = self.drawn.shape[1]
        return self._of(ensemble, self.drawn[:, torch.randint(count, (min(size, count),), generator=self.generator)])

    def validation(self, ensemble: Ensemble) -> Tensor:
        """Of each member on rows that it leaves out ``# (members,)``."""
        return self._of(ensemble, self.held)

    def _of(self, ensemble: Ensemble, chosen: Tensor) -> Tensor:
        return _misfit(ensemble, ensemble.networks(self.seen[chosen]), self.change[chosen])


def _misfit(ensemble: Ensemble, outputs: Tensor, change: Tensor) -> Tensor:
    squares = (outputs[..., : ensemble.size] - change).square()
    if ensemble.probabilistic:
        log_variance = ensemble.log_variance(outputs)
        squares = squares * (-log_variance).exp() + log_variance
    return squares.mean((1, 2))


def _width(ensemble: Ensemble) -> Tensor:
    """Of the bounds of the logarithm of the variance; zero where there is none."""
    if not ensemble.probabilistic:
        return torch.zeros(())
    return (ensemble.highest - ensemble.lowest).sum() / ensemble.networks.count


def _change(transitions: Transitions) -> Tensor:
    """Change of the state ``# (rows, n)``; of a quaternion to whichever of q and -q is nearer."""
    layout = transitions.layouts.state
    state, following = torch.as_tensor(transitions.state), torch.as_tensor(transitions.next_state).clone()
    for place in (layout.slice(part.name) for part in layout.fields if part.kind == "quaternion"):
        along = (following[:, place] * state[:, place]).sum(-1, keepdim=True)
        following[:, place] *= torch.where(along < 0, -1.0, 1.0)
    return (following - state).float()
