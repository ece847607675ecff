"""Faults of the data, settled before any search: frames, units, signs, scales, biases, times, motors' order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.agreement import agreements
from sym2real.diagnosis.data.changed import divided
from sym2real.diagnosis.faults.conventions import Breach, Look, looks_for, through, undone
from sym2real.diagnosis.faults.fault import Fault, Settled
from sym2real.diagnosis.faults.foreign_units import ForeignUnit
from sym2real.diagnosis.faults.mistakes.lost_commands import with_lost_commands
from sym2real.diagnosis.faults.mistakes.transformation import Late, of_all
from sym2real.diagnosis.faults.mistakes.wheel_speed import LatePose
from sym2real.diagnosis.faults.motor_columns import (
    in_order,
    order_of_motors,
    order_said,
    spin_said,
    turned_the_other_way,
)
from sym2real.diagnosis.faults.sensor_faults import PATH, OfWheel, measured_by, readings
from sym2real.diagnosis.faults.variation import exact, exactness, excitation
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects import EFFECTS
from sym2real.effects.inputs import with_one_clock
from sym2real.effects.sensor_bias import SENSOR_BIAS
from sym2real.effects.sensor_scale import SENSOR_SCALE
from sym2real.effects.sensor_sign import SENSOR_SIGN
from sym2real.effects.sensors import Sensors
from sym2real.effects.time_shift import TIME_SHIFT
from sym2real.logs.differences import rates_on_time
from sym2real.logs.dropouts import is_unasked
from sym2real.logs.sources import AsRead
from sym2real.symbolic import Equations
from sym2real.trajectory import Trajectory

SAID = {
    SENSOR_SCALE.name: "the logged {column} is {0:.3g} times what the {other} changes by",
    SENSOR_BIAS.name: "the logged {column} is off by {0:.3g} from what the {other} changes by",
    TIME_SHIFT.name: "the logged {column} is {1:.0f} ms behind the {other}",
}
# What a specification says, or what is done before a log is read, behind what a kind's own fix says.
MENDED = {
    SENSOR_SCALE.name: ", or give {0} {number} in a specification of the log",
    SENSOR_BIAS.name: "",
    TIME_SHIFT.name: ": {0} by {ms:.0f} ms earlier",
}
# Faults that a model can have and a controller can undo; a time shift is neither.
OF_SENSORS = (SENSOR_SCALE.name, SENSOR_BIAS.name)


@dataclass(frozen=True, eq=False)
class Checked:
    """Data without the faults that could be undone, and remarks.

    Args:
        data: corrected logs.
        faults: what was wrong; undone where the logs tell how.
        notes: what was seen and left as it is.
        commands_lost: whether commands were sent between rows that no row tells.
    """

    data: Dataset
    faults: tuple[Fault, ...]
    notes: tuple[str, ...]
    commands_lost: bool = False


def check(model: Equations | None, data: Dataset) -> Checked:
    """Find and undo what no model can explain: frames and units first, then signs, scales, biases and time
    shifts, then the units of commands and the order of motors.

    What the model itself says of its sensors is no fault: the data are judged as its sensors' input. Without a model
    nobody knows what commands do.
    """
    return _checked(model, tuple(data))


@lru_cache(maxsize=2)  # the same logs are reported, diagnosed and drawn, and so are those that were kept aside
def _checked(model: Equations | None, logs: tuple[Trajectory, ...]) -> Checked:
    found: list[Fault] = []
    data = Dataset(replace(log, between=None) for log in logs)
    sensors = None if model is None else Sensors(model)
    data = data if sensors is None else through(sensors.state, data)
    frames, units, commands = looks_for(model)
    breached = partial(_breached, dict[Look, Dataset]())
    steps: tuple[Callable[[Dataset], Settled], ...] = (
        *(partial(breached, look) for look in (*frames, *units)),
        _signs,
        *(partial(breached, look) for look in commands),
        _behind_their_rates,
        _sensors,
        *(() if model is None else (partial(_motors, model),)),
    )
    for settle in steps:
        faults, data = settle(data)
        found += faults
    data = rates_on_time(data if sensors is None else through(sensors.measured, data))
    data = with_one_clock(data if model is None else with_lost_commands(model, data))
    notes = (
        *_lost(data),
        *slow_said(model, data),
        *_saturation(data),
        *exactness(sum(exact(log) for log in data), len(data)),
    )
    return Checked(data, tuple(found), notes, any(log.between is not None for log in data))


def _breached(in_order: dict[Look, Dataset], look: Look, data: Dataset) -> Settled:
    """What stands against a convention, undone; ``in_order`` holds the logs in which a look found nothing."""
    if in_order.get(look) is data:
        return (), data
    breaches, read = look(data), AsRead(data[0].sources)
    if not breaches:
        in_order[look] = data
    return [_fault(breach, data, read) for breach in breaches], undone(breaches, data)


def _fault(breach: Breach, data: Dataset, read: AsRead) -> Fault:
    """With the effect of one column of the state, where it is that."""
    if isinstance(breach, ForeignUnit) and len(breach.columns) == 1 and breach.columns[0] in data.layouts.state:
        return Fault(f"{SENSOR_SCALE.name}:{breach.columns[0]}", breach.evidence, breach.fix(read), breach.factor)
    return Fault("", breach.evidence, breach.fix(read))


def _signs(data: Dataset) -> Settled:
    """Rates and velocities whose sign contradicts the derivative of the attitude, the position or the joint."""
    wrong = {column: found for column, found in agreements(list(data)).items() if found.verdict == "reversed"}
    said = "the logged {} and the {}'s derivative correlate by {:.3f}: wrong sign"
    texts = {column: said.format(column, found.of, found.correlation) for column, found in wrong.items()}
    faults = [
        Fault(f"{SENSOR_SIGN.name}:{column}", text, SENSOR_SIGN.fix, -1.0, sensor=True)
        for column, text in texts.items()
    ]
    return faults, divided(data, [*wrong], -1.0) if wrong else data


def _behind_their_rates(data: Dataset) -> Settled:
    """What all its rates are ahead of: no sensor reports what is still to come, so it is late itself."""
    faults, found, done = [], [reading for reading in readings(data) if reading.shift], set[str]()
    for measured in dict.fromkeys(reading.of for reading in found):
        ahead = {reading.column: -reading.shift for reading in found if reading.of == measured}
        rows = round(float(np.median([*ahead.values()])) / data.dt) if min(ahead.values()) > 0 else 0
        if not rows:
            continue
        what, columns = measured_by(data.layouts.state, measured)
        kind = LatePose if measured == PATH else Late
        late = kind(what, tuple(name for name in columns if name not in done), rows, data.dt)
        # A rate that was on time and is so no longer: then not what is measured was late.
        mended = of_all(late, data)
        shifted = {reading.column for reading in readings(mended) if reading.shift and reading.of == measured}
        if shifted <= ahead.keys():
            said = ", ".join(f"{column} is {1e3 * by:.0f} ms ahead" for column, by in ahead.items())
            faults.append(Fault("", f"{late.name}: {said} of it", late.fix(AsRead(data[0].sources))))
            data, done = mended, {*done, *columns}
    return faults, data


def _sensors(data: Dataset) -> Settled:
    """Scales, biases and time shifts of rates and velocities."""
    faults, read = [], AsRead(data[0].sources)
    for reading in readings(data):
        data = Dataset(reading.undone(log) for log in data)
        for kind, value in reading.faulty.items():
            evidence = SAID[kind].format(value, 1e3 * value, column=reading.column, other=reading.of)
            mend = MENDED[kind].format(read.column(reading.column), number=read.scale(1.0 / value), ms=1e3 * value)
            effect = "" if isinstance(reading, OfWheel) else f"{kind}:{reading.column}"
            fix = f"{EFFECTS[kind].fix}{mend}"
            faults.append(Fault(effect, evidence, fix, value, bool(effect) and kind in OF_SENSORS))
    return faults, data


def _motors(model: Equations, data: Dataset) -> Settled:
    """Motor columns in another order than the model's, and rotors that turn the other way."""
    order, faults = order_of_motors(model, data), []
    if order is None:
        return (), data
    if order.moved:
        faults.append(Fault("", *order_said(order)))
        if not order.certain:
            return faults, data
        data = in_order(order, data)
    if order.reversed:
        faults.append(Fault("", *spin_said(model, data)))
        data = turned_the_other_way(model, data) or data
    return faults, data


def _lost(data: Dataset) -> list[str]:
    """What was lost or changed of the logs when they were read."""
    return [f"{log.name}: {note}" for log in data for note in log.notes if is_unasked(note)]


def slow_said(model: Equations | None, data: Dataset) -> list[str]:
    if model is None or data.dt <= (1.0 + SETTINGS.same) * model.dt:
        return []
    lost = "commands between rows are not in the logs, and what they did is not judged"
    held = "commands are taken as held" if data[0].between is None else lost
    return [f"rows are {data.dt:.4g} s apart, the model's steps {model.dt:g} s: {held}"]


def _saturation(data: Dataset) -> tuple[str, ...]:
    return tuple(line for name, command in excitation(list(data)).items() for line in command.limits_said(name))
