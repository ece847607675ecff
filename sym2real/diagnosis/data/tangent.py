"""States as tangent vectors: where every field and column stands in them, and a log in them."""

from __future__ import annotations

from itertools import accumulate

import torch

from sym2real.layout import Layout
from sym2real.trajectory import Array, Trajectory


def places_of_fields(layout: Layout) -> list[range]:
    """Places of every field's components in the tangent, field by field."""
    sizes = [field.tangent_size for field in layout.fields]
    return [range(end - size, end) for end, size in zip(accumulate(sizes), sizes, strict=True)]


def places_of_columns(layout: Layout) -> dict[str, int]:
    """Place in the tangent of every column that has a component of its own: those of vector fields."""
    fields = zip(layout.fields, places_of_fields(layout), strict=True)
    vectors = [zip(field.columns, places, strict=True) for field, places in fields if field.kind == "vector"]
    return {column: place for columns in vectors for column, place in columns}


def tangents(trajectory: Trajectory) -> Array:
    """States as tangent vectors from the first, added up step by step ``# (rows - 1, tangent)``."""
    states = torch.as_tensor(trajectory.state)
    return trajectory.layouts.state.difference(states[1:], states[:-1]).cumsum(0).numpy()
