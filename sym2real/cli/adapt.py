"""``sym2real adapt``: a model that learns from a simulator or from logs what it lacks, one trajectory at a time."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rich.console import Console

from sym2real.cli.adapting import AdaptVerb
from sym2real.cli.of_logs import OfLogs
from sym2real.cli.positionals import OptionalTask, TargetPlace

if TYPE_CHECKING:
    from sym2real.cli.adapt_target import Chosen
    from sym2real.neural import Model


@dataclass(frozen=True, kw_only=True)
class Adapt(OfLogs, AdaptVerb):
    """Adapt a model to a target: an episode with the present model, training on all so far, and again.

    The model stays frozen, and what is learned goes on top of it, unless its own constants are asked for. The model of
    every round is tested on a trajectory that it has not seen, and compared there with the best one before; the run
    ends by itself when two rounds in a row bring nothing. A model whose predictions leave the robot's limits does not
    fly: the best one so far flies again.

    TARGET is a robot's name (its plain simulator), the folder of a simulator that `add` or `diagnose` wrote, or a
    folder of logs. With logs nothing flies: they come in the order of their names, one a round.

    A model that was adapted before flies as it is in round 0; the rounds learn on its equations from their own logs.

    OUT holds the best model, which every verb opens, adaptation.json and a figure, and in rounds/NN the model and the
    log of every round. An interrupted run continues there; --undo N puts the model of an earlier round in its place.

    For example:
      sym2real add runs/base wind fx=0.02 --out runs/windy
      sym2real adapt runs/base runs/windy/simulator circle --out runs/adapted
      sym2real adapt runs/base flights --spec flight.toml --out runs/adapted
    """

    target: TargetPlace
    """What to adapt to: a robot's name, the folder of a simulator, or a folder of logs."""
    task: OptionalTask = None
    """What is flown: hover, circle, lemniscate, track, park or reverse_circle; nothing with logs."""
    noise: bool = False
    """Sensor noise in the simulator, as of `simulate`; without it errors of any size count for --diagnose."""

    def chosen(self, model: Model, console: Console) -> AbstractContextManager[Chosen]:
        """A simulator, or logs."""
        from sym2real.cli.adapt_target import chosen_target
        from sym2real.neural.model_folder import below

        return nullcontext(
            chosen_target(below(model), self.model, self.target, self.task, spec=self.naming, noise=self.noise)
        )
