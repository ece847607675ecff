"""What a diagnosis is worth in closed loop: MPPI with the base, with what was found, and with the truth.

Three effects a robot, one of them of the sensors, in the simulator without noise. The truth is the base's equations
with the effect at its true value: what a perfect diagnosis would have added.
"""

from collections.abc import Sequence

import numpy as np
from answers import Record, with_findings
from figures import Figure
from hidden_scores import of_kind

from sym2real.control import mppi_controller
from sym2real.diagnosis import add
from sym2real.effects import effect
from sym2real.experiments.flying import fly
from sym2real.plants import MujocoPlant
from sym2real.robots import ROBOTS
from sym2real.symbolic import Equations
from sym2real.tasks import make_task

FLOWN = {
    "crazyflie": ("added_mass", "wind", "mounting_tilt"),
    "mushr": ("offset:steer", "delay", "yaw_bias"),
}
SECONDS = 6.0


def control_figures(records: Sequence[Record], robot: str, base: Equations, flights: int) -> list[Figure]:
    """Tracking errors of a robot's three effects, as multiples of what knowing the truth gives.

    Args:
        records: answers to the standard set; the first single case of each effect is flown.
        robot: name.
        base: the learned base.
        flights: number of flights of each, from starts of their own.
    """
    rows, ratios = list[Figure](), []
    for key in FLOWN[robot]:
        record = next((one for one in of_kind(records, robot, "single") if key in one["truth"]), None)
        if record is None:
            continue
        before, after, truth = tracking(record, base, flights)
        ratios.append(after / truth)
        name = f"{robot}, {key}, tracking error with MPPI"
        errors = {"base": before, "after adding": after, "with the truth": truth}
        rows += [Figure(f"{name}: {model}", error, "m") for model, error in errors.items()]
    if ratios:
        name = f"{robot}, tracking error after adding, of that with the truth: worst of {len(ratios)}"
        rows.append(Figure(name, max(ratios), "", "<= 1.1"))
    return rows


def tracking(record: Record, base: Equations, flights: int) -> tuple[float, float, float]:
    """Mean distance from a circle in m, flown with the base, with what was found, and with the truth."""
    robot = ROBOTS[record["robot"]]
    changes = [effect(key, robot).inject(**values) for key, values in record["truth"].items()]
    models = (base, with_findings(base, record), add(base, record["truth"].items()))
    task = make_task("circle", robot)

    def flown(model: Equations, seed: int) -> float:
        controller = mppi_controller(model, robot, task, seed=seed)
        return fly(MujocoPlant(robot, changes), controller, task, seconds=SECONDS, seed=seed).tracking

    before, after, truth = (float(np.mean([flown(model, seed) for seed in range(flights)])) for model in models)
    return before, after, truth
