"""Evidence on the order of a quadrotor's motors: which of them turns the body which way."""

from collections.abc import Sequence

import numpy as np

from sym2real.logs import spec_text
from sym2real.logs.draft import Draft
from sym2real.logs.inspect_motion import in_body, slopes_of_positions
from sym2real.logs.motor_order import ORDERS, MotorOrder, Turning, motor_order
from sym2real.logs.parts import Source
from sym2real.logs.reading import CLEAR
from sym2real.trajectory import Array
from sym2real.vocabulary import MOTORS, RATE

# Torque about forward, left and up by motors front right, rear right, rear left, front left, the first turning
# counter-clockwise seen from above (docs/specification.md).
TORQUES = np.array([[-1.0, -1.0, 1.0, 1.0], [-1.0, 1.0, 1.0, -1.0], [-1.0, 1.0, -1.0, 1.0]])


def inspect_motor_order(draft: Draft) -> None:
    """Whether the rates contradict the order in which the motors are counted; they stay as they are."""
    rates = _rates(draft)
    if rates is None or not draft.has(*MOTORS):
        return
    columns = [draft.column(name) for name in MOTORS]
    found = motor_order(_turning(draft, rates, draft.raw(*columns)))
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


def _rates(draft: Draft) -> Array | None:
    """About forward, left and up ``# (rows, 3)``: the gyro's, with signs by the attitude, or the attitude's own."""
    upright = np.array([1.0, 1.0, 1.0] if draft.frames == "z_up" else [1.0, -1.0, -1.0])
    if not draft.has(*RATE.columns):
        return None if draft.body_rates is None else upright * draft.body_rates
    gyro = {name: draft.series(name) for name in RATE.columns}
    turned = [
        name in draft.turning and draft.rows.correlation(gyro[name], draft.turning[name]) < -CLEAR for name in gyro
    ]
    rates: Array = np.stack([*gyro.values()], axis=1) * upright * np.where(turned, -1.0, 1.0)
    return rates


def _turning(draft: Draft, rates: Array, sent: Array) -> list[Turning]:
    """One per stretch; angular acceleration by the motors is in units of each axis."""
    body = in_body(draft, slopes_of_positions(draft))
    air = np.stack([*body.values()], axis=1) if body else np.zeros((len(rates), 0))
    caused = [sent[:, list(order)] @ TORQUES.T for order in ORDERS]
    columns = (draft.rows.stamps, rates, air, np.stack(caused, axis=1))
    parts = zip(*map(draft.rows.parts, columns), strict=True)
    return [Turning(time, turning, wind, by_motors.swapaxes(0, 1)) for time, turning, wind, by_motors in parts]
