"""What the loops tell while they run."""

from collections.abc import Callable
from dataclasses import dataclass

from sym2real.adaptation.episode_report import EpisodeReport
from sym2real.adaptation.round_report import RoundReport


@dataclass(frozen=True)
class Progress:
    """What is going on: ``done`` of ``total`` steps of ``what``; a report when an episode or a round is complete."""

    what: str
    done: int
    total: int
    report: EpisodeReport | RoundReport | None = None


OnProgress = Callable[[Progress], None]


def silent(_: Progress) -> None:
    """For those who ask for no progress."""
