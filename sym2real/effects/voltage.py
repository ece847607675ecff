"""The battery's voltage as an input of equations that were written, or learned, without it."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from sym2real.symbolic import Equations
from sym2real.symbolic.source import TIME
from sym2real.trajectory import Array, Trajectory

VOLTAGE, REFERENCE = "vbat", "full_battery"
# Time from a log's start in which its thrust map is taken to hold, as in a calibration of the thrust per unit, s.
CALIBRATION_SECONDS = 2.0
# Time over which a logged voltage is averaged, s: its noise and the load's ripple are as large as the fall of a flight,
# and an effect of a noisy input is found too small.
SMOOTHING_SECONDS = 2.5


def with_voltage(equations: Equations, reference: float) -> Equations:
    """The equations with the input ``vbat`` (V), added last where they have none; the motion is the same.

    Args:
        equations: of a robot with a battery.
        reference: voltage at which their thrust map holds, V; kept where the equations know one.
    """
    numbers = {REFERENCE: reference, **equations.numbers}
    return replace(equations, layouts=equations.layouts.with_input(VOLTAGE), numbers=numbers)


def settled(log: Trajectory) -> Array:
    """The voltage of a log, averaged over :data:`SMOOTHING_SECONDS` around every row ``# (rows,)``."""
    kernel = np.ones(min(len(log), 2 * round(SMOOTHING_SECONDS / 2 / log.dt) + 1))
    count = np.convolve(np.ones(len(log)), kernel, "same")
    return np.convolve(log.column(VOLTAGE), kernel, "same") / count


def voltage_at_start(logs: Iterable[Trajectory]) -> float | None:
    """Voltage in the first two seconds, median over recordings, V; None where a log does not hold it.

    A part of a recording that goes on where another one ends (its clock ``t`` does not begin at zero) has no start.
    """
    logs = list(logs)
    if not all(VOLTAGE in log.layouts.inputs or VOLTAGE in log.extra for log in logs):
        return None
    begun = [log for log in logs if TIME not in log.extra or log.extra[TIME][0] == 0.0] or logs
    starts = [log.column(VOLTAGE)[log.time <= log.time[0] + CALIBRATION_SECONDS].mean() for log in begun]
    return float(np.median(starts)) if starts else None
