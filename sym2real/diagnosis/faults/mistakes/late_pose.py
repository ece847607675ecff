"""Whether what was late is a heading alone, or the pose that a camera or a lidar gives in one."""

from dataclasses import replace

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.mistakes.transformation import Late, Transformation, of_all
from sym2real.logs.agreement import points_along
from sym2real.vocabulary import HEADING, POSITION, VELOCITY


def with_its_place(late: Transformation, data: Dataset) -> Transformation:
    """The place is late with a heading where the car goes where it points only then, and nothing else tells its clock.

    What tells it is a velocity of its own: one that was derived from places is as late as they are.
    """
    state, sources = data.layouts.state, data[0].sources
    derived = bool(sources) and not any(name in sources for name in VELOCITY.columns)
    if not (derived and isinstance(late, Late) and late.columns == HEADING.columns):
        return late
    places = tuple(name for field in (POSITION, VELOCITY) for name in field.columns if name in state)
    pose = replace(late, what="pose", columns=(*late.columns, *places))
    alone, whole = (points_along([*of_all(moved, data)]) for moved in (late, pose))
    return pose if whole > alone else late
