"""Evidence on the order of a quadrotor's motors: which of them turns the body which way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sym2real.logs import signals, spec_text
from sym2real.logs.draft import Draft
from sym2real.logs.inspect_attitude import CLEAR
from sym2real.logs.inspect_motion import in_body
from sym2real.logs.motor_order import ORDERS, MotorOrder, Turning, motor_order
from sym2real.logs.parts import Source
from sym2real.logs.signals import Series
from sym2real.trajectory import Array
from sym2real.vocabulary import MOTORS

RATES = ("wx", "wy", "wz")
# Torque about forward, left and up by motors front right, rear right, rear left, front left, the first turning
# counter-clockwise seen from above (docs/specification.md).
TORQUES = np.array([[-1.0, -1.0, 1.0, 1.0], [-1.0, 1.0, 1.0, -1.0], [-1.0, 1.0, -1.0, 1.0]])


def inspect_motor_order(draft: Draft) -> None:
    """Whether the rates contradict the order in which the motors are counted; they stay as they are."""
    rates = _rates(draft)
    if not rates or not draft.has(*MOTORS):
        return
    columns = [draft.column(name) for name in MOTORS]
    found = motor_order(_turning(draft, rates, columns))
    if found is None:
        return
    shown = f"rates correlate with them by {found.correlation:.2f} then, by {found.as_it_stands:.2f} as they stand"
    if found.moved:
        _report_order(draft, columns, found, shown)
    if found.reversed:
        draft.add("", "rotors turn the other way than a Crazyflie's", "", shown, "likely")
        draft.comment(MOTORS[-1], "the rotors turn the other way: make a model with --spin 1 -1 1 -1")


def _report_order(draft: Draft, columns: Sequence[str], motor_order: MotorOrder, shown: str) -> None:
    if not motor_order.certain:
        draft.add(
            "", "motors in another order than front right, rear right, rear left, front left", "", shown, "likely"
        )
        return
    acting = [columns[place] for place in motor_order.columns]
    draft.add("", "motors look permuted", "", f"{', '.join(acting)} act as motor1 to motor4: {shown}", "likely")
    draft.comment(MOTORS[-1], f"suspected: motors in another order; in place of the four above ({shown}):")
    for name, column in zip(MOTORS, acting, strict=True):
        draft.comment(MOTORS[-1], f"{name} = {spec_text.text(Source(column, draft.units[name]))}")


def _rates(draft: Draft) -> Series:
    """About forward, left and up ``# (rows, 3)``: the gyro's, with signs by the attitude, or the attitude's own."""
    upright = np.array([1.0, 1.0, 1.0] if draft.frames == "z_up" else [1.0, -1.0, -1.0])
    if not draft.has(*RATES):
        return [upright * part for part in draft.body_rates]
    signs = upright
    if draft.body_rates:
        pairs = [(draft.series(name), [part[:, axis] for part in draft.body_rates]) for axis, name in enumerate(RATES)]
        signs = upright * [-1.0 if signals.correlation(*pair) < -CLEAR else 1.0 for pair in pairs]
    return [signs * np.stack(parts, axis=1) for parts in zip(*map(draft.series, RATES), strict=True)]


def _turning(draft: Draft, rates: Series, columns: Sequence[str]) -> list[Turning]:
    along = {f"v{axis}": signals.slopes(draft.stamps, draft.series(axis)) for axis in "xyz" if draft.has(axis)}
    body = list((in_body(draft, along) if along else {}).values())
    sent = [np.stack(parts, axis=1) for parts in zip(*map(draft.raw, columns), strict=True)]
    flights = []
    for log, time in enumerate(draft.stamps):
        air = np.stack([part[log] for part in body], axis=1) if body else np.zeros((len(time), 0))
        flights.append(Turning(time, rates[log], air, _caused(sent[log])))
    return flights


def _caused(sent: Array) -> Array:
    """Angular acceleration by motors ``# (rows, 4)`` in every order, in units of each axis ``# (24, rows, 3)``."""
    return np.stack([sent[:, list(order)] @ TORQUES.T for order in ORDERS])
