"""The public names and where they are: for type checkers, and for the package, which imports each on first use."""

from sym2real.adaptation import StageOne as StageOne
from sym2real.adaptation import learn_base as learn_base
from sym2real.adaptation.loop import Adapting as Adapting
from sym2real.adaptation.loop import adapt as adapt
from sym2real.control import MPPI as MPPI
from sym2real.data import example_flight as example_flight
from sym2real.dataset import Dataset as Dataset
from sym2real.diagnosis import add as add
from sym2real.diagnosis import compare as compare
from sym2real.diagnosis import diagnose as diagnose
from sym2real.diagnosis import plan as plan
from sym2real.diagnosis import try_effect as try_effect
from sym2real.effects import EFFECTS as EFFECTS
from sym2real.effects.catalogue import effect as effect
from sym2real.experiments.standard_conditions import sensors as sensors
from sym2real.layout import Layout as Layout
from sym2real.layout import Layouts as Layouts
from sym2real.logs import LogSpec as LogSpec
from sym2real.logs import inspect_logs as inspect_logs
from sym2real.logs import read_log as read_log
from sym2real.logs import read_logs as read_logs
from sym2real.logs import write_log as write_log
from sym2real.neural import ResidualTraining as ResidualTraining
from sym2real.plants import EquationsPlant as EquationsPlant
from sym2real.plants import ModelPlant as ModelPlant
from sym2real.plants import MujocoPlant as MujocoPlant
from sym2real.plants import run_episode as run_episode
from sym2real.regression import ENGINES as ENGINES
from sym2real.regression import BeamSearch as BeamSearch
from sym2real.regression import Operon as Operon
from sym2real.regression import PySR as PySR
from sym2real.robots import ROBOTS as ROBOTS
from sym2real.robots import Robot as Robot
from sym2real.robots import car as car
from sym2real.robots import quadrotor as quadrotor
from sym2real.symbolic import Equations as Equations
from sym2real.symbolic import compile_model as compile_model
from sym2real.symbolic import load_model as load_model
from sym2real.symbolic import rollout as rollout
from sym2real.symbolic import save_model as save_model
from sym2real.tasks import TASKS as TASKS
from sym2real.tasks import Task as Task
from sym2real.tasks import make_task as make_task
from sym2real.trajectory import Trajectory as Trajectory

__version__: str
