"""Stage I: learning a base model in a plain simulator."""

from sym2real.adaptation.episode_report import EpisodeReport, episode_error, tracking_error
from sym2real.adaptation.stage_one import BaseModel, Progress, StageOne, learn_base, stage_one

__all__ = [
    "BaseModel",
    "EpisodeReport",
    "Progress",
    "StageOne",
    "episode_error",
    "learn_base",
    "stage_one",
    "tracking_error",
]
