"""What the candidate terms are made of: the columns of a step, and sine and cosine of declared angles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from sym2real.dataset import Transitions
from sym2real.errors import ShapeError
from sym2real.layout import Layouts
from sym2real.regression.monomials import Monomials
from sym2real.regression.numeric import columns_of
from sym2real.trajectory import Array

# The clock causes nothing: an equation in it would hold for one episode only.
NOT_A_CAUSE = ("t",)
# Of q·q′: below it a step turns by more than 90° (a quaternion) and the scaled target would blow up.
SMALLEST_ALONG = 0.7


def tangent_scale(transitions: Transitions, columns: Sequence[str]) -> Array:
    """What takes the next quaternion or unit circle to the tangent at the one before ``# (rows,)``.

    Models put both back on their manifold after every step, so an equation may give q′ times any positive number. Of
    all these, q′ / (q·q′) is nearest to q: it leaves out the second-order terms along q, which are the most of those
    that a turn needs.
    """
    places = transitions.layouts.state.indices(columns)
    before, after = transitions.state[:, places], transitions.next_state[:, places]
    along = np.einsum("rc,rc->r", before, after)
    if not (np.abs(along) > SMALLEST_ALONG).all():
        return np.ones(len(along))
    scale: Array = np.einsum("rc,rc->r", before, before) / along
    return scale


@dataclass(frozen=True)
class Variables:
    """The variables that equations may contain, in the order of the columns of :func:`values_of`.

    Args:
        columns: columns of state, action and inputs that are variables by themselves.
        angles: columns whose sine and cosine are variables too (rad).
        wrench: wrench columns; they stand last.
        quaternions: for every quaternion, the names of its four columns.
    """

    columns: tuple[str, ...]
    angles: tuple[str, ...]
    wrench: tuple[str, ...]
    quaternions: tuple[tuple[str, ...], ...]

    @classmethod
    def of(cls, layouts: Layouts, angles: Sequence[str] = (), cyclic: Sequence[str] = ()) -> Variables:
        """Variables of these layouts, without the coordinates that nothing depends on.

        Raises:
            ShapeError: when an angle is not a column in rad.
        """
        everything = layouts.state + layouts.action + layouts.inputs
        for angle in angles:
            if everything.units[everything.columns[everything.index(angle)]] != "rad":
                raise ShapeError(f"angle {angle!r} must be a column in rad, its unit is {everything.units[angle]!r}")
        wrench = layouts.inputs.pushes
        columns = tuple(column for column in everything if column not in (*wrench, *cyclic, *NOT_A_CAUSE))
        quaternions = tuple(field.columns for field in everything.fields if field.kind == "quaternion")
        return cls(columns, tuple(angles), wrench, quaternions)

    @property
    def plain(self) -> int:
        """Number of variables that are no wrench."""
        return len(self.columns) + 2 * len(self.angles)

    def values_of(self, transitions: Transitions) -> Array:
        """Values of the variables ``# (rows, variables)``: columns, sines, cosines, wrench."""
        known = columns_of(transitions)
        plain, angles, wrench = ([known[name] for name in names] for names in (self.columns, self.angles, self.wrench))
        return np.stack([*plain, *map(np.sin, angles), *map(np.cos, angles), *wrench], axis=1)

    def products(self, degree: int) -> Monomials:
        """Every product of at most so many variables that are no wrench."""
        plain = Monomials.to_degree(self.plain, degree).powers
        return Monomials(np.pad(plain, ((0, 0), (0, len(self.wrench)))))

    @property
    def multipliers(self) -> Monomials:
        """What terms grow by: a variable that is no wrench, or two columns of one quaternion."""
        size = self.plain + len(self.wrench)
        single = np.eye(size, dtype=np.int64)[: self.plain]
        pairs = [
            single[self.columns.index(first)] + single[self.columns.index(other)]
            for names in self.quaternions
            for first, other in combinations_with_replacement(names, 2)
        ]
        return Monomials.of([*single.tolist(), *pairs], size)

    def signs(self, powers: NDArray[np.int64]) -> NDArray[np.int64]:
        """Whether each product changes sign with each quaternion: 1 or 0 ``# (terms, quaternions)``.

        q and −q are one attitude, so an equation for a quaternion must be odd in it and any other even. Fitting
        on rows repeated with −q and −q′ gives every term of the wrong sign the coefficient zero; leaving such
        terms out is the same fit on half the rows and half the candidates.
        """
        parities = [powers[:, [self.columns.index(c) for c in names]].sum(axis=1) % 2 for names in self.quaternions]
        return np.stack(parities, axis=1) if parities else np.zeros((len(powers), 0), dtype=np.int64)

    def sign_of(self, column: str) -> NDArray[np.int64]:
        """The sign pattern that the equation of a state column must have ``# (quaternions,)``."""
        return np.array([int(column in names) for names in self.quaternions], dtype=np.int64)
