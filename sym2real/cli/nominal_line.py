"""The `nominal` command that makes first equations for a log, by the columns that were found in it."""

from __future__ import annotations

import shlex
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from sym2real.logs import Inspection, LogSpec
from sym2real.logs.units import UNITS
from sym2real.vocabulary import MOTORS, POSITION, RATE_COMMAND, SPEED_COLUMN, STEER_COLUMN, THRUST_COLUMN

OUT = "runs/nominal"
OF_JOINTS = (
    "is it of a robot of joints? `sym2real nominal mjcf ROBOT.xml --out runs/robot` makes its model, and "
    "`sym2real inspect LOG --model runs/robot` finds its columns"
)
THRUST_AND_RATES = {THRUST_COLUMN, *RATE_COMMAND.columns}
DRIVEN = {STEER_COLUMN, SPEED_COLUMN}


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
    line = _car(inspection.spec) if DRIVEN & inspection.spec.columns.keys() else _quadrotor(inspection, spec)
    placed = {*POSITION.columns} & inspection.spec.columns.keys()
    return line if line.command or placed else NominalLine("", (*line.remarks, OF_JOINTS))


def _step(spec: LogSpec) -> list[str]:
    period = spec.time.dt or (1.0 / spec.time.rate if spec.time.rate else None)
    return ["--dt", f"{period:g}"] if period else []


def _car(spec: LogSpec) -> NominalLine:
    if missing := _missing({*POSITION.columns[:2], *DRIVEN}, spec.columns):
        return NominalLine("", (f"no `nominal` line for this log: {missing}",))
    command = ["sym2real", "nominal", "car", "--wheelbase", "METRES", *_step(spec), "--out", OUT]
    return NominalLine(" ".join(command), ("METRES is the distance between the axles: measure it",))


def _quadrotor(inspection: Inspection, spec: Path | None) -> NominalLine:
    log_spec = inspection.spec
    columns = {*log_spec.columns} | ({"attitude"} if log_spec.attitude.sources else set())
    options, remarks = _interface(inspection, columns)
    needed = {*POSITION.columns} | {"attitude"} | (set() if options else {"thrust, or four motors"})
    if missing := _missing(needed, columns):
        return NominalLine("", (f"no `nominal` line for this log: {missing}",))
    command = ["sym2real", "nominal", "quadrotor", *options, *_step(log_spec)]
    if "motors" in options:
        log, file = str(inspection.paths[0]), str(spec) if spec else "SPEC.toml"
        command += ["--fit-thrust", shlex.quote(log), "--spec", shlex.quote(file)]
        if spec is None:
            remarks.append("SPEC.toml is the specification above: --out SPEC.toml writes it")
    return NominalLine(" ".join([*command, "--out", OUT]), tuple(remarks))


def _interface(inspection: Inspection, columns: Collection[str]) -> tuple[list[str], list[str]]:
    """Options that say what the actions are, and remarks on them; no options where there are no actions."""
    spec = inspection.spec
    if {*columns} >= THRUST_AND_RATES:
        return ["--interface", "thrust_rates", *_mass(spec)], _weighed(spec)
    if THRUST_COLUMN in columns and spec.attitude_command.sources:
        return ["--interface", "thrust_attitude", *_mass(spec)], _weighed(spec)
    if {*columns} >= {*MOTORS}:
        unit, remarks = _motor_unit(inspection)
        return ["--interface", "motors", "--attitude", "measured", "--motor-unit", unit], remarks
    if THRUST_COLUMN in columns:
        return ["--interface", "thrust_rates", "--attitude", "measured", *_mass(spec)], _weighed(spec)
    return [], []


def _per_mass(spec: LogSpec) -> bool:
    return UNITS.get(spec.columns[THRUST_COLUMN].unit, ("",))[0] == "m/s^2"


def _mass(spec: LogSpec) -> list[str]:
    return [] if _per_mass(spec) else ["--mass", "KILOGRAMS"]


def _weighed(spec: LogSpec) -> list[str]:
    return [] if _per_mass(spec) else ["KILOGRAMS is what the robot weighs, with battery and markers"]


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


def _missing(needed: Collection[str], columns: Collection[str]) -> str:
    missing = sorted({*needed} - {*columns})
    return f"it lacks {', '.join(missing)} in a known unit" if missing else ""
