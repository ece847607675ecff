"""Stage I: learning a base model in a plain simulator. Stages II and III: adapting a model to a target."""

from sym2real.adaptation.base_learning import BaseModel as BaseModel
from sym2real.adaptation.base_learning import StageOne as StageOne
from sym2real.adaptation.base_learning import learn_base as learn_base
from sym2real.adaptation.base_learning import stage_one as stage_one
from sym2real.adaptation.episode_report import EpisodeReport as EpisodeReport
from sym2real.adaptation.episode_report import episode_cost as episode_cost
from sym2real.adaptation.episode_report import episode_error as episode_error
from sym2real.adaptation.episode_report import tracking_error as tracking_error
from sym2real.adaptation.loop import Adaptation as Adaptation
from sym2real.adaptation.loop import Adapting as Adapting
from sym2real.adaptation.loop import adapt as adapt
from sym2real.adaptation.paired_gain import Improvement as Improvement
from sym2real.adaptation.paired_gain import improvement as improvement
from sym2real.adaptation.progress import Progress as Progress
from sym2real.adaptation.round_report import RoundReport as RoundReport
