"""Columns that belong together: their names, unit, frame, and the manifold they live on."""

import keyword
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Literal, get_args

import msgspec

from sym2real.errors import ShapeError, UnknownNameError

Kind = Literal["vector", "quaternion", "circle"]
Group = Literal["state", "action", "inputs"]

KINDS: tuple[Kind, ...] = get_args(Kind)
TANGENT_SIZE = {"quaternion": 3, "circle": 1}
COLUMNS_OF_KIND = {"quaternion": 4, "circle": 2}


def is_name(name: object) -> bool:
    """Whether a text can be a variable of generated Python and C: letters, digits and _, and no other spelling of it.

    Such names come from files and go into source, so this is where anything else ends.
    """
    return (
        isinstance(name, str)
        and name.isidentifier()
        and not keyword.iskeyword(name)
        and unicodedata.normalize("NFKC", name) == name
    )


@dataclass(frozen=True)
class Field:
    """Columns that belong together.

    Args:
        name: what they are together ("position").
        columns: one name per column.
        unit: SI unit of every column ("m", "rad/s", "1").
        frame: "world", "body" or "" where no frame applies.
        kind: "quaternion" (4 columns, w x y z), "circle" (2 columns, sine then cosine) or "vector".
        hidden: true for states that a log does not hold (motor lag); scores and costs never see them.

    Raises:
        ShapeError: for a kind that does not exist, a column that cannot be named in an expression, or too few of them.
    """

    name: str
    columns: tuple[str, ...]
    unit: str = "1"
    frame: str = ""
    kind: Kind = "vector"
    hidden: bool = False

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ShapeError(f"field {self.name!r}: expected the kind {' or '.join(KINDS)}, found {self.kind!r}")
        for column in self.columns:
            if not is_name(column):
                raise ShapeError(f"field {self.name!r}: expected columns of letters, digits and _, found {column!r}")
        wanted = COLUMNS_OF_KIND.get(self.kind, len(self.columns))
        if len(self.columns) != wanted:
            raise ShapeError(f"field {self.name!r}: expected {wanted} columns of a {self.kind}, found {self.columns}")

    @property
    def tangent_size(self) -> int:
        """Degrees of freedom: 3 for a quaternion, 1 for a circle, one per column else."""
        return TANGENT_SIZE.get(self.kind, len(self.columns))


def read_fields(entries: Sequence[Mapping[str, Any]]) -> tuple[Field, ...]:
    """The fields that a JSON file describes.

    Raises:
        UnknownNameError: for an entry that no field has.
        ValueError: for a value of another type, a missing one, or one that no field can have.
    """
    known = [field.name for field in fields(Field)]
    for name in (name for entry in entries for name in entry):
        if name not in known:
            raise UnknownNameError("entry of a field", name, known)
    return msgspec.convert(entries, tuple[Field, ...])


read_fields(())  # ahead of any thread: msgspec takes a class apart when it first meets it, no two threads at once
