"""What a robot of joints may meet and its first-principles equations do not have: contacts, and the ends of joints."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from sym2real.dataset import Dataset
from sym2real.robots import mjcf_columns as columns
from sym2real.robots.own import robot_of
from sym2real.symbolic import Equations
from sym2real.trajectory import Trajectory
from sym2real.vocabulary import AT_A_STOP

CONTACTS, STOPS = "contacts are not in the equations", "end stops of joints are not in the equations"
REACHED = "the logs reach what is not in the equations: end stops of"
MOST = 3  # that are named
NEAR = 0.01  # part of a joint's range within which it is at its end


def left_out_of(model: mujoco.MjModel) -> tuple[str, ...]:
    """Notes on a compiled file of hinges and slides: which bodies touch within the ranges, where joints end."""
    touching: Counter[str] = Counter()
    for data in columns.over_range(model, slide=float(model.stat.extent)):
        pairs = model.geom_bodyid[data.contact.geom[: data.ncon]].tolist()
        touching.update({" with ".join(_body(model, body) for body in sorted(pair)[::-1]) for pair in pairs})
    units = {columns.HINGE: "rad", columns.SLIDE: "m"}
    stops = [
        f"{name} at {low:.3g} and {high:.3g} {units[int(model.joint(name).type[0])]}"
        for name, (low, high) in columns.stops_of(model).items()
    ]
    pairs = [pair for pair, _ in touching.most_common()]
    touch = [f"{CONTACTS}: where its joints can be, {_some(pairs)} can touch"] if pairs else []
    return (*touch, *([f"{STOPS}: {_some(stops)}"] if stops else []))


def left_out_notes(model: Equations | None, data: Dataset) -> list[str]:
    """The note on contacts, and one on ends that the logs reach; none where nobody has equations."""
    if model is None:
        return []
    notes = [note for note in model.notes if note.startswith(CONTACTS)]
    met = dict.fromkeys(column for log in data for column, rows in _at_stops(model, log).items() if rows.any())
    left_out = "; pieces with them are left out" if any(AT_A_STOP in log.extra for log in data) else ""
    return [*notes, *([f"{REACHED} {', '.join(met)}{left_out}"] if met else [])]


def with_stops_marked(model: Equations, data: Dataset) -> Dataset:
    """The logs with the column :data:`AT_A_STOP` where joints reach ends that the equations do not have."""
    met = [(log, np.any([*_at_stops(model, log).values()], axis=0)) for log in data]
    return Dataset(
        replace(log, extra={**log.extra, AT_A_STOP: rows.astype(float)}) if rows.any() else log for log, rows in met
    )


def _at_stops(model: Equations, log: Trajectory) -> dict[str, NDArray[np.bool_]]:
    """Rows at which each joint is at an end that the equations do not have ``# (rows,)``."""
    robot = robot_of(model) if any(note.startswith(STOPS) for note in model.notes) else None
    met = {}
    for column, (low, high) in (robot.ranges if robot is not None else {}).items():
        if column in log.layouts.state:
            places, near = log.column(column), NEAR * (high - low)
            met[column] = (places < low + near) | (places > high - near)
    return met


def _body(model: mujoco.MjModel, body: int) -> str:
    return model.body(body).name or f"body {body}"


def _some(names: Sequence[str]) -> str:
    return ", ".join([*names[:MOST], *([f"and {len(names) - MOST} more"] if len(names) > MOST else [])])
