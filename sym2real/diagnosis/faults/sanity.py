"""Question and data, checked before any search: frames, units, signs, scales, biases, times, motors' order."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import torch
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.fault import Breach, Fault, Settled
from sym2real.diagnosis.faults.foreign_units import BY_SENSORS, THAN, foreign_commands, scale_text
from sym2real.diagnosis.faults.misread_attitudes import against_the_path, other_angles, other_order
from sym2real.diagnosis.faults.mistakes.judge import mistakes
from sym2real.diagnosis.faults.mistakes.late_pose import behind_their_rates
from sym2real.diagnosis.faults.mistakes.lost_commands import with_lost_commands
from sym2real.diagnosis.faults.mistakes.rows import BadRows, bad_rows, joints_that_jump
from sym2real.diagnosis.faults.mistakes.transformation import of_all
from sym2real.diagnosis.faults.motor_columns import motors
from sym2real.diagnosis.faults.sensor_faults import clock_of, sensors_of
from sym2real.diagnosis.faults.units import Scaled
from sym2real.diagnosis.faults.variation import exact, exactness, excitation
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.inputs import with_common_clock
from sym2real.effects.readings import SENSOR_SCALE, SENSOR_SIGN
from sym2real.effects.sensors import Sensors
from sym2real.logs.agreement import agreements
from sym2real.logs.differences import rates_on_time
from sym2real.logs.dropouts import lost_in_reading
from sym2real.logs.sources import AsRead
from sym2real.robots.left_out import with_stops_marked
from sym2real.robots.own import robot_of
from sym2real.robots.reach import in_reach, notes_on_commands
from sym2real.symbolic import Equations
from sym2real.trajectory import Trajectory

Look = Callable[[Dataset], Sequence[Breach | BadRows]]


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

    def rescaled(self, factors: Mapping[tuple[str, ...], float]) -> Checked:
        """With other factors of commands in no unit, by the columns that share one."""
        faults, data, read = list(self.faults), self.data, AsRead(self.data[0].sources)
        for place, fault in enumerate(self.faults):
            if fault.columns in factors and fault.value is not None:
                exact = Scaled(fault.columns, factors[fault.columns])
                data = of_all(Scaled(fault.columns, exact.factor / fault.value), data)
                faults[place] = _fault(Breach(exact, scale_text(exact.factor, THAN)), data, read)
        return replace(self, data=data, faults=tuple(faults))


def check(model: Equations | None, data: Dataset) -> Checked:
    """Find and undo what no model can explain: the clock, frames and units first, then signs, scales, biases
    and time shifts, then the units of commands and the order of motors.

    What the model itself says of its sensors is no fault: the data are judged as its sensors' input. Without a model
    nobody knows what commands do.

    Raises:
        DataError: for a joint that still lies far outside its range.
    """
    return _checked(model, tuple(data))


@lru_cache(maxsize=2)  # the same logs are reported, diagnosed and drawn, and so are those that were kept aside
def _checked(model: Equations | None, logs: tuple[Trajectory, ...]) -> Checked:
    all_faults, data = list[Fault](), Dataset(logs)
    sensors = None if model is None else Sensors(model)
    data = data if sensors is None else through(sensors.state, data)
    frames, units, commands = looks_for(model)
    breached, clock = partial(_breached, dict[Look, Dataset]()), partial(clock_of, 0.0 if model is None else model.dt)
    steps: tuple[Callable[[Dataset], Settled], ...] = (
        clock,
        *(partial(breached, look) for look in (*frames, *units)),
        _signs,
        *(partial(breached, look) for look in commands),
        clock,  # which sensors in other frames and units did not tell
        partial(breached, partial(behind_their_rates, model)),
        partial(sensors_of, model),
        *(() if model is None else (partial(motors, model),)),
    )
    for settle in steps:
        faults, data = settle(data)
        all_faults += faults
    robot = None if model is None else robot_of(model)
    data = in_reach(robot, data)
    data = rates_on_time(data if sensors is None else through(sensors.measured, data))
    data = data if model is None else with_stops_marked(model, data)
    played = data if model is None else with_lost_commands(model, data)
    commands_lost, data = played is not data, with_common_clock(played)
    notes = (
        *lost_in_reading(data),
        *slow_notes(model, data, commands_lost),
        *notes_on_commands(robot, data),
        *(line for name, command in excitation(list(data)).items() for line in command.limit_notes(name)),
        *exactness(sum(exact(log) for log in data), len(data)),
    )
    return Checked(data, tuple(all_faults), notes, commands_lost)


def looks_for(model: Equations | None) -> tuple[tuple[Look, ...], ...]:
    """What is looked for, in order, with this model or without one.

    First rows, quaternions (one in another order is no turned or mirrored world), units of what sensors measure, those
    of commands, with which a model predicts nothing that columns could be judged by, and what a user has done to
    columns. Then units again, as a turned frame hid them, and again what was done to columns: once those have their
    units and signs, more can be seen, and what jumps of joints.
    """
    frames, joints = (partial(bad_rows, model=model), other_order, other_angles), partial(joints_that_jump, model=model)
    if model is None:
        return (*frames, against_the_path), BY_SENSORS, (joints,)
    mistaken, commands = partial(mistakes, model), partial(foreign_commands, model)
    first = partial(foreign_commands, model, first=True)
    return (*frames, *BY_SENSORS, first, mistaken, against_the_path), BY_SENSORS, (commands, mistaken, joints)


def through(sensors: Callable[[Tensor], Tensor], data: Dataset) -> Dataset:
    """The logs with states as sensors report them, or the other way."""
    return Dataset(replace(log, state=sensors(torch.as_tensor(log.state)).numpy()) for log in data)


def _breached(in_order: dict[Look, Dataset], look: Look, data: Dataset) -> Settled:
    """What stands against a convention, undone; ``in_order`` holds the logs in which a look found nothing."""
    if in_order.get(look) is data:
        return (), data
    breaches, read = look(data), AsRead(data[0].sources)
    if not breaches:
        in_order[look] = data
    faults = [_fault(breach, data, read) for breach in breaches]
    for breach in breaches:
        data = breach.undone(data)
    return faults, data


def _fault(breach: Breach | BadRows, data: Dataset, read: AsRead) -> Fault:
    """With the effect of one column of the state, where it is that."""
    scaled = breach.transformation if isinstance(breach, Breach) else None
    everywhere = isinstance(breach, Breach) and breach.log is None
    if isinstance(scaled, Scaled) and len(scaled.columns) == 1 and scaled.columns[0] in data.layouts.state:
        return Fault(f"{SENSOR_SCALE.name}:{scaled.columns[0]}", breach.evidence, breach.fix(read), scaled.factor)
    if isinstance(scaled, Scaled) and everywhere and not scaled.unit and {*scaled.columns} <= {*data.layouts.action}:
        return Fault("", breach.evidence, breach.fix(read), scaled.factor, columns=scaled.columns)
    return Fault("", breach.evidence, breach.fix(read))


def _signs(data: Dataset) -> Settled:
    """Rates and velocities whose sign contradicts the derivative of the attitude, the position or the joint."""
    wrong, faults = {name: own for name, own in agreements(list(data)).items() if own.verdict == "reversed"}, []
    for name, own in wrong.items():
        shown = f"the logged {name} and the {own.of}'s derivative correlate by {own.correlation:.3f}: wrong sign"
        faults.append(Fault(f"{SENSOR_SIGN.name}:{name}", shown, SENSOR_SIGN.fix, -1.0, sensor=True))
    return faults, of_all(Scaled((*wrong,), -1.0), data) if wrong else data


def slow_notes(model: Equations | None, data: Dataset, commands_lost: bool) -> list[str]:
    """What is known of commands between the rows of logs that are slower than the model; nothing of others."""
    if model is None or data.dt <= (1.0 + SETTINGS.same) * model.dt:
        return []
    lost = "commands between rows are not in the logs, and what they did is not judged"
    known = "commands are taken as held" if data[0].between is None else "commands between rows are played as logged"
    between = lost if commands_lost else known
    return [f"rows are {data.dt:.4g} s apart, the model's steps {model.dt:g} s: {between}"]
