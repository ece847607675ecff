"""Stage I: learning a base model in a plain simulator. Stages II and III: adapting a model to a target."""

from sym2real.adaptation.base_learning import (
    BaseModel as BaseModel,
    StageOne as StageOne,
    learn_base as learn_base,
    stage_one as stage_one,
)
from sym2real.adaptation.episode_report import (
    EpisodeReport as EpisodeReport,
    episode_cost as episode_cost,
    episode_error as episode_error,
    tracking_error as tracking_error,
)
from sym2real.adaptation.loop import Adaptation as Adaptation, Adapting as Adapting, adapt as adapt
from sym2real.adaptation.paired_gain import Improvement as Improvement, improvement as improvement
from sym2real.adaptation.progress import Progress as Progress
from sym2real.adaptation.round_report import RoundReport as RoundReport
