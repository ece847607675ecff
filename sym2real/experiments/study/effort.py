"""How much a study does: a quick one for two cores and two hours, and the paper's own size."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar


@dataclass(frozen=True)
class Effort:
    """What every job of a study shares.

    Args:
        seeds: of the runs that are repeated; noise, starts and first weights go with them.
        rounds: of an adaptation, never fewer: a final value exists.
        rows: of an episode.
        samples: of MPPI by robot.
        evaluations: episodes that judge a model, with the same seeds for all.
        members, widths: of a neural base.
        neural_flights: trajectories that a neural base is learned from.
        episodes: of Stage I from scratch, by robot, for equations.
        neural_episodes: the same for networks; none where the budget forbids it.
        policy_steps: of PPO in the plain simulator; none where the budget forbids it.
        everywhere: a neural base is asked on every case, not on one per robot, and so is fine-tuning, which takes
            minutes for 200 constants on 4000 rows.
    """

    name: str
    seeds: tuple[int, ...]
    samples: Mapping[str, int]
    members: int = 4
    widths: tuple[int, ...] = (64, 64)
    rounds: int = 10
    rows: int = 400
    evaluations: int = 5
    neural_flights: int = 40
    episodes: Mapping[str, int] | None = None
    neural_episodes: Mapping[str, int] | None = None
    policy_steps: int = 0
    everywhere: bool = False

    def of_seeds(self, seeds: Sequence[int]) -> Effort:
        """The same with these seeds, each once: one that is said twice would make an interval of no width."""
        return replace(self, seeds=tuple(dict.fromkeys(seeds)) or self.seeds)

    def to_dict(self) -> dict[str, Any]:
        """What an answer depends on, as JSON holds it; the seeds belong to the jobs."""
        return {name: value for name, value in asdict(self).items() if name not in ("seeds", "everywhere")}


class OfStudy:
    """A job of a study: its answer depends on all that it holds, but for the base, which goes with the version."""

    NAME: ClassVar[str]  # of its file, with the names of its fields in braces
    effort: Effort

    @property
    def name(self) -> str:
        """Of its file."""
        return self.NAME.format_map(vars(self))

    @property
    def asked(self) -> dict[str, Any]:
        """Everything that the answer depends on."""
        held: dict[str, Any] = asdict(self)  # type: ignore[call-overload]  # every job is a dataclass
        return {name: value for name, value in held.items() if name not in {"effort", "base"}} | self.effort.to_dict()


@dataclass(frozen=True)
class OfBase(OfStudy):
    """A job about one base.

    Args:
        robot: name.
        model: "sr" or "nn".
        seed: of the training, with its starts, commands and samples.
        effort: of the study.
    """

    robot: str
    model: str
    seed: int
    effort: Effort


# MPPI with MuJoCo itself as its model, which all are held against on as many samples, decides how many there can be:
# with the paper's 1024 one action takes a second for a quadrotor, and six for a car.
QUICK = Effort(
    "quick",
    seeds=(1, 2, 3),
    samples={"crazyflie": 256, "mushr": 64},
    episodes={"crazyflie": 6, "mushr": 10},
)
FULL = Effort(
    "full",
    seeds=(1, 2, 3),
    samples={"crazyflie": 1024, "mushr": 1024},
    widths=(200, 200, 200, 200),
    neural_flights=160,
    episodes={"crazyflie": 15, "mushr": 25},
    neural_episodes={"crazyflie": 160, "mushr": 100},
    policy_steps=1_000_000,
    everywhere=True,
)
