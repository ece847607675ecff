"""A diagnosis and an outcome of an experiment as their files hold them, for reports that are written later."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from sym2real.diagnosis import Diagnosis, Estimate, Fault, Finding, Floor, Gate, Term, Where
from sym2real.diagnosis.errors.rungs import Stage, StageError
from sym2real.diagnosis.predict.competitors import NotTried
from sym2real.diagnosis.unexplained.leftover import Leftover
from sym2real.errors import DataError
from sym2real.experiments.study.outcome import Line, Outcome, Panel
from sym2real.files import read_object

Json = Mapping[str, Any]


def read_diagnosis(file: Path) -> Diagnosis:
    """The diagnosis of a file; what it does not hold (misfits) is not a number.

    Raises:
        DataError: naming the file, when it holds no diagnosis.
    """
    found = read_object(file, "a diagnosis")
    try:
        return _diagnosis(found)
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise DataError(file, "a diagnosis as `sym2real diagnose --out` writes it", str(error)) from error


def read_outcome(file: Path) -> Outcome:
    """The outcome of an experiment.

    Raises:
        DataError: naming the file, when it holds none.
    """
    found = read_object(file, "the outcome of an experiment")
    try:
        rows = found["rows"]
        columns = tuple(rows[0]) if rows else ()
        return Outcome(
            found["title"],
            columns,
            tuple(tuple(row[name] for name in columns) for row in rows),
            tuple(found["notes"]),
            found["x"],
            found["y"],
            tuple(_panel(entry) for entry in found["panels"]),
        )
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise DataError(file, "an outcome as `sym2real experiment --out` writes it", str(error)) from error


def _panel(panel: Json) -> Panel:
    lines = {
        name: Line(*(np.array([_number(value) for value in line[end]]) for end in ("x", "mean", "spread")))
        for name, line in panel["lines"].items()
    }
    return Panel(panel["title"], lines, panel["level"], panel["paper"])


def _diagnosis(found: Json) -> Diagnosis:
    left = found["leftover"] or {}
    proposal = Term(left["channel"], left["term"], left["gain"]) if "gain" in left else None
    return Diagnosis(
        verdict=found["verdict"],
        summary=str(found["summary"]),
        faults=tuple(Fault(**entry) for entry in found["faults"]),
        findings=tuple(_finding(entry) for entry in found["findings"]),
        leftovers=tuple(Leftover(**entry) for entry in found["leftovers"]),
        proposal=proposal,
        where=tuple(Where(**entry) for entry in found["where"]),
        ladder=tuple(_stage(entry) for entry in found["ladder"]),
        floor=tuple(_floor(entry) for entry in found["floor"]),
        held_out=tuple(found["held_out"]),
        apart=bool(found["held_out_apart"]),
        gate=_gate(found["gate"]),
        seconds=float(found["seconds"]),
        tried=int(found["tried"]),
        not_tried=tuple(NotTried(**entry) for entry in found["not_tried"]),
        notes=tuple(found["notes"]),
    )


def _finding(finding: Json) -> Finding:
    return Finding(
        effect=finding["effect"],
        parameters={name: Estimate(**_numbers(values)) for name, values in finding["parameters"].items()},
        share=_number(finding["share"]),
        group=tuple(finding["group"]),
        separate_by=finding["separate_by"],
        provisional=finding["provisional"],
        fix=finding["fix"],
        log_spread=_numbers(finding["spread_over_logs"]),
        voltage=finding.get("full_battery"),
        probability=finding.get("probability"),
    )


def _stage(stage: Json) -> Stage:
    rows = {
        float(row["horizon"]): {name: StageError(**_numbers(error)) for name, error in row["errors"].items()}
        for row in stage["horizons"]
    }
    return Stage(stage["model"], rows)


def _floor(floor: Json) -> Floor:
    errors = {name: (_number(error["value"]), error["unit"]) for name, error in floor["errors"].items()}
    return Floor(float(floor["horizon"]), errors)


def _gate(gate: Json | None) -> Gate:
    if gate is None:
        return Gate()
    ends = (_stage({"model": end, "horizons": gate[end]}) for end in ("before", "after"))
    return Gate(*(replace(end, foretells=gate.get("foretold", True)) for end in ends))


def _numbers(values: Json) -> dict[str, Any]:
    """Numbers where JSON has null for those that it lacks, and units as they are."""
    return {name: value if isinstance(value, str) else _number(value) for name, value in values.items()}


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)
