"""How to read a foreign log: which of its columns is which standard column, in which unit, frame and order.

A specification is a TOML file::

    name = "my_drone"
    drop_first = 1                          # rows to leave out at the start
    # flip = ["gyro.y"]                     # columns of the log whose sign is reversed

    [time]
    column = "timestamp"
    unit = "us"
    dt = 0.02                               # s, what the log is resampled to where the model does not say

    [columns]                               # standard column = column of the log
    x = "pose.x"
    wx = { column = "gyro.x", unit = "deg/s" }
    ref_x = "ctrltarget.x"

    [attitude]
    quaternion = ["q0", "q1", "q2", "q3"]
    order = "wxyz"

Standard names are those of :data:`sym2real.vocabulary.VOCABULARY`, ``yaw`` (which becomes sine and cosine) and
``ref_`` before any of them. A column of the log that has its standard name already need not be listed.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from sym2real.errors import DataError, UnknownNameError, reason
from sym2real.field import is_name
from sym2real.files import meant, read_text, require_file, write_text
from sym2real.logs import spec_text
from sym2real.logs.parts import ATTITUDES, STANDARD_COLUMNS, Attitude, Derived, Frames, Source, TimeBase, VelocityFrame
from sym2real.logs.units import factor
from sym2real.registry import Registry
from sym2real.toml_tables import Count, Positive, of_kind


@dataclass(frozen=True)
class LogSpec:
    """What the columns of a foreign log mean; see the module's text for the TOML form.

    Args:
        name: what to call it.
        title: one line on the logs it is for.
        time: stamps or rate.
        columns: standard column → where it comes from.
        attitude: measured attitude.
        attitude_command: commanded attitude.
        reference_attitude: wanted attitude.
        drop_first: rows to leave out at the start.
        drop_last: rows to leave out at the end.
        flip: columns of the log whose sign is reversed.
        hold: columns of the log whose last number stands where a cell is empty; a row without numbers in another
            one is left out.
        derive: what the log has not and is computed: "velocity" from positions, "rate" from the attitude or yaw.
        velocity_frame: "world" or "body", the axes of vx, vy, vz in the log.
        frames: "z_up" (world z up, body forward-left-up) or "ned_frd" (north-east-down, forward-right-down).
        mass: kg, multiplies a thrust that is logged per unit mass.
        header: names of the columns, in their order, of text files that have no header.

    Examples:
        >>> LogSpec(name="mine", velocity_frame="body", derive=("rate",)).frames
        'z_up'
    """

    name: str = "unnamed"
    title: str = ""
    time: TimeBase = field(default_factory=TimeBase)
    columns: Mapping[str, Source] = field(default_factory=dict)
    attitude: Attitude = field(default_factory=Attitude)
    attitude_command: Attitude = field(default_factory=Attitude)
    reference_attitude: Attitude = field(default_factory=Attitude)
    drop_first: Count = 0
    drop_last: Count = 0
    flip: tuple[str, ...] = ()
    hold: tuple[str, ...] = ()
    derive: tuple[Derived, ...] = ()
    velocity_frame: VelocityFrame = "world"
    frames: Frames = "z_up"
    mass: Positive = 1.0
    header: tuple[str, ...] = ()

    @property
    def sources(self) -> tuple[str, ...]:
        """Every column of the log that the specification names."""
        attitudes = (self.attitude, self.attitude_command, self.reference_attitude)
        time = (self.time.column,) if self.time.column else ()
        return (
            *time,
            *(source.column for source in self.columns.values()),
            *(column for attitude in attitudes for column in attitude.sources),
        )

    def toml(self) -> str:
        """The specification as a TOML text that :meth:`parse` reads back."""
        return spec_text.specification(self)

    @classmethod
    def parse(cls, text: str, file: str | Path = "log specification") -> LogSpec:
        """Specification from a TOML text.

        Raises:
            DataError: naming ``file``, the key, what was expected and what was found.
        """
        try:
            table = tomllib.loads(text)
        except (ValueError, RecursionError) as error:
            raise DataError(file, "TOML", reason(error)) from None
        if isinstance(table.get("columns"), dict):
            table["columns"] = {name: _source(file, name, value) for name, value in table["columns"].items()}
        if isinstance(time := table.get("time"), dict) and "rate" in time:
            time.setdefault("column", "")
        spec = of_kind(file, table, cls)
        if bool(spec.time.column) == (spec.time.rate is not None):
            raise DataError(file, "in [time] either a column or a rate", "both" if spec.time.column else "neither")
        for name, source in spec.columns.items():
            try:
                factor(source.unit, name)
            except UnknownNameError as error:
                raise DataError(file, "a unit that fits", str(error), column=name) from None
        for name in (name for name in ATTITUDES if name in table):
            attitude = getattr(spec, name)
            if (len(attitude.quaternion), len(attitude.euler)) not in {(4, 0), (2, 0), (0, 3)}:
                expected = f"in [{name}] a quaternion of 4 columns, or of 2 (w, z), or euler with 3 (roll, pitch, yaw)"
                raise DataError(file, expected, f"{len(attitude.quaternion)} and {len(attitude.euler)}")
        _check_uses(file, spec)
        return spec

    @classmethod
    def load(cls, path: str | Path) -> LogSpec:
        """Specification from a TOML file.

        Raises:
            DataError: when the file is not there or its content cannot be used.
        """
        require_file(path)
        return cls.parse(read_text(path, "a readable TOML file"), path)

    def save(self, path: str | Path) -> None:
        """Write the specification as TOML."""
        write_text(path, self.toml())


def _source(file: str | Path, name: str, value: object) -> Mapping[str, Any]:
    """The table of a column; a text alone names the column of the log."""
    if not is_name(name):
        raise DataError(file, "in columns names of letters, digits and _", f"{name!r:.80}")
    if isinstance(value, str):
        return {"column": value}
    if not isinstance(value, dict) or "column" not in value:
        raise DataError(file, f'{name} = "column" or {{ column = …, unit = … }}', repr(value), column=name)
    return value


def _check_uses(file: str | Path, spec: LogSpec) -> None:
    """Refuse a column of the log that stands for two things, and remarks on one that stands for nothing."""
    uses = [(source.column, f"columns.{name}") for name, source in spec.columns.items()]
    uses += [(column, name) for name in ATTITUDES for column in getattr(spec, name).sources]
    sources = [column for column, _ in uses]
    for key in ("flip", "hold"):
        for name in getattr(spec, key):
            if name not in sources and name not in STANDARD_COLUMNS:
                raise DataError(file, f"in {key} a column that exists", str(UnknownNameError("column", name, sources)))
    uses += [(spec.time.column, "time.column")] if spec.time.column else []
    first: dict[str, str] = {}
    for column, use in uses:
        if column in first:
            raise DataError(file, "every column of the log once", f"{column!r} for {first[column]} and {use}")
        first[column] = use


_SHIPPED = sorted((Path(__file__).parent / "specs").glob("*.toml"))
SPECS: Registry[LogSpec] = Registry("log specification", {path.stem: LogSpec.load(path) for path in _SHIPPED})


def load_spec(name: LogSpec | str | Path) -> LogSpec:
    """A shipped specification by its name in :data:`SPECS`, or one from a TOML file by its path.

    One without a name of its own goes by that of its file; one that is loaded already comes back.

    Raises:
        DataError: when the file cannot be used.
        UnknownNameError: when it is neither.
    """
    if isinstance(name, LogSpec):
        return name
    if Path(name).suffix == ".toml":
        spec = LogSpec.load(name)
        return spec if spec.name != LogSpec.name else replace(spec, name=Path(name).stem)
    if str(name) not in SPECS:
        if Path(name).suffix or len(Path(name).parts) > 1:
            raise DataError(name, "a specification that ends in .toml", f"{Path(name).suffix!r}{meant(Path(name))}")
        raise UnknownNameError("log specification", str(name), [*SPECS, "FILE.toml"])
    return SPECS[str(name)]
