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
from sym2real.vocabulary import AT_A_STOP

CONTACTS, STOPS = "contacts are not in the equations", "end stops of joints are not in the equations"
REACHED = "the logs reach what is not in the equations: end stops of"
MOST = 3  # that are named
# Parts of a joint's range within which it is at an end, and by which it goes beyond one that is not there: the ends of
# many files are rough, and MuJoCo's give.
NEAR, BEYOND = 0.01, 0.1


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
    met = [column for column, rows in _at_stops(model, data).items() if any(own.any() for own in rows)]
    left_out = "; pieces with them are left out" if any(AT_A_STOP in log.extra for log in data) else ""
    return [*notes, *([f"{REACHED} {', '.join(met)}{left_out}"] if met else [])]


def with_stops_marked(model: Equations, data: Dataset) -> Dataset:
    """The logs with the column :data:`AT_A_STOP` where joints reach ends that the equations do not have."""
    met = [np.any(rows, axis=0) for rows in zip(*_at_stops(model, data).values(), strict=True)]
    if not any(rows.any() for rows in met):
        return data
    marked = zip(data, met, strict=True)
    return Dataset(replace(log, extra={**log.extra, AT_A_STOP: rows.astype(float)}) for log, rows in marked)


def _at_stops(model: Equations, data: Dataset) -> dict[str, list[NDArray[np.bool_]]]:
    """By joint, rows of each log at an end that the equations do not have, and no log goes beyond ``# (rows,)``."""
    robot = robot_of(model) if any(note.startswith(STOPS) for note in model.notes) else None
    met = {}
    for column, (low, high) in (robot.ranges if robot is not None else {}).items():
        if column in data.layouts.state:
            inside = [(log.column(column) - low) / (high - low) for log in data]  # 0 at one end, 1 at the other
            least, most = min(map(np.min, inside)), max(map(np.max, inside))
            met[column] = [
                ((part < NEAR) & (least > -BEYOND)) | ((part > 1.0 - NEAR) & (most < 1.0 + BEYOND)) for part in inside
            ]
    return met


def _body(model: mujoco.MjModel, body: int) -> str:
    return model.body(body).name or f"body {body}"


def _some(names: Sequence[str]) -> str:
    return ", ".join([*names[:MOST], *([f"and {len(names) - MOST} more"] if len(names) > MOST else [])])
