"""What a learned base is worth in flight: against MPPI that plans with MuJoCo itself, and on goals it never saw."""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial

import numpy as np
import torch
from figures import Figure, say

from sym2real.adaptation import StageOne, stage_one
from sym2real.control import MPPI, mppi_controller
from sym2real.experiments.flights import quadrotor_flights
from sym2real.experiments.flying import fly
from sym2real.experiments.learning import training_tasks
from sym2real.experiments.study.judged import MujocoModel
from sym2real.plants import MujocoPlant
from sym2real.regression import BeamSearch
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS, Robot
from sym2real.symbolic import Equations
from sym2real.tasks import Task, make_task, unseen_goal
from sym2real.tasks.task import flies

CM = 100.0
TRAIN_SEED, TEST_SEED, STAGE_SEED = 7001, 9001, 5001
CLOSED_LOOP_SEEDS = range(3001, 3006)
CLOSED_LOOP_SECONDS = 5.0
ZERO_SHOT = 20


def closed_loop_ratio(robot: Robot, equations: Equations, task_name: str) -> Figure:
    """Mean position error of MPPI with the equations over that of MPPI whose model is MuJoCo itself."""
    say(f"closed loop: {robot.name} {task_name}")
    with ProcessPoolExecutor(2) as pool:
        pairs = list(pool.map(partial(closed_loop_pair, robot.name, equations.to_json(), task_name), CLOSED_LOOP_SEEDS))
    ours, truth = np.mean(pairs, axis=0)
    say(f"  mean position error {CM * ours:.2f} cm with the equations, {CM * truth:.2f} cm with MuJoCo")
    return Figure(
        f"{robot.name} {task_name}: MPPI with equations over MPPI with MuJoCo", ours / truth, "ratio", "<= 1.10"
    )


def closed_loop_pair(robot_name: str, equations: str, task_name: str, seed: int) -> tuple[float, float]:
    """Tracking errors in m with the equations and with MuJoCo as the model, 256 samples each."""
    torch.set_num_threads(1)
    robot = ROBOTS[robot_name]
    task = make_task(task_name, robot)
    ours = mppi_controller(Equations.from_json(equations), robot, task, samples=256, seed=seed)
    plant = MujocoPlant(robot)
    settings = replace(robot.mppi, samples=256)
    truth = MPPI(MujocoModel(plant), robot, task, settings=settings, seed=seed)
    return (
        fly(MujocoPlant(robot), ours, task, seconds=CLOSED_LOOP_SECONDS, seed=seed).tracking,
        fly(plant, truth, task, seconds=CLOSED_LOOP_SECONDS, seed=seed).tracking,
    )


def zero_shot_figure(robot: Robot, training: Task, *, episodes: int, limit: float, seconds: float, bar: str) -> Figure:
    """Unseen goals or starts, flown with a base that saw only one goal or a narrow range of starts."""
    say(f"zero-shot: {robot.name}, {episodes} episodes")
    settings = StageOne(episodes, pushed=False, until_settled=False, seed=STAGE_SEED)
    base = stage_one(MujocoPlant(robot), [training], BeamSearch(angles=robot.recipe.angles), settings)
    with ProcessPoolExecutor(2) as pool:
        finals = list(
            pool.map(partial(zero_shot_error, robot.name, base.equations.to_json(), seconds), range(ZERO_SHOT))
        )
    successes = sum(final < limit for final in finals)
    return Figure(f"{robot.name} zero-shot successes of {ZERO_SHOT}", successes, "runs", bar)


def zero_shot_error(robot_name: str, equations: str, seconds: float, run: int) -> float:
    """Mean position error in m over the last second of one run."""
    torch.set_num_threads(1)
    robot = ROBOTS[robot_name]
    goal = tuple(unseen_goal(np.random.default_rng([TEST_SEED, run])))
    task = make_task("hover", robot, goal=goal) if flies(robot) else make_task("park", robot, start_region="unseen")
    controller = mppi_controller(Equations.from_json(equations), robot, task, seed=run)
    flight = fly(MujocoPlant(robot), controller, task, seconds=seconds, seed=TEST_SEED + run)
    return float("inf") if flight.crashed else flight.final


def closed_loop() -> list[Figure]:
    """MPPI with the equations against MPPI with MuJoCo, on every task."""
    quadrotor = BeamSearch().fit(quadrotor_flights(3, TRAIN_SEED).transitions())
    settings = StageOne(5, pushed=False, until_settled=False, seed=STAGE_SEED)
    car = stage_one(
        MujocoPlant(MUSHR), training_tasks(MUSHR), BeamSearch(angles=MUSHR.recipe.angles), settings
    ).equations
    return [
        *(closed_loop_ratio(MUSHR, car, task) for task in ("circle", "park")),
        *(closed_loop_ratio(CRAZYFLIE, quadrotor, task) for task in ("hover", "circle", "lemniscate")),
    ]


def zero_shot() -> list[Figure]:
    """Bases that saw one goal, or a narrow range of starts, on others."""
    return [
        zero_shot_figure(CRAZYFLIE, make_task("hover", CRAZYFLIE), episodes=10, limit=0.1, seconds=8.0, bar=">= 20"),
        zero_shot_figure(MUSHR, make_task("park", MUSHR), episodes=20, limit=0.15, seconds=15.0, bar=">= 19"),
    ]
