"""Windows that several networks are trained and judged on: rollouts in which each network sees what it predicts.

::

    e_0 = 0,   x_0 = d_before,   (e, x)_k+1 = A_k (e, x)_k + d_k + G_k r(s_k ⊕ x_k, a_k)

e: error of a rollout from a measured row; x: of one that began a row earlier, which the network sees. It sees the state
that a rollout has reached and not the measured one, so that a model which leads itself astray is seen to do so, in
training as in validation. The noise of the measured row is an error of all that follows, and who saw this row would
learn to take its noise away instead of what the base lacks: the rollout that is seen knows nothing of it (errors in
variables; instrumental variables: L. Ljung, System Identification, 2nd ed., 7.6). A controller has answered this noise
at the first row: what networks say there has no gradient.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from sym2real.layout import Layout
from sym2real.neural.leftover import Leftover
from sym2real.neural.multi_step import Scales
from sym2real.neural.networks import Networks
from sym2real.neural.normal import Normal


@dataclass(frozen=True, eq=False)
class Batch:
    """Rows of logs and the windows in them; n state columns, t tangent components.

    Args:
        seen: normalised inputs of the networks ``# (rows, seen)``.
        felt: how these follow an error of the state ``# (rows, seen, t)``.
        error: the base's one-step errors ``# (rows, t, 1)``.
        moved: what a network's outputs add to them ``# (rows, t, n)``.
        carried: how errors go on ``# (rows, t, t)``.
        starts: first rows of windows, a row of the same log before each ``# (windows,)``.
        fold: which fold a window lies in ``# (windows,)``.
        scale: of errors, one for all components of an attitude ``# (steps, 1, t, 1)``.
    """

    seen: Tensor
    felt: Tensor
    error: Tensor
    moved: Tensor
    carried: Tensor
    starts: Tensor
    fold: Tensor
    scale: Tensor

    @classmethod
    def of(cls, rows: Leftover, starts: Tensor, fold: Tensor, normal: Normal, scales: Scales) -> Batch:
        """These windows."""
        size, tangent = rows.turned.shape[1:]
        felt = rows.seen.new_zeros(len(rows), rows.seen.shape[1], tangent)
        felt[:, :size] = rows.turned
        return cls(
            normal(rows.seen),
            felt[:, normal.kept] / normal.scale[:, None],
            rows.error[:, :, None],
            rows.moved * normal.output,
            rows.carried,
            starts,
            fold,
            _of_fields(scales.error, rows.layout),
        )

    def rolled(self, networks: Networks, windows: Tensor) -> tuple[Tensor, Tensor]:
        """Errors by the scale ``# (steps, windows, t, count)``, and outputs ``# (steps, windows, n, count)``.

        Args:
            networks: count of them.
            windows: numbers of the windows.
        """
        reached = self.error[self.starts[windows] - 1].repeat(1, 1, networks.count)
        wrong, errors, outputs = torch.zeros_like(reached), list[Tensor](), list[Tensor]()
        for step in range(len(self.scale)):
            row = self.starts[windows] + step
            seen = self.seen[row] + (self.felt[row] @ reached).permute(2, 0, 1)
            # Products of matrices that do not lie in one piece are computed one by one.
            output = networks(seen.contiguous()).permute(1, 2, 0).contiguous()
            output = output if step else output.detach()
            added = self.error[row] + self.moved[row] @ output
            reached, wrong = (torch.baddbmm(added, self.carried[row], at) for at in (reached, wrong))
            errors.append(wrong)
            outputs.append(output)
        return torch.stack(errors) / self.scale, torch.stack(outputs)

    def parts(self, outputs: Tensor, windows: Tensor) -> tuple[Tensor, Tensor]:
        """Errors by the scale of the base, and what each column of given outputs adds to them.

        Args:
            outputs: of a network along the windows ``# (steps, windows, n)``.
            windows: their numbers.

        Returns:
            ``# (steps, windows, t, 1)`` and ``# (steps, windows, t, n)``.
        """
        errors = list[Tensor]()
        for step, output in enumerate(outputs):
            row = self.starts[windows] + step
            moved = self.moved[row] * output[:, None, :]
            own = torch.cat([self.error[row], moved], dim=-1)
            errors.append(own + self.carried[row] @ errors[-1] if step else own)
        both = torch.stack(errors) / self.scale
        return both[..., :1], both[..., 1:]


def _of_fields(scale: Tensor, layout: Layout) -> Tensor:
    """One for all tangent components of an attitude: each of its columns moves all of them.

    A torque about one axis, by what the base lacks, moves the others a little. Measured by the base's own errors, which
    may be hundreds of times less there, this would cost more than the torque brings.
    """
    scale = scale.clone()
    for field, places in zip(layout.fields, layout.tangent_places, strict=True):
        if field.kind != "vector":
            scale[:, :, list(places)] = scale[:, :, list(places)].square().mean(2, keepdim=True).sqrt()
    return scale
