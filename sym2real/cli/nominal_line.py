"""The `nominal` command that makes first equations for a log, by the columns that were found in it."""

import shlex
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from sym2real.logs import Inspection, LogSpec
from sym2real.logs.inspect_driving import STEERING
from sym2real.logs.units import UNITS
from sym2real.vocabulary import (
    ACCELERATION_COLUMN,
    HEADING,
    MOTORS,
    POSITION,
    RATE_COMMAND,
    SPEED_COLUMN,
    STEER_COLUMN,
    THRUST_COLUMN,
)

OUT = "runs/nominal"
OF_JOINTS = (
    "is it of a robot of joints? `sym2real nominal mjcf ROBOT.xml --out runs/robot` makes its model, and "
    "`sym2real inspect LOG --model runs/robot` finds its columns"
)
AXLES = "METRES is the distance between the axles: measure it"
THRUST_AND_RATES = {THRUST_COLUMN, *RATE_COMMAND.columns}
DRIVEN = {STEER_COLUMN, SPEED_COLUMN}
HEADED = {"yaw", HEADING.columns[0], "attitude"}  # any of them says where a car points


@dataclass(frozen=True)
class NominalLine:
    """What to type next.

    Args:
        command: the command, with what a person must put in capital letters; empty where the log is for none.
        remarks: what those are, or what the log lacks.
    """

    command: str
    remarks: tuple[str, ...] = ()


def nominal_line(inspection: Inspection, spec: Path | None) -> NominalLine:
    """The command for the first of the logs.

    Args:
        inspection: of the logs.
        spec: where the proposed specification was written; None where it was not.
    """
    of_log = inspection.spec
    columns = {*of_log.columns} | ({"attitude"} if of_log.attitude.sources else set())
    on_the_ground = bool(HEADED & columns) and "attitude" not in columns
    if DRIVEN & columns or STEERING in {row.meaning for row in inspection.rows} or on_the_ground:
        kind, options, remarks = "car", ["--wheelbase", "METRES"], [AXLES]
        command = ACCELERATION_COLUMN if ACCELERATION_COLUMN in columns else SPEED_COLUMN
        options += ["--command", command] if command == ACCELERATION_COLUMN else []
        needed = {*POSITION.columns[:2], STEER_COLUMN, command} | (set() if HEADED & columns else {"yaw, its heading"})
    else:
        kind, (options, remarks) = "quadrotor", _interface(inspection, columns)
        needed = {*POSITION.columns, "attitude"} | (set() if options else {"thrust, or four motors"})
    if missing := sorted(needed - columns):
        lacks = f"no `nominal` line for this log: it lacks {', '.join(missing)} in a known unit"
        return NominalLine("", (lacks,) if {*POSITION.columns} & columns else (lacks, OF_JOINTS))
    if period := of_log.time.dt or (1.0 / of_log.time.rate if of_log.time.rate else None):
        options += ["--dt", f"{period:g}"]
    if "motors" in options:
        options += ["--fit-thrust", str(inspection.paths[0]), "--spec", str(spec or "SPEC.toml")]
        remarks += [] if spec else ["SPEC.toml is the specification above: --out SPEC.toml writes it"]
    return NominalLine(shlex.join(["sym2real", "nominal", kind, *options, "--out", OUT]), tuple(remarks))


def _interface(inspection: Inspection, columns: Collection[str]) -> tuple[list[str], list[str]]:
    """Options that say what the actions are, and remarks on them; no options where there are no actions."""
    if {*columns} >= THRUST_AND_RATES:
        return _by_thrust(inspection.spec, "thrust_rates")
    if THRUST_COLUMN in columns and inspection.spec.attitude_command.sources:
        return _by_thrust(inspection.spec, "thrust_attitude")
    if {*columns} >= {*MOTORS}:
        unit, remarks = _motor_unit(inspection)
        return ["--interface", "motors", "--attitude", "measured", "--motor-unit", unit], remarks
    if THRUST_COLUMN in columns:
        return _by_thrust(inspection.spec, "thrust_rates", "--attitude", "measured")
    return [], []


def _by_thrust(spec: LogSpec, *interface: str) -> tuple[list[str], list[str]]:
    """Options of an interface that commands thrust, and the mass where it is in newtons."""
    options = ["--interface", *interface]
    if UNITS.get(spec.columns[THRUST_COLUMN].unit, ("",))[0] == "m/s^2":
        return options, []
    return [*options, "--mass", "KILOGRAMS"], ["KILOGRAMS is what the robot weighs, with battery and markers"]


def _motor_unit(inspection: Inspection) -> tuple[str, list[str]]:
    source = inspection.spec.columns[MOTORS[0]]
    if UNITS.get(source.unit, ("",))[0] == "rad/s":
        return "rad/s", []
    if all(row.confidence != "unknown" for row in inspection.rows if row.column == source.column):
        return "command", []
    return "UNIT", [
        "UNIT is what the motors are counted in, which the log cannot tell: rad/s for speeds; commands of 0 to 1 need "
        "a scale in the specification"
    ]
