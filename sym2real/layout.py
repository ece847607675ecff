"""What the columns of an array mean: names, units, frames, and the manifold they live on.

A layout is the one owner of the manifold. Quaternions (w x y z, body→world) and unit circles (sine, cosine)
are columns like any others; :meth:`Layout.normalise`, :meth:`Layout.difference` and :meth:`Layout.retract`
know that they are not.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate
from typing import Any, get_args

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sym2real import rotation
from sym2real.errors import ShapeError, UnknownNameError
from sym2real.field import Field, Group, Kind, read_fields
from sym2real.vocabulary import MOTOR_COLUMNS, POSITION, RATE, VOCABULARY, is_push, known_field, rate_column


def motors_of(action: Layout) -> tuple[str, ...]:
    """Columns of the rotors that are commanded; none of a robot that is commanded otherwise."""
    return tuple(column for column in action if column in MOTOR_COLUMNS)


def turned_by_motors(layouts: Layouts) -> bool:
    """Whether single motors are commanded, and the rates that their torques change are part of the state."""
    return bool(motors_of(layouts.action)) and RATE.columns[0] in layouts.state


def unit_of_place(state: Layout) -> str:
    """Unit of a distance between where robots with this state are; several units as they come."""
    return ", ".join(dict.fromkeys(field.unit for field in state.placing))


@dataclass(frozen=True)
class Layout:
    """An ordered list of fields, and with it of columns.

    Raises:
        ShapeError: when a column name stands twice.

    Examples:
        >>> Layout.of(["x", "y", "vx"]).units
        {'x': 'm', 'y': 'm', 'vx': 'm/s'}
    """

    fields: tuple[Field, ...] = ()

    def __post_init__(self) -> None:
        repeated = {column for column in self.columns if self.columns.count(column) > 1}
        if repeated:
            raise ShapeError(f"column names stand more than once in a layout: {sorted(repeated)}")

    @classmethod
    def of(cls, columns: Iterable[str]) -> Layout:
        """Layout of standard column names, with units, frames and kinds from :data:`VOCABULARY`.

        A name outside the vocabulary becomes a dimensionless field of its own.
        """
        groups: list[tuple[Field, list[str]]] = []
        for column in columns:
            field = known_field(column)
            if groups and groups[-1][0] == field:
                groups[-1][1].append(column)
            else:
                groups.append((field, [column]))
        return cls(tuple(replace(field, columns=tuple(names)) for field, names in groups))

    @cached_property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns, in order."""
        return tuple(column for field in self.fields for column in field.columns)

    @cached_property
    def units(self) -> dict[str, str]:
        """Column → its unit."""
        return {column: field.unit for field in self.fields for column in field.columns}

    @property
    def size(self) -> int:
        """Number of columns."""
        return len(self.columns)

    @cached_property
    def tangent_size(self) -> int:
        """Number of tangent components: a quaternion has three, a unit circle one."""
        return sum(field.tangent_size for field in self.fields)

    @cached_property
    def _positions(self) -> dict[str, int]:
        return {column: position for position, column in enumerate(self.columns)}

    def __len__(self) -> int:
        return self.size

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __contains__(self, column: object) -> bool:
        return column in self._positions

    def index(self, column: str) -> int:
        """Position of a column.

        Raises:
            UnknownNameError: when the layout has no such column.
        """
        try:
            return self._positions[column]
        except KeyError:
            raise UnknownNameError("column", column, self.columns) from None

    def indices(self, columns: Iterable[str]) -> list[int]:
        """Positions of several columns, in the order given."""
        return [self.index(column) for column in columns]

    def field(self, name: str) -> Field:
        """The field of that name.

        Raises:
            UnknownNameError: when the layout has no such field.
        """
        for field in self.fields:
            if field.name == name:
                return field
        raise UnknownNameError("field", name, (field.name for field in self.fields))

    def has_field(self, name: str) -> bool:
        """Whether there is a field of that name."""
        return any(field.name == name for field in self.fields)

    @cached_property
    def tangent_places(self) -> tuple[range, ...]:
        """Places of every field's components in the tangent, field by field."""
        sizes = [field.tangent_size for field in self.fields]
        return tuple(range(end - size, end) for end, size in zip(accumulate(sizes), sizes, strict=True))

    @cached_property
    def vector_places(self) -> dict[str, int]:
        """Place in the tangent of every column that has a component of its own: those of vector fields."""
        fields = zip(self.fields, self.tangent_places, strict=True)
        vectors = [zip(field.columns, places, strict=True) for field, places in fields if field.kind == "vector"]
        return {column: place for columns in vectors for column, place in columns}

    @cached_property
    def rates(self) -> dict[str, str]:
        """Coordinate → the column of its rate, for coordinates that have one: of position and of joints."""
        vectors = (column for field in self.fields if field.kind == "vector" for column in field.columns)
        return {column: rate_column(column) for column in vectors if rate_column(column) in self}

    @cached_property
    def joints(self) -> tuple[str, ...]:
        """Coordinates of joints: those that have a rate and are no position."""
        return tuple(column for column in self.rates if column not in POSITION.columns)

    @cached_property
    def pushes(self) -> tuple[str, ...]:
        """Columns of forces and torques, on a body or along joints."""
        return tuple(column for column in self if is_push(column))

    @cached_property
    def placing(self) -> tuple[Field, ...]:
        """Fields that say where a robot is: its position, the coordinates of its joints, or all that logs hold."""
        if self.has_field(POSITION.name):
            return (self.field(POSITION.name),)
        joints = tuple(field for field in self.fields if {*field.columns} & {*self.joints})
        return joints or tuple(field for field in self.fields if not field.hidden)

    def slice(self, name: str) -> slice:
        """Columns of a field as a slice of the last dimension."""
        start = self.index(self.field(name).columns[0])
        return slice(start, start + len(self.field(name).columns))

    def __add__(self, other: Layout) -> Layout:
        return Layout(self.fields + other.fields)

    def _parts(self, values: Tensor) -> list[Tensor]:
        if values.shape[-1] != self.size:
            raise ShapeError(f"expected {self.size} columns {self.columns}, found {values.shape[-1]}")
        return list(values.split([len(field.columns) for field in self.fields], dim=-1))

    def normalise(self, values: Tensor) -> Tensor:
        """Values ``# (..., size)`` put back on the manifold: unit quaternions and circles."""
        parts = [
            part if field.kind == "vector" else rotation.normalise(part)
            for field, part in zip(self.fields, self._parts(values), strict=True)
        ]
        return torch.cat(parts, dim=-1) if parts else values

    def difference(self, end: Tensor, start: Tensor) -> Tensor:
        """Tangent vector ``# (..., tangent_size)`` that leads from ``start`` to ``end``.

        A quaternion gives the rotation vector in the body axes of ``start`` (rad), a circle its angle (rad).
        """
        parts = [
            _difference(field.kind, a, b).movedim(-1, 0)
            for field, a, b in zip(self.fields, self._parts(end), self._parts(start), strict=True)
        ]
        return torch.cat(parts).movedim(0, -1)

    def over_steps(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """Of the rows of a log ``# (rows, size)`` what acts until the next one: held, directions halfway to that one.

        A command stays as it was sent; an attitude or a heading that was measured turns.
        """
        now = torch.as_tensor(rows)
        pairs = zip(self.fields, self._parts(now), self._parts(torch.cat([now[1:], now[-1:]])), strict=True)
        parts = [
            a if field.kind == "vector" else _retract(field.kind, a, _difference(field.kind, b, a) / 2)
            for field, a, b in pairs
        ]
        return np.asarray(torch.cat(parts, dim=-1)) if parts else rows

    def retract(self, start: Tensor, tangent: Tensor) -> Tensor:
        """The point that a tangent vector leads to; inverse of :meth:`difference`."""
        if tangent.shape[-1] != self.tangent_size:
            raise ShapeError(f"expected a tangent of size {self.tangent_size}, found {tangent.shape[-1]}")
        steps = tangent.split([field.tangent_size for field in self.fields], dim=-1)
        parts = [
            _retract(field.kind, a, step) for field, a, step in zip(self.fields, self._parts(start), steps, strict=True)
        ]
        return torch.cat(parts, dim=-1)


def _difference(kind: Kind, end: Tensor, start: Tensor) -> Tensor:
    if kind == "quaternion":
        return rotation.logarithm(rotation.multiply(rotation.conjugate(start), end))
    if kind == "circle":
        (s1, c1), (s0, c0) = end.unbind(-1), start.unbind(-1)
        return torch.atan2(s1 * c0 - c1 * s0, c1 * c0 + s1 * s0)[..., None]
    return end - start


def _retract(kind: Kind, start: Tensor, step: Tensor) -> Tensor:
    if kind == "quaternion":
        return rotation.multiply(start, rotation.exponential(step))
    if kind == "circle":
        (s, c), (ds, dc) = start.unbind(-1), (step[..., 0].sin(), step[..., 0].cos())
        return torch.stack([s * dc + c * ds, c * dc - s * ds], dim=-1)
    return start + step


@dataclass(frozen=True)
class Layouts:
    """The three column groups of a model, a plant or a log.

    Examples:
        >>> Layouts.of(["x", "y", "vx", "vy", "steer"]).action.columns
        ('steer',)
    """

    state: Layout
    action: Layout
    inputs: Layout = Layout()

    @property
    def groups(self) -> dict[Group, Layout]:
        """The layouts by the names of their groups."""
        return {"state": self.state, "action": self.action, "inputs": self.inputs}

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns of all groups."""
        return (*self.state, *self.action, *self.inputs)

    @property
    def units(self) -> dict[str, str]:
        """Column → its unit, in all groups."""
        return {**self.state.units, **self.action.units, **self.inputs.units}

    def with_input(self, column: str) -> Layouts:
        """With one more input, last; as they are where they have it."""
        return self if column in self.inputs else replace(self, inputs=self.inputs + Layout.of((column,)))

    def to_dict(self) -> dict[str, list[dict[str, Any]]]:
        """The fields of every group, as JSON holds them."""
        return {group: [vars(field) for field in layout.fields] for group, layout in self.groups.items()}

    @classmethod
    def from_dict(cls, entries: Mapping[Group, Sequence[Mapping[str, Any]]]) -> Layouts:
        """What :meth:`to_dict` gave.

        Raises:
            KeyError, ValueError: when it is something else.
        """
        return cls(*(Layout(read_fields(entries[group])) for group in get_args(Group)))

    @classmethod
    def of(cls, columns: Iterable[str]) -> Layouts:
        """Layouts of standard columns, in the order and the groups of :data:`VOCABULARY`; other names are left out.

        Examples:
            >>> Layouts.of(["speed", "steer", "vx", "vy", "x", "y"]).state.columns
            ('x', 'y', 'vx', 'vy')
        """
        present = set(columns)
        groups: dict[str, Layout] = {
            group: Layout.of(
                column
                for where, field in VOCABULARY
                if where == group
                # A quaternion or a circle is whole or it is none.
                and (field.kind == "vector" or present.issuperset(field.columns))
                for column in field.columns
                if column in present
            )
            for group in get_args(Group)
        }
        return cls(**groups)
