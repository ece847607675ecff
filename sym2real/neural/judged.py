"""Networks that are trained on all rows, and beside each of them five that judge it: each leaves out a fifth.

What is chosen, λ, the step at which training ends and the shares of columns, is chosen by the error of the five on the
rows that each left out, so that every row of every log judges (cross-validation by blocks of time). The network that
was trained on all of them is then the one to take. Where the base is worse than in the mean, errors count by its own
there: else the first second of a flight, of which no other stretch tells anything, would choose alone. Source: T.
Hastie, R. Tibshirani, J. Friedman, "The Elements of Statistical Learning", 2nd ed., section 7.10.
"""

import torch
from torch import Tensor

from sym2real.generator import generator_of
from sym2real.layout import Layout
from sym2real.neural.batch import Batch
from sym2real.neural.blocks import EVERY
from sym2real.neural.descent import Descent, descend
from sym2real.neural.networks import Networks
from sym2real.neural.stacking import shares

JUDGING = 100  # windows between steps of the descent


class CrossValidated:
    """Losses of ``(EVERY + 1) · λs`` networks: those of the first fold with each λ, …, those of all rows with each λ.

    Args:
        networks: so many.
        taught: windows that the networks learn from.
        judging: windows that judge them, in the same folds.
        penalties: λ ``# (λs,)``.
        rows: of a step of the descent.
        seed: of the order of windows.
    """

    def __init__(
        self, networks: Networks, taught: Batch, judging: Batch, penalties: Tensor, *, rows: int, seed: int
    ) -> None:
        self._networks, self._taught, self._judging = networks, taught, judging
        self._penalties = penalties.repeat(EVERY + 1)
        self._held = taught.fold[:, None] == torch.arange(networks.count) // len(penalties)
        self._every = torch.arange(len(judging.starts))
        none = judging.error.new_zeros(len(judging.scale), len(self._every), judging.moved.shape[-1])
        base, _ = judging.parts(none, self._every)
        self._weight = 1.0 / base.square().mean((0, 2, 3)).clamp(min=1.0)
        self._size = max(1, rows // len(taught.scale))
        self._generator = generator_of(seed)
        self._order = torch.arange(0)
        self._some = self._every[:: max(1, len(self._every) // JUDGING)]

    def loss(self, step: int) -> Tensor:
        """Of each network on the next windows that it does not leave out, with its penalty ``# (count,)``."""
        if len(self._order) < self._size:
            self._order = torch.cat([self._order, torch.randperm(len(self._held), generator=self._generator)])
        windows, self._order = self._order[: self._size], self._order[self._size :]
        errors, outputs = self._taught.rolled(self._networks, windows)
        taught = (~self._held[windows]).float()
        error = (errors.square().mean((0, 2)) * taught).sum(0) / taught.sum(0).clamp(min=1.0)
        size: Tensor = self._penalties * outputs.square().mean((0, 1, 2))
        return error + size

    def descend(self, settings: Descent) -> Tensor:
        """Train, and give the error that validates each λ ``# (λs,)``."""
        return descend(self._networks, self.loss, self.validate, settings).view(EVERY + 1, -1)[-1]

    @torch.no_grad()
    def validate(self) -> Tensor:
        """Error of the five with each λ on what each left out, for all networks with that λ ``# (count,)``."""
        errors, _ = self._judging.rolled(self._networks, self._some)
        own = self._own(errors.square().mean((0, 2)), self._some) * self._weight[self._some, None]
        return own.mean(0).repeat(EVERY + 1)

    @torch.no_grad()
    def shares(self, layout: Layout) -> tuple[Tensor, float]:
        """Shares of the columns ``# (n,)``, and the error that they leave over the base's; of networks with one λ."""
        _, outputs = self._judging.rolled(self._networks, self._every)
        own = self._own(outputs.permute(1, 0, 2, 3), self._every)[..., 0]
        root = self._weight.sqrt()[:, None, None]
        base, parts = (errors * root for errors in self._judging.parts(own.permute(1, 0, 2), self._every))
        by_column = shares(base, parts, layout)
        left = (base + (parts @ by_column)[..., None]).square().mean() / base.square().mean()
        return by_column, float(left)

    def _own(self, values: Tensor, windows: Tensor) -> Tensor:
        """Of values ``# (windows, ..., count)`` those of who left the window out ``# (windows, ..., λs)``."""
        by_fold = values.unflatten(-1, (EVERY + 1, -1))
        own: Tensor = by_fold.movedim(-2, 1)[torch.arange(len(windows)), self._judging.fold[windows]]
        return own
