"""Stage I: learning a base model in a plain simulator. Stages II and III: adapting a model to a target."""

from sym2real.adaptation.adapt import Adaptation, Adapting, adapt
from sym2real.adaptation.episode_report import EpisodeReport, episode_cost, episode_error, tracking_error
from sym2real.adaptation.improvement import Improvement, improvement
from sym2real.adaptation.progress import Progress
from sym2real.adaptation.round_report import RoundReport, settled
from sym2real.adaptation.stage_one import BaseModel, StageOne, learn_base, stage_one

__all__ = [
    "Adaptation",
    "Adapting",
    "BaseModel",
    "EpisodeReport",
    "Improvement",
    "Progress",
    "RoundReport",
    "StageOne",
    "adapt",
    "episode_cost",
    "episode_error",
    "improvement",
    "learn_base",
    "settled",
    "stage_one",
    "tracking_error",
]
