"""Thrust per unit of motor command as a log shows it, with the time step and the motors' unit that it has."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sym2real.errors import DataError
from sym2real.experiments.measured import step_of
from sym2real.logs import LogSpec, read_logs
from sym2real.logs.dropouts import LEFT_OUT
from sym2real.logs.reader import logs_of, read_each
from sym2real.logs.standing import in_motion
from sym2real.logs.units import UNITS
from sym2real.robots import fit_thrust_per_unit, quadrotor
from sym2real.robots.motors import MotorUnit
from sym2real.trajectory import Trajectory
from sym2real.vocabulary import MOTORS

CALIBRATION_SECONDS = 2.0
FEWEST_FITS = 5  # that scatter about a line, which takes two numbers of them
# Commands go from 0 to 1, with what a mixer may add; rotors in the air turn far faster than a radian a second.
LARGEST_COMMAND = 1.5


@dataclass(frozen=True)
class ThrustOfLog:
    """The thrust of a log's motors.

    Args:
        per_mass: acceleration per unit of command in m/s², or per squared speed in m/rad².
        unit: of the motors.
        dt: step of the log's rows in s, or the one that was asked for.
        scatter: part of the thrust by which fits to every two seconds of the log scatter about a line, as batteries sag
            (a standard deviation); NaN where these are too few.
        notes: what was taken from the log, one sentence each.
    """

    per_mass: float
    unit: MotorUnit
    dt: float
    scatter: float
    notes: tuple[str, ...]


def thrust_of_log(
    path: Path, spec: LogSpec | None, dt: float | None = None, unit: MotorUnit | None = None
) -> ThrustOfLog:
    """Thrust per unit of the motors in the first two seconds of a log, of its longest stretch in flight without a gap.

    Args:
        path: of the log.
        spec: how its columns are named.
        dt: step in s that it is brought to; None for its own.
        unit: of its motors; None for what the specification or the numbers say.

    Raises:
        DataError: when the log cannot be read, has no motors or attitude, or its motors are not in that unit or in
            none that the numbers tell.
        ModelError: when it is too short, or has no thrust.
    """
    layouts = quadrotor(interface="motors", attitude="measured").layouts
    if len(logs := logs_of(path, spec)) > 1:
        raise DataError(path, "one log to fit the thrust on", f"a folder of {len(logs)}")
    step = dt or step_of(read_each(logs, spec, layouts, None))
    read = read_logs(path, spec=spec, layouts=layouts, dt=step, upsample=True)
    pieces = tuple(flown for log in read for flown in in_motion(log))
    log = max(pieces, key=len)
    counted = _unit(path, log, spec, unit)
    notes = [] if dt is not None else [f"time step {step:g} s, the log's own (--dt takes another)"]
    if unit is None:
        notes.append(f"motors are {'commands of 0 to 1' if counted == 'command' else 'speeds in rad/s'}")
    if len(pieces) > 1:
        length = log.time[-1] - log.time[0]
        notes.append(f"the log has {len(pieces)} stretches with gaps between them: the longest is used, {length:.4g} s")
    notes += [note for note in pieces[0].notes if note.startswith(LEFT_OUT)]
    thrust = fit_thrust_per_unit(log, CALIBRATION_SECONDS, counted)
    return ThrustOfLog(thrust, counted, step, _scatter(log, counted) / thrust, tuple(notes))


def _scatter(log: Trajectory, unit: MotorUnit) -> float:
    """Standard deviation of fits to parts as long as the first one, about a line."""
    starts = np.arange(log.time[0], log.time[-1] - CALIBRATION_SECONDS, CALIBRATION_SECONDS)
    if len(starts) < FEWEST_FITS:
        return float("nan")
    parts = (log.rows(row, len(log)) for row in np.searchsorted(log.time, starts).tolist())
    fits = np.array([fit_thrust_per_unit(part, CALIBRATION_SECONDS, unit) for part in parts])
    line = np.polyval(np.polyfit(starts, fits, 1), starts)
    return float(np.sqrt(np.sum((fits - line) ** 2) / (len(fits) - 2)))


def _unit(path: Path, log: Trajectory, spec: LogSpec | None, asked: MotorUnit | None) -> MotorUnit:
    """The unit of the motors, where specification, numbers and what was asked for do not contradict each other."""
    values = np.stack([log.column(name) for name in MOTORS])
    low, high = float(values.min()), float(values.max())
    span, column = f"{low:.4g} to {high:.4g}", " … ".join((MOTORS[0], MOTORS[-1]))
    source = spec.columns.get(MOTORS[0]) if spec else None
    named = spec.name if spec and source and UNITS.get(source.unit, ("",))[0] == "rad/s" else ""
    if asked == "rad/s" and high <= LARGEST_COMMAND:
        wanted = "speeds in rad/s, as --motor-unit says (--motor-unit command for commands of 0 to 1)"
        raise DataError(path, wanted, span, column=column)
    if named and asked == "command":
        raise DataError(path, "commands of 0 to 1, as --motor-unit says", f"speeds, by {named}", column=column)
    if asked == "rad/s" or named:
        return "rad/s"
    if high > LARGEST_COMMAND:
        wanted = (
            "commands of 0 to 1 (--motor-unit rad/s for speeds; or a unit in the log specification: rpm, uint16, %)"
        )
        raise DataError(path, wanted, span, column=column)
    return "command"
