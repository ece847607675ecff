"""What is measured late: a heading or a place alone, or the pose that a camera or a lidar gives in one."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.fault import Fault, Settled
from sym2real.diagnosis.faults.mistakes.balance import Balances, in_all
from sym2real.diagnosis.faults.mistakes.transformation import Late, Transformation, of_all
from sym2real.diagnosis.faults.sensor_faults import PATH, Reading, measured_by, of_the_model, readings
from sym2real.layout import Layout
from sym2real.logs.agreement import points_along
from sym2real.logs.sources import AsRead
from sym2real.symbolic import Equations
from sym2real.vocabulary import HEADING, POSITION, VELOCITY

PARTS = 10  # of a row


def behind_their_rates(model: Equations | None, data: Dataset) -> Settled:
    """What all its rates are ahead of: no sensor reports what is still to come, so it is late itself.

    By more than in the model's own predictions: a rate that changes at once is half a row ahead of what it turns.
    """
    faults, done, asked = [], set[str](), set[str]()
    while found := [reading for reading in _shifted(data) if reading.of not in asked]:
        asked |= {measured := found[0].of}  # of a heading that has been mended velocities have turned
        ahead = {reading.column: -reading.shift for reading in found if reading.of == measured}
        if min(ahead.values()) < 0:
            continue
        own = of_the_model(model, data, honest=0.0) if model else {}
        by = [ahead[column] + (own[column].shift if column in own else 0.0) for column in ahead]
        rows = float(np.median(by)) / data.dt
        for what, columns in _measured_together(data.layouts.state, measured):
            late = with_its_place(Late(what, tuple(name for name in columns if name not in done), rows, data.dt), data)
            mended, shifted = of_all(late, data), {reading.column for reading in _shifted(data)}
            if all(reading.column in shifted for reading in _shifted(mended)):  # none was on time and is so no longer
                said = ", ".join(f"{column} is {1e3 * by:.0f} ms ahead" for column, by in ahead.items())
                faults.append(Fault("", f"{late.name}: {said} of it", late.fix(AsRead(data[0].sources))))
                data, done = mended, {*done, *columns}
                break
    return faults, data


def _measured_together(state: Layout, measured: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    """What may be late together: all that rates are of, or of a pose the place alone."""
    yield measured_by(state, measured)
    if measured == PATH:
        yield POSITION.name, tuple(name for name in POSITION.columns if name in state)


def _shifted(data: Dataset) -> list[Reading]:
    return [reading for reading in readings(data) if reading.shift]


def to_a_part_of_a_row(balances: Balances, found: Transformation, data: Dataset) -> Transformation:
    """How late a sensor is, to a tenth of a row."""
    if not isinstance(found, Late):
        return found
    near = [replace(found, rows=found.rows + part / PARTS) for part in range(1 - PARTS, PARTS)]
    return min(near, key=lambda late: in_all(balances.inside(of_all(late, data)).losses.mean(0)))


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
