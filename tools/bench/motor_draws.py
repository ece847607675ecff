"""A quadrotor flown by its motors at 100 Hz, held against a model whose inertia and drag constant are far off.

Rotors are bodies that spin (motor_quadrotor.py); it has drag, flapping, damping and the rotors' reaction at once. The
analyst's inertia and torque per thrust are each wrong by up to 50 times. Three kinds of flight are diagnosed; position
half a second ahead on a fourth kind, with what was found, is held against MuJoCo with the true effects.

    python tools/bench/motor_draws.py --cases 1 --flights 1
    python tools/bench/motor_draws.py --cases 20 --sealed --json build/motor_draws.json
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
import standard_trim
import tyro
from answers import Record, all_named, answer_of, error_ahead, named, names, refusal
from figures import Figure, report
from motor_quadrotor import ARM, DT, INERTIA, MASS, ROTOR_THRUST, TORQUE_PER_THRUST, OnMotors, Rotors, estimated, robot
from repeated import Asked, Run, Settings, print_table, share

from sym2real.control import GeometricQuadrotor
from sym2real.control.geometric_quadrotor import Gains
from sym2real.dataset import Dataset
from sym2real.diagnosis import ROWS, diagnose
from sym2real.effects import effect
from sym2real.errors import Sym2RealError
from sym2real.experiments.excitation import ColouredNoise, RandomRates
from sym2real.experiments.study.sweep import Tell
from sym2real.plants import MujocoPlant, run_episode
from sym2real.protocols import Change, Controller
from sym2real.robots import CRAZYFLIE, Motors, quadrotor
from sym2real.symbolic import Equations
from sym2real.tasks import make_task
from sym2real.trajectory import Array, Trajectory

BENCH, AHEAD, SECONDS, WRONG = "motor draws", 0.5, 8.0, 50.0
KINDS, FOURTH = ("hover", "circle", "lemniscate"), "random rates"
DITHER, DITHER_TIME = 20.0, 0.03  # rad/s, s
SCALES = "torque_scale"
# Least and largest of what is drawn: N s/m, N s, N m s, kg m².
SIZES = {
    "linear_drag": (("cx", "cy", "cz"), (0.006, 0.016)),
    "flapping_moment": (("a", "b"), (3e-5, 8e-5)),
    "rate_damping": (("dx", "dy", "dz"), (2e-5, 6e-5)),
}
REACTION, ROTOR_INERTIA = "rotor_reaction", (2e-9, 6e-9)


@dataclass(frozen=True)
class Options:
    """Fly by motors, with a model that is wrong by up to 50 times.

    Args:
        flights: flights of each of the three kinds.
    """

    run: Run = field(default_factory=Settings)
    flights: int = 4


@dataclass(frozen=True)
class Draw:
    """What a seed makes of the robot and of its analyst.

    Args:
        effects: drag, flapping and damping with their values.
        rotor_inertia: in kg m².
        inertia, drag: the analyst's inertia and torque per thrust over the true ones.
        seed: of everything.
    """

    effects: dict[str, dict[str, float]]
    rotor_inertia: float
    inertia: float
    drag: float
    seed: int

    @classmethod
    def of(cls, seed: int) -> Draw:
        """Sizes uniform, wrong factors uniform in their logarithm."""
        rng = np.random.default_rng([seed, 0])
        effects = {key: {name: float(rng.uniform(*size)) for name in rows} for key, (rows, size) in SIZES.items()}
        wrong = np.exp(rng.uniform(-1.0, 1.0, 2) * np.log(WRONG))
        return cls(effects, float(rng.uniform(*ROTOR_INERTIA)), float(wrong[0]), float(wrong[1]), seed)

    @property
    def keys(self) -> tuple[str, ...]:
        """All that is to be named."""
        return (*self.effects, REACTION, SCALES)

    @property
    def analysts(self) -> Equations:
        """What the analyst knows."""
        motors = Motors(ROTOR_THRUST, "rad/s", torque_per_thrust=self.drag * TORQUE_PER_THRUST, arm=ARM)
        moments = tuple(self.inertia * moment for moment in INERTIA)
        return quadrotor(MASS, moments, interface="motors", motors=motors, dt=DT)

    def changes(self) -> tuple[Change, ...]:
        """Drag, flapping and damping in MuJoCo."""
        return tuple(effect(key, CRAZYFLIE).inject(**values) for key, values in self.effects.items())

    def flown(self, kind: str, number: int) -> Trajectory:
        """One flight as its log has it: estimated states, measured rotor speeds."""
        rng, rotors = np.random.default_rng([self.seed, 1 + number]), Rotors(self.rotor_inertia)
        flyer = robot(self.rotor_inertia)
        disturbed = standard_trim.disturbance(flyer, rng)
        plant = MujocoPlant(flyer, (rotors.change, *self.changes(), disturbed, estimated(rng)))
        controller = OnMotors(_controller(kind, rng), ColouredNoise(np.full(4, DITHER), DITHER_TIME, DT, rng))
        start = CRAZYFLIE.start if kind == FOURTH else make_task(kind, CRAZYFLIE).start(rng)
        log = run_episode(plant, controller, start=start, steps=round(SECONDS / DT), name=f"{kind} {number}")
        return replace(log, action=rotors.measured(len(log)), inputs=np.zeros_like(log.inputs))

    def error_of_mujoco(self, log: Trajectory) -> float:
        """Root mean square position error in m after :data:`AHEAD` s of the simulator with the effects."""
        rotors, steps = Rotors(self.rotor_inertia, servo=0.001), round(AHEAD / DT)
        plant = MujocoPlant(robot(self.rotor_inertia, servo=0.001), (rotors.change, *self.changes()))
        errors = [_missed(plant, log, row, steps) for row in range(ROWS, len(log) - steps, 10)]
        return float(np.sqrt(np.mean(np.sum(np.square(errors), axis=1))))


def _missed(plant: MujocoPlant, log: Trajectory, row: int, steps: int) -> Array:
    state = plant.reset(log.state[row])
    for action in log.action[row : row + steps]:
        state = plant.step(action)
    return state[:3] - log.state[row + steps, :3]


def _controller(kind: str, rng: np.random.Generator) -> Controller:
    if kind == FOURTH:
        return RandomRates(replace(CRAZYFLIE, dt=DT), rng, levelling=8.0, climbing=0.7)
    path, turning = make_task(kind, CRAZYFLIE).reference, float(rng.uniform(-0.8, 0.8))
    gains = Gains(position=4.0, velocity=3.5, attitude=7.0)
    return GeometricQuadrotor(MASS, CRAZYFLIE.low, CRAZYFLIE.high, DT, path, turning, gains)


def flown(seed: int, flights: int) -> Asked:
    """One draw."""
    asked = {"seed": seed, "flights": flights, "keys": list(Draw.of(seed).keys)}
    return Asked(f"{seed} {flights}", asked, partial(answer, seed, flights))


def answer(seed: int, flights: int, tell: Tell) -> Record:
    """The answer, and what it predicts of the fourth kind."""
    draw = Draw.of(seed)
    tell("flying")
    data = Dataset(draw.flown(kind, number) for number, kind in enumerate(KINDS * flights))
    fourth = draw.flown(FOURTH, len(KINDS) * flights)
    truth = {**draw.effects, REACTION: {"value": draw.rotor_inertia}, "inertia": draw.inertia, "drag": draw.drag}
    tell("diagnosing")
    before = error_ahead(draw.analysts, fourth, AHEAD)
    known = {"truth": truth, "mujoco": draw.error_of_mujoco(fourth), "before": before}
    try:
        found = diagnose(draw.analysts, data)
        after = error_ahead(found.apply(draw.analysts, for_prediction=True), fourth, AHEAD)
    except Sym2RealError as error:
        return {**known, "answer": refusal(error), "after": before}
    return {**known, "answer": answer_of(found), "after": after}


def figures(records: Sequence[Record]) -> list[Figure]:
    """One per bar; each effect by itself; the prediction as a multiple of MuJoCo's."""
    keys = records[0]["asked"]["keys"]
    found = share("all named", (all_named(one["answer"], keys) for one in records), ">= 0.80")
    for key in keys:
        found += share(f"{key} named", (named(one["answer"], key) for one in records))
    # What predicts no number is the worst.
    errors = {step: [one[step] / one["mujoco"] for one in records] for step in ("before", "after")}
    ratios = {step: float(np.median(np.nan_to_num(values, nan=np.inf))) for step, values in errors.items()}
    found.append(Figure("position error 0.5 s ahead, fourth kind, of MuJoCo's: before, median", ratios["before"], ""))
    return [*found, Figure("with what was found, median", ratios["after"], "", "<= 1.15")]


def main(options: Options) -> None:
    """Fly, diagnose, predict, print, write."""
    seeds = options.run.seeds_of(BENCH)
    records = options.run.answers(BENCH, [flown(seed, options.flights) for seed in seeds])
    said = ((one["asked"]["seed"], one["truth"], one["answer"]["verdict"], names(one["answer"])) for one in records)
    print_table("what was found", ("draw", "truth", "verdict", "found"), (map(str, row) for row in said))
    report(BENCH, figures(records), seeds, options.run.json)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
