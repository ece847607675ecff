"""What is measured late: a heading or a place alone, or the pose that a camera or a lidar gives in one."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.fault import Fault, Settled
from sym2real.diagnosis.faults.mistakes.balance import Balances, chance, missed_beside_drag
from sym2real.diagnosis.faults.mistakes.transformation import Late, mended, of_all
from sym2real.diagnosis.faults.sensor_faults import of_the_model
from sym2real.diagnosis.faults.sensor_readings import PATH, Reading, measured_by, readings
from sym2real.diagnosis.settings import SETTINGS
from sym2real.layout import Layout
from sym2real.logs.sources import AsRead
from sym2real.symbolic import Equations
from sym2real.vocabulary import ATTITUDE, HEADING, POSITION, VELOCITY

POSE, POINTING = "pose", (ATTITUDE.columns, HEADING.columns)


def behind_their_rates(model: Equations | None, data: Dataset) -> Settled:
    """What all its rates are ahead of: no sensor reports what is still to come, so it is late itself.

    By more than in the model's own predictions: a rate that changes at once is half a row ahead of what it turns.
    """
    given, lates, asked = data, list[tuple[Late, str]](), set[str]()
    balances = Balances.of(model, data) if model else None
    while shifted := [reading for reading in _shifted(data) if reading.of not in asked]:
        asked |= {measured := shifted[0].of}  # of a heading that has been mended velocities have turned
        predicted = of_the_model(model, data, honest=0.0) if model else {}
        own = {column: reading.shift for column, reading in predicted.items()}
        ahead = {rate.column: own.get(rate.column, 0.0) - rate.shift for rate in shifted if rate.of == measured}
        if min(ahead.values()) < SETTINGS.part_of_a_row * data.dt:
            continue
        rows = float(np.median([*ahead.values()])) / data.dt
        done = {name for late, _ in lates for name in late.columns}
        text = ", ".join(f"{column} is {1e3 * by:.0f} ms ahead" for column, by in ahead.items())
        for what, columns in _measured_together(data.layouts.state, measured):
            late = Late(what, tuple(name for name in columns if name not in done), rows, data.dt)
            late = with_its_place(late, data, balances)
            mended = of_all(late, data)
            if _rates_of(late, mended) <= _rates_of(late, data):  # none was on time and is so no longer
                lates.append((late, f"{text} of it"))
                data = mended
                break
    return _by_common_clock(lates, given)


def _by_common_clock(lates: Sequence[tuple[Late, str]], data: Dataset) -> Settled:
    """To parts of a row; a heading and a place that are as late, but for what honest rates may be, are one sensor's."""
    rows = [late.rows for late, _ in lates]
    if len(rows) == 2 and max(rows) - min(rows) < 1.0 and lates[0][0].columns in POINTING:
        columns = tuple(name for late, _ in lates for name in late.columns)
        lates = [(Late(POSE, columns, float(np.mean(rows)), data.dt), "; ".join(text for _, text in lates))]
    faults, read = list[Fault](), AsRead(data[0].sources)
    for exact, text in lates:
        late = replace(exact, rows=SETTINGS.part_of_a_row * round(exact.rows / SETTINGS.part_of_a_row))
        faults.append(Fault("", f"{late.name}: {text}", late.fix(read)))
        data = Dataset(mended(late, log) for log in data)
    return faults, data


def _measured_together(state: Layout, measured: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    """What may be late together: all that rates are of, or of a pose the place alone."""
    yield measured_by(state, measured)
    if measured == PATH:
        yield POSITION.name, tuple(name for name in POSITION.columns if name in state)


def _shifted(data: Dataset) -> list[Reading]:
    return [reading for reading in readings(data) if reading.shift]


def _rates_of(late: Late, data: Dataset) -> set[str]:
    """Rates of what was moved that are not on time."""
    state = data.layouts.state
    return {rate.column for rate in _shifted(data) if {*measured_by(state, rate.of)[1]} & {*late.columns}}


def with_its_place(late: Late, data: Dataset, balances: Balances | None) -> Late:
    """The place is late with an attitude or a heading where the model accelerates the robot as it moves only then.

    A velocity behind a filter, a row late, must not say as much, and what slows the robot not hide it.
    """
    state = data.layouts.state
    moves = state.has_field(POSITION.name) and state.has_field(VELOCITY.name)
    if balances is None or late.columns not in POINTING or not moves:
        return late
    places = tuple(name for name in (*POSITION.columns, *VELOCITY.columns) if name in state)
    pose, alone = replace(late, what=POSE, columns=(*late.columns, *places)), of_all(late, data)
    versions = of_all(pose, data), alone, of_all(replace(late, columns=places, rows=1.0), alone)
    whole, still, filtered = (missed_beside_drag(balances.inside(logs)) for logs in versions)
    return pose if chance(still, whole) < SETTINGS.false_alarms and filtered.mean() > whole.mean() else late
