"""Stage I: learning a base model in a plain simulator."""

from sym2real.adaptation.stage_one import (
    BaseModel,
    EpisodeReport,
    Progress,
    StageOne,
    learn_base,
    stage_one,
    tracking_error,
)

__all__ = ["BaseModel", "EpisodeReport", "Progress", "StageOne", "learn_base", "stage_one", "tracking_error"]
