"""Faults of the data, settled before any search: frames, units, signs, scales, biases, times, motors' order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import torch

from sym2real import rotation
from sym2real.diagnosis.data.agreement import (
    AGREES,
    RATES,
    REVERSED,
    VELOCITIES,
    rate_agreement,
    thrust_agreement,
    to_world,
    velocity_agreement,
)
from sym2real.diagnosis.data.heading import against_the_path
from sym2real.diagnosis.data.preparation import DT_TOLERANCE
from sym2real.diagnosis.data.scaled import divided
from sym2real.diagnosis.faults.command_signs import reversed_commands
from sym2real.diagnosis.faults.command_units import foreign_commands
from sym2real.diagnosis.faults.conventions import Breach, Look, through, undone, unless_healthy
from sym2real.diagnosis.faults.foreign_units import ForeignUnit, foreign_positions, foreign_rates, foreign_velocities
from sym2real.diagnosis.faults.mistakes import bad_rows, mistakes
from sym2real.diagnosis.faults.motor_columns import (
    in_order,
    order_of_motors,
    order_said,
    spin_said,
    turned_the_other_way,
)
from sym2real.diagnosis.faults.quaternion_order import scalar_last
from sym2real.diagnosis.faults.report import exact, exactness, excitation, loss_said
from sym2real.diagnosis.faults.sensor_faults import readings
from sym2real.effects import EFFECTS, compose, effect
from sym2real.effects.sensor_bias import SENSOR_BIAS
from sym2real.effects.sensor_scale import SENSOR_SCALE
from sym2real.effects.sensor_sign import SENSOR_SIGN
from sym2real.effects.sensors import Sensors
from sym2real.effects.time_shift import TIME_SHIFT
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset

SAID = {
    SENSOR_SCALE.name: "the logged {column} is {0:.3g} times what the {other} changes by",
    SENSOR_BIAS.name: "the logged {column} is off by {0:.3g} from what the {other} changes by",
    TIME_SHIFT.name: "the logged {column} is {1:.0f} ms behind the {other}",
}
# Faults that a model can have and a controller can undo; a time shift is neither.
OF_SENSORS = (SENSOR_SCALE.name, SENSOR_BIAS.name)


@dataclass(frozen=True)
class Fault:
    """Something wrong with the data.

    Args:
        effect: key of the measurement effect that describes it; "" where none does.
        evidence: what shows it, one sentence; without an effect "what is wrong: what shows it".
        fix: what to change in the log, the driver or the sensor.
        value: of the effect's parameter; None where there is no effect.
        sensor: whether a sensor is so, which a model of the robot has too; false for how a log is written, or when.
    """

    effect: str
    evidence: str
    fix: str = ""
    value: float | None = None
    sensor: bool = False

    @property
    def name(self) -> str:
        """For a sentence: without an effect, what is told before its figures."""
        if not self.effect:
            return self.evidence.partition(":")[0]
        told = self.value is None or self.effect.startswith(SENSOR_SIGN.name)
        return self.effect if told else f"{self.effect} ({self.value:.3g})"

    def to_dict(self) -> dict[str, str | float | bool | None]:
        """The entry of ``faults`` in docs/method.md, "Answers as files"."""
        return dict(vars(self))


@dataclass(frozen=True, eq=False)
class Checked:
    """Data without the faults that could be undone, and remarks.

    Args:
        data: corrected logs.
        faults: what was wrong; undone where the logs tell how.
        notes: what was seen and left as it is.
    """

    data: Dataset
    faults: tuple[Fault, ...]
    notes: tuple[str, ...]


def check(model: Equations, data: Dataset) -> Checked:
    """Find and undo what no model can explain: frames and units first, then signs, scales, biases and time
    shifts, then the units of commands and the order of motors.

    What the model itself says of its sensors is no fault: the data are judged as its sensors' input.
    """
    found: list[Fault] = []
    sensors = Sensors(model)
    data = through(sensors.state, data)
    mistaken = unless_healthy(partial(mistakes, model))
    steps: tuple[Callable[[Dataset], Settled], ...] = (
        *(_breached(bad_rows), _breached(scalar_last), _breached(mistaken)),
        *(_attitude, _heading, _velocity_frame),
        *map(_breached, (foreign_positions, foreign_velocities, foreign_rates)),
        _signs,
        *(_breached(partial(foreign_commands, model)), _breached(mistaken)),
        _breached(partial(reversed_commands, model)),
        _sensors,
        partial(_motors, model),
    )
    for settle in steps:
        faults, data = settle(data)
        found += faults
    data = through(sensors.measured, data)
    notes = (*loss_said(data), *_time_step(model, data), *_saturation(data), *_noise(data))
    return Checked(data, tuple(found), notes)


Settled = tuple[Sequence[Fault], Dataset]


def with_sensors_of(equations: Equations, faults: Sequence[Fault]) -> Equations:
    """The equations with the sensors that were found wrong: they predict what these report.

    Args:
        equations: whose sensors are right, or report what the data were corrected to.
        faults: in the order in which they were undone.
    """
    for fault in reversed(faults):
        if fault.sensor and fault.value is not None:
            equations = compose(equations, [(effect(fault.effect, equations), {"value": fault.value})])
    return equations


def _breached(look: Look) -> Callable[[Dataset], Settled]:
    """What stands against a convention, undone."""

    def settle(data: Dataset) -> Settled:
        """Faults of these logs, and the logs without them."""
        found = look(data)
        return [_fault(one, data) for one in found], undone(found, data)

    return settle


def _fault(one: Breach, data: Dataset) -> Fault:
    """With the effect of one column of the state, where it is that."""
    if isinstance(one, ForeignUnit) and len(one.columns) == 1 and one.columns[0] in data.layouts.state:
        return Fault(f"{SENSOR_SCALE.name}:{one.columns[0]}", one.evidence, one.fix, one.factor)
    return Fault("", one.evidence, one.fix)


def _attitude(data: Dataset) -> Settled:
    """Quaternions that turn from world to body."""
    agreement = thrust_agreement(list(data))
    if agreement.verdict not in ("other frame", "reversed") or (agreement.in_other_frame or 0.0) <= AGREES:
        return (), data
    evidence = (
        f"the direction of thrust that the attitude gives and the measured acceleration correlate by "
        f"{agreement.correlation:.2f}, with the attitude turned the other way by {agreement.in_other_frame:.2f}"
    )
    fix = "log the quaternion from body to world: change the sign of qx, qy, qz"
    place, turned = data.layouts.state.slice("attitude"), []
    for log in data:
        state = log.state.copy()
        state[:, place] = rotation.conjugate(torch.as_tensor(state[:, place])).numpy()
        turned.append(replace(log, state=state))
    return [Fault("", evidence, fix)], Dataset(turned)


def _heading(data: Dataset) -> Settled:
    """Headings that turn against the path."""
    found = against_the_path(data)
    if found is None:
        return (), data
    evidence = (
        f"a heading that turns against the path: with its sign reversed it turns with it ({found.together:.2f} of 1, "
        f"as it stands {found.as_it_stands:.2f})"
    )
    zero = f" and give it a zero of {found.apart:.2f} rad (in its unit)" if found.apart else ""
    fix = f"change the sign of yaw: flip its column in the log's specification{zero}"
    return [Fault("", evidence, fix)], Dataset(found.undone(log) for log in data)


def _velocity_frame(data: Dataset) -> Settled:
    """Velocities along body axes."""
    found = {name: one for name, one in velocity_agreement(list(data)).items() if one.verdict == "other frame"}
    if not found:
        return (), data
    (name, one), *_ = found.items()
    evidence = (
        f"the logged {name} and the position's derivative correlate by {one.correlation:.2f}, turned from body to "
        f"world axes by {one.in_other_frame:.2f}"
    )
    turned, columns = [], [name for name in VELOCITIES if name in data.layouts.state]
    for log in data:
        state, velocity = log.state.copy(), to_world(log)
        assert velocity is not None  # it has just been compared
        state[:, data.layouts.state.indices(columns)] = velocity
        turned.append(replace(log, state=state))
    return [Fault("", evidence, "log the velocity along world axes, or turn it when the log is read")], Dataset(turned)


def _signs(data: Dataset) -> Settled:
    faults = wrong_signs(data)
    columns = [fault.effect.partition(":")[2] for fault in faults]
    return faults, divided(data, columns, -1.0) if columns else data


def wrong_signs(data: Dataset) -> tuple[Fault, ...]:
    """Body rates and velocities whose sign contradicts the derivative of the attitude or the position."""
    judged = {**rate_agreement(list(data)), **velocity_agreement(list(data))}
    return tuple(
        Fault(
            f"{SENSOR_SIGN.name}:{column}",
            f"the logged {column} and the {_measured_by(column)}'s derivative correlate by {found:.3f}",
            SENSOR_SIGN.fix,
            -1.0,
            sensor=True,
        )
        for column, agreement in judged.items()
        if (found := agreement.correlation) is not None and found < REVERSED
    )


def _sensors(data: Dataset) -> Settled:
    """Scales, biases and time shifts of rates and velocities."""
    faults = []
    for one in readings(data):
        data = Dataset(one.undone(log) for log in data)
        for kind, value in one.faulty.items():
            said = SAID[kind].format(value, 1e3 * value, column=one.column, other=_measured_by(one.column))
            faults.append(Fault(f"{kind}:{one.column}", said, EFFECTS[kind].fix, value, sensor=kind in OF_SENSORS))
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


def _measured_by(column: str) -> str:
    return "attitude" if column in RATES else "position"


def _time_step(model: Equations, data: Dataset) -> tuple[str, ...]:
    if abs(data.dt - model.dt) <= DT_TOLERANCE * model.dt:
        return ()
    return (f"the model's time step is {model.dt:g} s, the logs have {data.dt:g} s",)


def _saturation(data: Dataset) -> tuple[str, ...]:
    return tuple(line for name, one in excitation(list(data)).items() for line in one.limits_said(name))


def _noise(data: Dataset) -> list[str]:
    return exactness(sum(exact(log) for log in data), len(data))
