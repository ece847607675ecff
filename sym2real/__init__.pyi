"""The public names and where they are: for type checkers, and for the package, which imports each on first use."""

from sym2real.adaptation import StageOne as StageOne, learn_base as learn_base
from sym2real.adaptation.loop import Adapting as Adapting, adapt as adapt
from sym2real.control import MPPI as MPPI
from sym2real.data import example_flight as example_flight
from sym2real.dataset import Dataset as Dataset
from sym2real.diagnosis import (
    add as add,
    compare as compare,
    diagnose as diagnose,
    plan as plan,
    try_effect as try_effect,
)
from sym2real.effects import EFFECTS as EFFECTS
from sym2real.effects.catalogue import effect as effect
from sym2real.experiments.standard_conditions import sensors as sensors
from sym2real.layout import Layout as Layout, Layouts as Layouts
from sym2real.logs import (
    LogSpec as LogSpec,
    inspect_logs as inspect_logs,
    read_log as read_log,
    read_logs as read_logs,
    write_log as write_log,
)
from sym2real.neural import ResidualTraining as ResidualTraining, open_model as open_model
from sym2real.plants import (
    EquationsPlant as EquationsPlant,
    ModelPlant as ModelPlant,
    MujocoPlant as MujocoPlant,
    run_episode as run_episode,
)
from sym2real.regression import ENGINES as ENGINES, BeamSearch as BeamSearch, Operon as Operon, PySR as PySR
from sym2real.robots import ROBOTS as ROBOTS, Robot as Robot, car as car, quadrotor as quadrotor
from sym2real.symbolic import (
    Equations as Equations,
    compile_model as compile_model,
    load_model as load_model,
    rollout as rollout,
    save_model as save_model,
)
from sym2real.tasks import TASKS as TASKS, Task as Task, make_task as make_task
from sym2real.trajectory import Trajectory as Trajectory

__version__: str
