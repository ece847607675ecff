"""What is measured late: a heading or a place alone, or the pose that a camera or a lidar gives in one."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.fault import Breach
from sym2real.diagnosis.faults.mistakes.balance import Balances, chance, missed_beside_drag
from sym2real.diagnosis.faults.mistakes.transformation import Late, of_all
from sym2real.diagnosis.faults.sensor_faults import predictions
from sym2real.diagnosis.faults.sensor_readings import PATH, Reading, measured_by, readings
from sym2real.diagnosis.settings import SETTINGS
from sym2real.layout import Layout
from sym2real.logs.wheel_speed import made_of_wheel
from sym2real.symbolic import Equations
from sym2real.trajectory import Array
from sym2real.vocabulary import ATTITUDE, HEADING, POSITION, VELOCITY

POSE, POINTING = "pose", (ATTITUDE.columns, HEADING.columns)
ANSWERING, TINY = 4, 1e-9  # rows in which a rate answers, a late command's too


def behind_their_rates(model: Equations | None, data: Dataset) -> list[Breach]:
    """What all its rates are ahead of: no sensor reports what is still to come, so it is late itself.

    By more than what rates at rows are in between makes of it (:func:`_by_holding`).
    """
    lates, asked = list[tuple[Late, str]](), set[str]()
    balances = Balances.of(model, data) if model else None
    while shifted := [reading for reading in _shifted(data) if reading.of not in asked]:
        asked |= {measured := shifted[0].of}  # of a heading that has been mended velocities have turned
        predicted = predictions(model, data) if model else None
        own = _by_holding(predicted, data) if predicted else {}
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
    return _by_common_clock(lates)


def _by_holding(predicted: Dataset, data: Dataset) -> dict[str, float]:
    """By how much rates of honest logs seem late, s: those at rows are not those in between.

    A rate that answers its command at once is what turns the robot in the row before, and so half a row late. One of
    which a row sees the part p of the answer, the rest decaying by 1 - p a row, has reached after k rows what it would,
    less (1 - p)^k; the trapezoidal rule through that is off the exponential's integral by Δt (1/p - 1/2 + 1/ln(1 - p)).
    A model may have no servo where a robot has one, so the part is what the log shows of the model's answer.
    """
    own = {reading.column: reading.shift for reading in readings(predicted, honest=0.0, noisy=False)}
    for column in own.keys() & {*data.layouts.state}:
        answers = _answers([log.column(column) for log in predicted], [log.column(column) for log in data])
        part = min(answers.max() / answers.sum(), 1.0 - TINY) if answers.sum() > 0.0 else 1.0 - TINY
        own[column] = min(own[column], data.dt * (1.0 / part - 0.5 + 1.0 / np.log1p(-part)))
    return own


def _answers(commanded: Sequence[Array], measured: Sequence[Array]) -> Array:
    """What every row sees of the answer to a change, by rows since then ``# (ANSWERING,)``."""
    windows = [sliding_window_view(np.diff(own), ANSWERING)[:, ::-1] for own in commanded]
    changes = [np.diff(own)[ANSWERING - 1 :] for own in measured]
    return np.asarray(np.linalg.lstsq(np.concatenate(windows), np.concatenate(changes), rcond=None)[0])


def _by_common_clock(lates: Sequence[tuple[Late, str]]) -> list[Breach]:
    """To parts of a row; a heading and a place that are as late, but for what honest rates may be, are one sensor's."""
    rows, part = [late.rows for late, _ in lates], SETTINGS.part_of_a_row
    if len(rows) == 2 and max(rows) - min(rows) < 1.0 and lates[0][0].columns in POINTING:
        columns = tuple(name for late, _ in lates for name in late.columns)
        pose = replace(lates[0][0], what=POSE, columns=columns, rows=float(np.mean(rows)))
        lates = [(pose, "; ".join(text for _, text in lates))]
    return [Breach(replace(late, rows=part * round(late.rows / part)), text) for late, text in lates]


def _measured_together(state: Layout, measured: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    """What may be late together: all that rates are of, or of a pose the place alone."""
    yield measured_by(state, measured)
    if measured == PATH:
        yield POSITION.name, tuple(name for name in POSITION.columns if name in state)


def _shifted(data: Dataset) -> list[Reading]:
    return [reading for reading in readings(data) if reading.shift]


def _rates_of(late: Late, data: Dataset) -> set[str]:
    """Rates of what was moved that are not on time."""
    return {rate.column for rate in _shifted(data) if {*measured_by(data.layouts.state, rate.of)[1]} & {*late.columns}}


def with_its_place(late: Late, data: Dataset, balances: Balances | None) -> Late:
    """The place is late with an attitude or a heading where the model accelerates the robot as it moves only then.

    A velocity behind a filter, a row late, must not say as much, and what slows the robot not hide it.
    """
    state = data.layouts.state
    moves = state.has_field(POSITION.name) and state.has_field(VELOCITY.name)
    if balances is None or late.columns not in POINTING or not moves:
        return late
    velocities = () if made_of_wheel(data) else VELOCITY.columns  # a wheel is no part of what measures the pose
    places = tuple(name for name in (*POSITION.columns, *velocities) if name in state)
    pose, alone = replace(late, what=POSE, columns=(*late.columns, *places)), of_all(late, data)
    versions = of_all(pose, data), alone, of_all(replace(late, columns=places, rows=1.0), alone)
    whole, still, filtered = (missed_beside_drag(balances.inside(logs)) for logs in versions)
    return pose if chance(still, whole) < SETTINGS.false_alarms and filtered.mean() > whole.mean() else late
