"""What a log seems to hold: a proposed specification, with the evidence for every column.

Nothing is taken for granted that the numbers can tell: degrees by size and by the slope of the attitude, component
order by the vertical, signs by correlation. A sign that looks reversed stays as recorded; the proposal carries it as
a commented line with its evidence.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType

from sym2real.errors import DataError
from sym2real.layout import Layouts, motors_of
from sym2real.logs import spec_text
from sym2real.logs.assignment import Assignment, assign, within
from sym2real.logs.draft import Draft, Finding
from sym2real.logs.dropouts import is_slow, without_dropouts, without_held, without_repeats
from sym2real.logs.inspect_attitude import inspect_attitudes
from sym2real.logs.inspect_columns import inspect_columns
from sym2real.logs.inspect_commands import inspect_commands
from sym2real.logs.inspect_heading import inspect_yaw
from sym2real.logs.inspect_joints import inspect_joints
from sym2real.logs.inspect_motion import inspect_positions, inspect_rates, inspect_velocities, inspect_wheel
from sym2real.logs.inspect_time import inspect_time
from sym2real.logs.inspect_upright import inspect_upright
from sym2real.logs.joint_names import Matching, match_own
from sym2real.logs.odd_units import in_other_units
from sym2real.logs.reader import expand
from sym2real.logs.several_files import files_by_log, read_parts
from sym2real.logs.specification import LogSpec
from sym2real.logs.table import Table
from sym2real.vocabulary import POSITION

FEWEST_ROWS, FEWEST_LOGS = 20, 3
NOTHING: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True)
class Inspection:
    """What logs seem to hold.

    Args:
        paths: the logs.
        spec: the proposed specification.
        rows: one finding per column and more on the whole, in the order of the log's columns.
        comments: lines of the TOML text, by the key that they follow.
    """

    paths: tuple[Path, ...]
    spec: LogSpec
    rows: tuple[Finding, ...]
    comments: dict[str, tuple[str, ...]]

    @property
    def suspected_flips(self) -> tuple[str, ...]:
        """Columns whose sign looks reversed."""
        return tuple(row.column for row in self.rows if row.meaning.startswith("sign suspected"))

    @property
    def waiting(self) -> bool:
        """Whether a user must fill in lines before logs can be read by it: a model's columns, rows a second."""
        open_lines = (line for lines in self.comments.values() for line in lines)
        return self.spec.time.rate == 0.0 or any('"…"' in line for line in open_lines)

    def toml(self) -> str:
        """The proposal as TOML, with the evidence as comments and suspected flips commented out."""
        return spec_text.specification(self.spec, self.comments)


def inspect_logs(
    paths: str | Path | Iterable[str | Path],
    columns: Sequence[str] = (),
    layouts: Layouts | None = None,
    moved: Mapping[str, str] = NOTHING,
    endless: Collection[str] = (),
) -> Inspection:
    """Look into logs of one kind (the same columns); a folder stands for the logs in it.

    Args:
        paths: of the logs; files without a common column but stamps are parts of one.
        columns: names of the columns of text files that have no header.
        layouts: of the model whose logs they are: its own columns, such as those of joints, are looked for, and no
            others.
        moved: joint that an action of the model moves, as far as that is known: ``robot.moved``.
        endless: joints of the model without stops within a turn, or some metres.

    Raises:
        DataError: when a file cannot be read, is too short, or has other columns than the first.

    Examples:
        >>> inspect_logs(example_flight()).spec.time.column
        't'
    """
    logs = files_by_log(expand(paths), columns)
    tables = [read_parts(files, header=columns) for files in logs]
    _check_alike(tables)
    look = partial(_looked_into, layouts=layouts, moved=moved, endless=endless)
    draft = look(tables)
    if others := in_other_units([look([table]) for table in tables]) if len(tables) >= FEWEST_LOGS else {}:
        draft = look([table for place, table in enumerate(tables) if place not in others])
        for place, units in others.items():
            for (column, meaning), (unit, usual) in units.items():
                where = f"{tables[place].path.name} alone, all others in {usual}: it needs a specification of its own"
                draft.add(column, meaning, unit, f"in {where}", "certain")
    what = "a robot" if layouts is not None else _kind(draft)
    return _finished(tuple(file for files in logs for file in files), draft, tuple(columns), what)


def _looked_into(
    tables: list[Table], layouts: Layouts | None, moved: Mapping[str, str], endless: Collection[str]
) -> Draft:
    assignment, matching = _assigned(list(tables[0].columns), layouts, moved)
    draft = _draft(tables, assignment)
    inspect_time(draft)
    inspect_upright(draft)
    inspect_positions(draft)
    inspect_yaw(draft)
    inspect_attitudes(draft)
    inspect_wheel(draft)
    inspect_velocities(draft)
    inspect_rates(draft)
    inspect_commands(draft)
    if layouts is not None:
        inspect_joints(draft, matching, layouts, endless)
    inspect_columns(draft, of_model=layouts is not None)
    return draft


def _assigned(names: Sequence[str], layouts: Layouts | None, moved: Mapping[str, str]) -> tuple[Assignment, Matching]:
    """Which column of the model, or of all standard ones, each column of a log may be."""
    if layouts is None:
        return assign(names), Matching()
    matching = match_own(names, layouts, moved)
    own = {column: match.source for column, match in matching.pairs.items()}
    rotors = len(motors_of(layouts.action)) or 4
    rest = within(assign([name for name in names if name not in own.values()], rotors), layouts)
    return replace(rest, columns={**rest.columns, **own}), matching


def _draft(tables: list[Table], assignment: Assignment) -> Draft:
    """The logs without the rows in which something is missing, slower columns held; rows are those of positions."""
    places = [assignment.columns[name] for name in POSITION.columns if name in assignment.columns]
    tables, stand = map(list, zip(*(without_held(table, places) for table in tables), strict=True))
    slow = {name for table in tables for name, values in table.columns.items() if is_slow(values)}
    # Stamps are not held: they would stand.
    assignment = replace(assignment, times=[name for name in assignment.times if name not in slow])
    parts = [*assignment.quaternions.values(), *assignment.angles.values()]
    used = [*assignment.times, *assignment.columns.values(), *(column for part in parts for column in part.values())]
    held = [name for name in used if name in slow and name not in places]
    stamp = next(iter(assignment.times), "")
    once, repeats = zip(*(without_repeats(table, stamp) for table in tables), strict=True)
    whole, dropouts = zip(*(without_dropouts(table, used, held, places=places) for table in once), strict=True)
    notes = [sum(parts, ()) for parts in zip(stand, repeats, dropouts, strict=True)]
    for table, remarks in zip(whole, notes, strict=True):
        _require_rows(table, remarks)
    draft = Draft(list(whole), assignment, tuple(held))
    if slow.intersection(places):
        draft.kept = sum(map(len, whole)) / sum(map(len, once))
    for table, remarks in zip(tables, notes, strict=True):
        for note in remarks:
            draft.add("", "rows left out", "", f"{table.path.name}: {note}", "certain")
    for name in held:
        draft.add(name, "held", "", "slower than the others: the last number stands where a cell is empty", "likely")
    return draft


def _require_rows(table: Table, remarks: Sequence[str] = ()) -> None:
    if len(table) < FEWEST_ROWS:
        actual = "; ".join((str(len(table)), *remarks))
        raise DataError(table.path, f"at least {FEWEST_ROWS} rows with numbers to look into", actual)


def _check_alike(tables: list[Table]) -> None:
    for table in tables:
        _require_rows(table)
        different = set(table.columns) ^ set(tables[0].columns)
        if different:
            expected = f"the same columns as {tables[0].path.name}"
            raise DataError(table.path, expected, f"a difference in {', '.join(sorted(different))}")


def _kind(draft: Draft) -> str:
    return "a car" if draft.assignment.is_car else "a flying robot" if "attitude" in draft.attitudes else "a robot"


def _finished(files: tuple[Path, ...], draft: Draft, header: tuple[str, ...], what: str) -> Inspection:
    comments = {key: tuple(lines) for key, lines in draft.comments.items()}
    if draft.flips:
        lines = [f"suspected: {column}: {evidence}" for column, evidence in draft.flips.items()]
        instead = "in place of the line above: " if draft.reversed else ""
        comments["flip"] = (f"{instead}flip = {spec_text.text([*draft.reversed, *draft.flips])}", *lines)
    comments[""] = (
        f"Proposed by 'sym2real inspect' from {', '.join(path.name for path in files)}.",
        f"Signs are as recorded{', but for those in flip' if draft.reversed else ''}. "
        "Lines that start with '# key =' are suspicions: take the # away to accept one.",
    )
    spec = draft.specification()
    if draft.waiting:
        comments["hold"] = (f"hold = {spec_text.text([*spec.hold, *draft.waiting])}  # with the lines of these, below",)
    order = {name: i for i, name in enumerate(draft.tables[0].columns)}
    rows = sorted(draft.findings, key=lambda finding: order.get(finding.column, -1))
    return Inspection(files, replace(spec, title=f"log of {what}", header=header), tuple(rows), comments)
