"""Stage I: learning a base model in a plain simulator. Stages II and III: adapting a model to a target."""

from sym2real.adaptation.adapt import Adaptation as Adaptation
from sym2real.adaptation.adapt import Adapting as Adapting
from sym2real.adaptation.adapt import adapt as adapt
from sym2real.adaptation.episode_report import EpisodeReport as EpisodeReport
from sym2real.adaptation.episode_report import episode_cost as episode_cost
from sym2real.adaptation.episode_report import episode_error as episode_error
from sym2real.adaptation.episode_report import tracking_error as tracking_error
from sym2real.adaptation.improvement import Improvement as Improvement
from sym2real.adaptation.improvement import improvement as improvement
from sym2real.adaptation.progress import Progress as Progress
from sym2real.adaptation.round_report import RoundReport as RoundReport
from sym2real.adaptation.stage_one import BaseModel as BaseModel
from sym2real.adaptation.stage_one import StageOne as StageOne
from sym2real.adaptation.stage_one import learn_base as learn_base
from sym2real.adaptation.stage_one import stage_one as stage_one
