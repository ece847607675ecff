"""A policy learned by PPO in the plain simulator, in targets that it has never seen, beside model-based control.

The policy sees the measured state alone, so it hovers at one point. Reward: 1 - running cost, so that staying in the
air is worth something. The paper: a policy from the plain simulation did not transfer, MPC let the drone hover safely.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from sym2real.errors import needing
from sym2real.experiments.models import cached_base
from sym2real.experiments.study.case import Case, load_suite
from sym2real.experiments.study.effort import Effort, OfStudy
from sym2real.experiments.study.judged import judge, planning_with
from sym2real.experiments.study.outcome import Outcome
from sym2real.experiments.study.sweep import Job, Record, Tell
from sym2real.plants import MujocoPlant
from sym2real.protocols import Memoryless
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic import Equations
from sym2real.tasks import Task
from sym2real.trajectory import Array

PLAIN = "plain"
TARGETS = ("mass-26", "com-3", "wind-strong")
PAPER = "paper: a policy from the plain simulation did not transfer, MPC let the drone hover safely"
REPORT_EVERY = 2048


@dataclass(frozen=True)
class Policy(Memoryless):
    """A controller that asks a trained policy; it has nothing to remember."""

    predict: Callable[..., tuple[Array, Any]]

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """The policy's mean action ``# (action,)``."""
        action, _ = self.predict(np.asarray(state), deterministic=True)
        return np.asarray(action, dtype=np.float64)


@dataclass(frozen=True)
class PolicyJob(OfStudy):
    """Training and test of a policy, as a job of the sweep.

    Args:
        seed: of the training.
        effort: of the study.
        base: equations that MPPI flies beside it, as JSON.
    """

    NAME = "policy_ppo_{seed}"

    seed: int
    effort: Effort
    base: str

    def run(self, tell: Tell) -> Record:
        """Errors and crashes by target, of the policy and of MPPI with the base."""
        policy = trained(targets()[0].of_task(), self.effort.policy_steps, self.seed, tell)
        planner = planning_with(Equations.from_json(self.base), self.effort)
        answer = {}
        for case in targets():
            tell(f"flying {case.title}")
            ours, theirs = judge(case, planner, self.effort), judge(case, lambda *_: policy, self.effort)
            answer[case.name] = {"mppi": ours._asdict(), "policy": theirs._asdict()}
        return {"targets": answer}


def targets() -> list[Case]:
    """Hover in the plain simulator, then in shifted ones."""
    cases = [case for case in load_suite("sim2sim").cases if case.name in TARGETS]
    hovers = [replace(case, task="hover", options={}, paper="") for case in cases]
    return [Case(PLAIN, "the plain simulator", CRAZYFLIE.name, "hover"), *hovers]


def trained(task: Task, steps: int, seed: int, tell: Tell) -> Policy:
    """A policy after so many control steps in the plain simulator.

    Raises:
        MissingDependencyError: without stable-baselines3.
    """
    with needing("PPO needs stable-baselines3", "rl"):
        from stable_baselines3 import PPO  # noqa: PLC0415 — an extra

    from sym2real.plants.gymnasium_view import TaskEnvironment, TransformReward  # noqa: PLC0415 — loads Gymnasium

    def report(scope: Mapping[str, Any], _: Mapping[str, Any]) -> bool:
        """After every step; to go on."""
        if scope["self"].num_timesteps % REPORT_EVERY == 0:
            tell(f"PPO: step {scope['self'].num_timesteps} of {steps}")
        return True

    environment = TransformReward(TaskEnvironment(MujocoPlant(CRAZYFLIE), task), lambda reward: 1.0 + float(reward))
    agent = PPO("MlpPolicy", environment, seed=seed, device="cpu")
    agent.learn(steps, callback=report)
    return Policy(agent.predict)


def policy_jobs(effort: Effort) -> list[Job]:
    """One training a seed, where the effort allows it."""
    base = cached_base(CRAZYFLIE).to_json() if effort.policy_steps else ""
    return [PolicyJob(seed, effort, base) for seed in effort.seeds if effort.policy_steps]


def policy_outcome(effort: Effort, records: Mapping[str, Record]) -> Outcome:
    """Errors and crashes by target."""
    runs = [records[name] for name in (f"policy_ppo_{seed}" for seed in effort.seeds) if name in records]
    rows = []
    for case in targets() if runs else ():
        cells = []
        for who in ("policy", "mppi"):
            outcomes = [run["targets"][case.name][who] for run in runs]
            crashes = sum(outcome["crashes"] for outcome in outcomes)
            cells += [f"{np.mean([outcome['errors'] for outcome in outcomes]):.4f}", str(crashes)]
        rows.append((case.title, *cells))
    columns = ("target", "PPO, m", "PPO crashes", "MPPI, m", "MPPI crashes")
    notes = (PAPER,) if effort.policy_steps else (PAPER, "training a policy takes --full")
    return Outcome("A learned policy and model-based control", columns, tuple(rows), notes)
