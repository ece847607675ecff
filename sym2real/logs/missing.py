"""What a log lacks for a model: every column at once, with its unit, and what may be done about it."""

import difflib
import shlex
from collections.abc import Collection, Iterable
from itertools import groupby
from pathlib import Path

from sym2real.errors import DataError
from sym2real.layout import Layouts
from sym2real.vocabulary import ATTITUDE, HEADING, POSITION, RATE, VELOCITY

FRAME = Path("data frame")  # what errors call a log that is no file
# A name that is as close as `Motor1` to `motor1`; `x` for `vx` and `wx` for `wx_cmd` are other quantities.
CLOSE = 0.75
MOST_NAMED = 12  # of a list
# Field that only one way to command a quadrotor has → a column of it, its words, its `nominal quadrotor --interface`.
INTERFACES = {
    "motors": ("motor1", "motors", "motors"),
    "rate command": ("wx_cmd", "thrust and rate commands", "thrust_rates"),
    "attitude command": ("qw_cmd", "thrust and attitude commands", "thrust_attitude"),
}
# What a specification can derive → the columns, and those that it is computed from.
DERIVED = (
    ("velocity", VELOCITY.columns, {*POSITION.columns[:2]}),
    ("rate", RATE.columns, {*ATTITUDE.columns}),
    ("rate", ("wz",), {*HEADING.columns}),
)


def require_columns(file: str | Path, standard: Collection[str], others: Collection[str], layouts: Layouts) -> None:
    """Refuse a log without the columns of a model.

    Args:
        file: of the log.
        standard: standard columns that it has.
        others: its further columns, by their own names.
        layouts: columns that the model has. Time and pushes that nobody applied need not be in a log.

    Raises:
        DataError: naming every missing column with its unit, columns that may be meant, and what else helps.
    """
    units = layouts.units
    given = {"t", *layouts.inputs.pushes}
    missing = [name for name in units if name not in {*standard, *others, *given}]
    if not missing:
        return
    there = [*standard, *others]
    hints = [*_close(missing, others), *_other_interface(layouts, standard)]
    hints += [*_on_the_ground(missing, standard), *_derivable(missing, standard, layouts)]
    if others:
        hints += [f'`{missing[0]} = "…"` under [columns] of the specification names it', specification(file, layouts)]
    actual = "; ".join((f"only {listed(there)}", *hints))
    raise DataError(file, f"columns of the model: {_with_units(missing, units)}", actual)


def listed(names: Collection[str]) -> str:
    """Names for a sentence, the first of many."""
    more = f" … ({len(names)} in all)" if len(names) > MOST_NAMED else ""
    return ", ".join(list(names)[:MOST_NAMED]) + more


def specification(file: str | Path, layouts: Layouts | None = None) -> str:
    """How a file, or a data frame, whose columns have names of their own is read; of a model with joints by that."""
    if file == FRAME:
        return (
            "where columns have names of their own, a specification says what they are: inspect_logs proposes one for "
            "the same log as a file, and spec=… reads the frame by it"
        )
    spec = f"{Path(file).stem}.toml"
    of_model = " --model MODEL" if layouts is not None and layouts.state.joints else ""
    command = f"sym2real inspect {shlex.quote(str(file))}{of_model} --out {shlex.quote(spec)}"
    return (
        "where a file names its columns its own way, a specification says what they are: "
        f"`{command}` proposes one, and --spec {shlex.quote(spec)} reads the log by it"
    )


def _with_units(names: Iterable[str], units: dict[str, str]) -> str:
    parts = [(unit, ", ".join(group)) for unit, group in groupby(names, units.__getitem__)]
    return ", ".join(columns if unit in ("", "1") else f"{columns} ({unit})" for unit, columns in parts)


def _close(missing: Iterable[str], others: Iterable[str]) -> list[str]:
    """One question a name that is much like a missing one, before others one with the same letters: q_cmd_w, qw_cmd."""
    lower, questions = {name.lower(): name for name in others}, []
    for name in missing:
        near = difflib.get_close_matches(name.lower(), lower, n=MOST_NAMED, cutoff=CLOSE)  # the closest first
        if near:
            nearest = min(near, key=lambda other: _letters(other) != _letters(name.lower()))
            questions.append(f"is {lower[nearest]!r} its {name}?")
    return questions


def _letters(name: str) -> list[str]:
    return sorted(name.replace("_", ""))


def _other_interface(layouts: Layouts, standard: Collection[str]) -> list[str]:
    wanted = [INTERFACES[field.name] for field in layouts.action.fields if field.name in INTERFACES]
    if not wanted or wanted[0][0] in standard:
        return []
    return [
        f"the log has {words} and the model takes {wanted[0][1]}: "
        f"`sym2real nominal quadrotor --interface {interface}` makes a model for it"
        for column, words, interface in INTERFACES.values()
        if column in standard
    ]


def _on_the_ground(missing: Collection[str], standard: Collection[str]) -> list[str]:
    """A body of an MJCF that moves freely is taken to fly."""
    if not ({POSITION.columns[2], *ATTITUDE.columns} <= {*missing} and {*HEADING.columns} <= {*standard}):
        return []
    planar = (*POSITION.columns[:2], *HEADING.columns, *VELOCITY.columns[:2], RATE.columns[2])
    return [f"`sym2real nominal mjcf … --state {' '.join(planar)}` makes a model of a robot that stays on the ground"]


def _derivable(missing: Collection[str], standard: Collection[str], layouts: Layouts) -> list[str]:
    joints = [("rate", (layouts.state.rates[joint],), {joint}) for joint in layouts.state.joints]
    derivable = [
        (what, ", ".join(columns))
        for what, columns, sources in (*DERIVED, *joints)
        if sources <= set(standard) and set(columns) & set(missing)
    ]
    together = {what: ", ".join(columns for other, columns in derivable if other == what) for what, _ in derivable}
    return [f'derive = ["{what}"] in a log specification computes {columns}' for what, columns in together.items()]
