"""The diagnosis on simulators that are not ours: RotorPy's, drone-models' and Bullet's rotorcraft, three sliding cars.

Physics, rotors, drag and tyres are their authors'; the runs are those of the standard set, with its sensor noise. The
quadrotors' base is learned in MuJoCo and calibrated there. RotorPy's rotors need 4 ms where MuJoCo's are immediate,
which every case but two has beside its own effect; drone-models' are Crazyflies as they were identified in flight, 5 to
16 g heavier than the base's, with slow rotors and drag. Bullet's is a hexarotor that is commanded motor by motor, held
against its first principles. The cars are CommonRoad's, highway-env's and SlipX's, held against a
bicycle without slip and without a simulator, so that every case also lacks the lags of servo and motor, the slip of its
tyres, and the arm from the rear axle to its centre.

    pip install ".[bench]"
    python tools/bench/other_simulators.py
    python tools/bench/other_simulators.py --cases "stock Crazyflie" --json build/other_simulators.json
"""

import os
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import tyro
from answers import HORIZON, Record, answer_of, in_form_of_the_answer, named, names, stands_for
from bullet_plant import Hexarotor, flights_in_bullet
from figures import Figure, report
from hidden_scores import covered
from highway_plant import WHEELBASE as ROAD_WHEELBASE, Tyres, drives
from lsy_plant import IdentifiedQuadrotor, LsyPlant
from repeated import Asked, answers_of, print_table, share
from rotorpy_plant import QUICK, Quadrotor, RotorpyPlant
from single_track_plant import WHEELBASE, Car, SingleTrackPlant
from slipx_plant import WHEELBASE as RACE_WHEELBASE, RaceCar, races
from standard_set import standard_run

from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.errors import UnknownNameError
from sym2real.experiments.models import cached_base
from sym2real.experiments.study.sweep import Tell
from sym2real.plants import MujocoPlant
from sym2real.protocols import Plant
from sym2real.robots import ROBOTS, Robot, car
from sym2real.robots.robot import GRAVITY
from sym2real.symbolic import Equations

RUNS, SEED = 8, 7
Truth = Mapping[str, Mapping[str, float]]


def rotor_drag(per_speed: float, thrust_coefficient: float, mass: float) -> float:
    """RotorPy's drag in N s/m of four rotors that hover: its coefficient times the sum of their speeds."""
    return per_speed * 4.0 * float(np.sqrt(mass * GRAVITY / 4.0 / thrust_coefficient))


def turning(drag: float) -> Truth:
    """What drag in N s/m at the rotors' hubs does to turning: c r² resists the yaw loop, as a gain below one."""
    from rotorpy.vehicles.crazyflie_params import d as arm

    constants = ROBOTS["crazyflie"].numbers
    damping = drag * arm**2 / constants["jz"]
    return {"gain:wz_cmd": {"value": constants["kz"] / (constants["kz"] + damping)}}


def flights() -> dict[str, tuple[Quadrotor, Truth]]:
    """RotorPy's cases: what its quadrotor is told, and what that is in the catalogue's terms."""
    from rotorpy.vehicles.crazyflie_params import quad_params as stock

    mass, quick = ROBOTS["crazyflie"].mass, {"motor_lag": {"value": QUICK}}
    level = rotor_drag(stock["k_d"], stock["k_eta"], stock["mass"])
    upright = rotor_drag(stock["k_z"], stock["k_eta"], stock["mass"])
    doubled = {"k_d": 2 * stock["k_d"], "k_z": 2 * stock["k_z"]}
    across, along = (rotor_drag(doubled[name], stock["k_eta"], mass) for name in ("k_d", "k_z"))
    frame = dict.fromkeys(("c_Dx", "c_Dy", "c_Dz"), 0.016)
    return {
        "plain": (Quadrotor(), quick),
        "4 g more": (Quadrotor({"mass": mass + 0.004}), {"added_mass": {"value": 0.004}, **quick}),
        "slow rotors": (Quadrotor({"tau_m": 0.05}), {"motor_lag": {"value": 0.05}}),
        "rotor drag": (
            Quadrotor(doubled),
            {"linear_drag": {"cx": across, "cy": across, "cz": along}, **turning(across), **quick},
        ),
        "frame drag": (Quadrotor(frame), {"quadratic_drag": {"value": 0.016}, **quick}),
        "centre of mass": (Quadrotor(centre=(0.002, 0.0, 0.0)), {"com_offset": {"rx": 0.002, "ry": 0.0}, **quick}),
        "late commands": (Quadrotor(late=2), {"delay": {"value": 0.04}, **quick}),
        "stock Crazyflie": (
            Quadrotor(stock=True),
            {
                "added_mass": {"value": stock["mass"] - mass},
                "motor_lag": {"value": stock["tau_m"]},
                "linear_drag": {"cx": level, "cy": level, "cz": upright},
                **turning(level),
            },
        ),
    }


IDENTIFIED = {
    "identified Crazyflie": IdentifiedQuadrotor("cf2x_L250"),
    "identified Crazyflie, immediate rotors": IdentifiedQuadrotor("cf2x_L250", immediate=True),
    "identified Crazyflie, late commands": IdentifiedQuadrotor("cf2x_L250", immediate=True, late=2),
    "identified Crazyflie, other propellers": IdentifiedQuadrotor("cf2x_P250"),
    "identified Crazyflie, other motors": IdentifiedQuadrotor("cf2x_T350"),
    "identified brushless Crazyflie": IdentifiedQuadrotor("cf21B_500"),
}
ALWAYS: Truth = {"lever_arm": {"rx": WHEELBASE / 2}, "lag:steer": {"value": 0.02}}
DRIVES: dict[str, tuple[Car, Truth]] = {
    "single track": (Car(), {}),
    "servo out of centre": (Car(offset=0.06), {"offset:steer": {"value": 0.06}}),
    "servo's travel": (Car(steering=0.8), {"gain:steer": {"value": 0.8}}),
    "speed's map": (Car(speed=0.9), {"gain:speed": {"value": 0.9}}),
    "slow motor": (Car(motor=0.3), {}),
    "late car": (Car(late=3), {"delay": {"value": 0.15}}),
    "soft tyres": (Car(tyres=0.5), {}),
    "drift model": (Car(drift=True), {}),
    "drift model, soft tyres": (Car(drift=True, tyres=0.5), {}),
}
ROADS = {
    "road car": Tyres(),
    "road car, stiff tyres": Tyres(front=4.0, rear=4.0),
    "road car, soft tyres": Tyres(front=0.5, rear=0.5),
    "road car, soft front": Tyres(front=0.6),
}
RACES = {
    "race car": RaceCar(),
    "race car, soft front": RaceCar(front=0.5),
    "race car, ballast ahead": RaceCar(ballast=1.5, ahead=0.2),
    "race car, late commands": RaceCar(late=3),
}


BULLET: dict[str, tuple[Hexarotor, Truth]] = {
    "hexarotor": (Hexarotor(), {}),
    "hexarotor, 150 g more": (Hexarotor(load=0.15), {"added_mass": {"value": 0.15}}),
    "hexarotor, weak rotors": (Hexarotor(strength=0.9), {"gain:thrust": {"value": 0.9}}),
    "hexarotor, slow rotors": (Hexarotor(motor=0.05), {"lag": {"value": 0.05}}),
    "hexarotor, drag": (Hexarotor(drag=0.3), {"linear_drag": dict.fromkeys(("cx", "cy", "cz"), 0.3)}),
    "hexarotor, wind": (Hexarotor(wind=(0.4, -0.3, 0.0)), {"wind": {"fx": 0.4, "fy": -0.3}}),
    "hexarotor, centre of mass": (Hexarotor(centre=(0.008, -0.004)), {"com_offset": {"rx": 0.008, "ry": -0.004}}),
    "hexarotor, late commands": (Hexarotor(late=2), {"delay": {"value": 0.04}}),
    "hexarotor, all of it": (
        Hexarotor(load=0.15, drag=0.3, late=2, centre=(0.004, 0.0)),
        {
            "added_mass": {"value": 0.15},
            "linear_drag": dict.fromkeys(("cx", "cy", "cz"), 0.3),
            "delay": {"value": 0.04},
            "com_offset": {"rx": 0.004, "ry": 0.0},
        },
    ),
}


@dataclass(frozen=True)
class Question:
    """A case to simulate, and what to hold it against.

    Args:
        case: its title.
        truth: hidden effects with their values.
        runs: simulates by a seed.
        base: equations to diagnose.
        simulator: robot whose plain simulator calibrates them, if there is one.
    """

    case: str
    truth: Truth
    runs: Callable[[int], Dataset]
    base: Equations
    simulator: Robot | None = None

    def answer(self, seed: int, tell: Tell) -> Record:
        """What is true, and what is said of it."""
        tell("simulating")
        data, plant = self.runs(seed), None if self.simulator is None else MujocoPlant(self.simulator)
        truth = {key: dict(values) for key, values in self.truth.items()}
        return {"truth": truth, **answer_of(diagnose(self.base, data, plant, on_progress=tell))}


def standard_runs(robot: Robot, plant: Callable[[np.random.Generator], Plant], seed: int) -> Dataset:
    """Those of the standard set, on a foreign simulator with the robot's nominal numbers known to the controller."""
    # Turning tells a wind from a tilted board; even runs keep their heading.
    return Dataset([standard_run(robot, plant, seed, index, yaw=index % 2 > 0) for index in range(RUNS)])


def questions() -> Iterator[Question]:
    """All cases, without simulating any."""
    flyer, driver = ROBOTS["crazyflie"], ROBOTS["mushr"]
    for case, (quadrotor, truth) in flights().items():
        runs = partial(standard_runs, flyer, partial(RotorpyPlant, quadrotor))
        yield Question(case, truth, runs, cached_base(flyer), flyer)
    for case, identified in IDENTIFIED.items():
        runs = partial(standard_runs, flyer, partial(LsyPlant, identified))
        yield Question(case, identified.truth, runs, cached_base(flyer), flyer)
    for case, (hexarotor, truth) in BULLET.items():
        yield Question(case, truth, partial(flights_in_bullet, hexarotor), ROBOTS["hexarotor"].nominal())
    for case, (told, truth) in DRIVES.items():
        own = {"lag:speed": {"value": told.speed_lag}, "tyre_slip": {"value": told.compliance}, **told.curve}
        runs = partial(standard_runs, driver, partial(SingleTrackPlant, told))
        yield Question(case, {**ALWAYS, **own, **truth}, runs, car(WHEELBASE))
    for case, tyres in ROADS.items():
        yield Question(case, tyres.truth, partial(drives, tyres), car(ROAD_WHEELBASE))
    for case, race_car in RACES.items():
        yield Question(case, race_car.truth, partial(races, race_car), car(RACE_WHEELBASE))


def figures(case: str, record: Record) -> list[Figure]:
    """How many of the true effects were named, what else was, and each value beside its truth."""
    truth, errors = record["truth"], record["position_error"]
    extra = [one["effect"] for one in record["findings"] if not any(stands_for(one, key) for key in truth)]
    missing = [key for key in truth if not named(record, key)]
    rows = [
        Figure(f"{case}: true effects not named{_list(missing)}", len(missing), ""),
        Figure(f"{case}: others named{_list(extra)}", len(extra), "", "<= 0"),
    ]
    for one in record["findings"]:
        for name, value in truth.get(one["effect"], {}).items():
            found = one["parameters"][name]
            rows.append(Figure(f"{case}: {one['effect']} {name} (true {value:.4g})", found["value"], found["unit"]))
    if record["findings"]:
        rows.append(Figure(f"{case}: position error {HORIZON} s ahead, base", errors[0], "m"))
        rows.append(Figure(f"{case}: position error {HORIZON} s ahead, with the findings", errors[-1], "m"))
    return rows


def _list(names: list[str]) -> str:
    return f" ({', '.join(names)})" if names else ""


def main(
    cases: tuple[str, ...] = (),
    seeds: tuple[int, ...] = (SEED,),
    jobs: int = 1,
    folder: Path = Path("build/bench/other_simulators"),
    json: Path | None = None,
) -> None:
    """Diagnose runs of other people's simulators.

    Args:
        cases: cases to run; all by default.
        seeds: of noise, dither and phases; every case once with each.
        jobs: cases that run at the same time, each on one thread.
        folder: every answer is kept here. Another version needs another folder.
        json: write the figures to this file (- is standard output).

    Raises:
        UnknownNameError: for a case that does not exist.
    """
    known = {question.case: question for question in questions()}
    for case in cases:
        if case not in known:
            raise UnknownNameError("case", case, known)
    asked = [
        Asked(case if seed == SEED else f"{case}, seed {seed}", {"seed": seed}, partial(known[case].answer, seed))
        for seed in seeds
        for case in cases or known
    ]
    answers = map(in_form_of_the_answer, answers_of(asked, folder, jobs))
    records = dict(zip((job.title for job in asked), answers, strict=True))
    said = ((case, ", ".join(one["truth"]), one["verdict"], ", ".join(names(one))) for case, one in records.items())
    print_table("what was found", ("case", "truth", "verdict", "found"), said)
    rows = [row for case, one in records.items() for row in figures(case, one)]
    rows += share(
        "95 % interval holds the truth", (held for one in records.values() for held in covered(one)), ">= 0.9"
    )
    report("Simulators that are not ours", rows, seeds, json)


if __name__ == "__main__":
    if not os.environ.get("SCIPY_ARRAY_API"):  # drone-models asks for it, before SciPy is imported
        os.execve(sys.executable, [sys.executable, *sys.argv], {**os.environ, "SCIPY_ARRAY_API": "1"})
    tyro.cli(main, description=__doc__)
