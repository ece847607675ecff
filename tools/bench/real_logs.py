"""Diagnoses of the measured logs: verdict, findings, ladder, and figures beside what is known (docs/real_logs.md).

The sets lie outside the project (``../shared/data`` beside the checkout, or ``SYM2REAL_DATA``). A base is learned in
the plain simulator, or made of first principles; the sets whose interface is a thrust with a measured attitude, or four
motors, have the latter alone. Every flight of those sets is diagnosed by itself, those of four motors also together; of
the other sets all logs together.

    python tools/bench/real_logs.py --json build/real_logs.json
    python tools/bench/real_logs.py --sets mushr_steering_offset
"""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from math import isnan
from pathlib import Path

import torch
import tyro
from figures import Figure, report
from real_scores import Answer, battery_figures, car_figures, penny_figures, wind_figures
from rich.console import Console

from sym2real.diagnosis import diagnose
from sym2real.experiments.models import cached_base
from sym2real.experiments.thrust_of_log import CALIBRATION_SECONDS
from sym2real.logs import read_log, read_logs
from sym2real.plants import MujocoPlant
from sym2real.report.diagnosis import diagnosis_report
from sym2real.robots import ROBOTS, Motors, car, fit_thrust_per_unit, quadrotor
from sym2real.robots.mushr import WHEELBASE
from sym2real.symbolic import Equations

DATA = Path(os.environ.get("SYM2REAL_DATA", Path(__file__).resolve().parents[3] / "shared" / "data"))
DT = 0.02  # s, of flights whose log has motor commands and no rate commands
SCORES = {
    "crazyflie_two_pennies": penny_figures,
    "mushr_steering_offset": car_figures,
    "quadrotor_wind": wind_figures,
    "crazyflie_battery_drag": battery_figures,
}


@dataclass(frozen=True)
class Options:
    """Diagnose the measured logs.

    Args:
        data: folder with the sets.
        sets: sets to diagnose.
        json: write the figures to this file (- is standard output).
    """

    data: Path = DATA
    sets: tuple[str, ...] = tuple(SCORES)
    json: Path | None = None


def motor_level_equations(path: Path, spec: str) -> Equations:
    """Equations per unit of mass, attitude measured, thrust per unit of the motors as linear in whatever they hold.

    It is fitted on the flight's first two seconds.
    """
    layouts = quadrotor(interface="motors", attitude="measured", dt=DT).layouts
    per_mass = fit_thrust_per_unit(read_log(path, spec=spec, layouts=layouts, dt=DT), CALIBRATION_SECONDS)
    return quadrotor(None, interface="motors", attitude="measured", motors=Motors(thrust=per_mass), dt=DT)


def bases(name: str, logs: list[Path]) -> Iterator[tuple[str, Equations, MujocoPlant | None]]:
    """What the logs of a set are held against: title, equations, plain simulator to calibrate them."""
    if name == "crazyflie_two_pennies":
        yield "learned", cached_base(ROBOTS["crazyflie"]), MujocoPlant(ROBOTS["crazyflie"])
        yield "first principles", quadrotor(ROBOTS["crazyflie"].mass), None
    elif name == "mushr_steering_offset":
        yield "learned", cached_base(ROBOTS["mushr"]), MujocoPlant(ROBOTS["mushr"])
        yield "first principles", car(WHEELBASE), None
    elif name == "quadrotor_wind":
        yield "first principles", quadrotor(1.0, attitude="measured"), None
    else:
        yield "first principles", motor_level_equations(logs[0], name), None


def questions(name: str, paths: list[Path]) -> list[list[Path]]:
    """The logs that are diagnosed together: of one robot under one condition all, else flight by flight."""
    singly = [[path] for path in paths]
    if name == "quadrotor_wind":
        return singly
    return [paths, *singly] if name == "crazyflie_battery_drag" else [paths]


def answers(options: Options, name: str, console: Console) -> Iterator[Answer]:
    """Diagnose and print all that belongs to a set."""
    paths = sorted((options.data / name).glob("*.csv"))
    for logs in questions(name, paths):
        for base, equations, plant in bases(name, logs):
            data = read_logs(logs, spec=name, layouts=equations.layouts, dt=equations.dt)
            title = logs[0].stem if len(logs) == 1 else name
            with console.status(f"{title}, {base}") as status:
                found = diagnose(equations, data, plant, on_progress=status.update)
            console.rule(f"{title}, {base}")
            console.print(diagnosis_report(found))
            yield Answer(title, base, found, data, equations)


def figures_of(options: Options, console: Console) -> list[Figure]:
    """One per bar of the issue, for every set that was asked for."""
    found: list[Figure] = []
    for name in options.sets:
        found += SCORES[name](list(answers(options, name, console)))
    return [one for one in found if one.bar or not isnan(one.value)]


def main(options: Options) -> None:
    """Diagnose, print, write."""
    torch.set_num_threads(1)
    console = Console(stderr=options.json == Path("-"))
    report("Measured logs", figures_of(options, console), (), options.json)


if __name__ == "__main__":
    main(tyro.cli(Options))
