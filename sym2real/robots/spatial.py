"""Spatial algebra (angular part first) over SymPy expressions, for equations of motion of trees of joints.

Source: R. Featherstone, "Rigid Body Dynamics Algorithms", Springer 2008, chapters 2, 5 and 6. Motions and forces are
arrays of six expressions, in the axes of a link; a transformation leads from a link's parent to the link.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from sympy import Expr, cos, sin

Values = Any  # NumPy array of expressions
Motion = Values  # angular and linear velocity, or acceleration # (6,)
Force = Values  # moment and force # (6,)
TINY = 1e-12


def exact(values: Any) -> Values:
    """Numbers as expressions, with what is zero but for rounding left out."""
    rounded = np.where(np.abs(values) < TINY, 0.0, values)
    return np.vectorize(lambda number: int(number) if float(number).is_integer() else float(number), otypes=[object])(
        rounded
    )


def cross(a: Values, b: Values) -> Values:
    """Vector product."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]], dtype=object)


def skew(a: Values) -> Values:
    """Matrix of the vector product with a."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]], dtype=object)


def about(axis: Values, angle: Expr) -> Values:
    """Matrix of axes turned by an angle about an axis of unit length (Rodrigues), from the turned to the plain ones."""
    turned = skew(axis)
    return np.eye(3, dtype=int).astype(object) + sin(angle) * turned + (1 - cos(angle)) * (turned @ turned)


@dataclass(frozen=True, eq=False)
class Transform:
    """From a parent's axes to a link's.

    Args:
        turn: matrix from the parent's axes to the link's ``# (3, 3)``.
        place: of the link's origin, in the parent's axes, m ``# (3,)``.
    """

    turn: Values
    place: Values

    def motion(self, motion: Motion) -> Motion:
        """A velocity or an acceleration of the parent, as the link's."""
        angular, linear = np.split(motion, 2)
        return np.concatenate([self.turn @ angular, self.turn @ (linear - cross(self.place, angular))])

    def force_back(self, force: Force) -> Force:
        """A moment and a force on the link, as on its parent."""
        moment, linear = (self.turn.T @ part for part in np.split(force, 2))
        return np.concatenate([moment + cross(self.place, linear), linear])


@dataclass(frozen=True, eq=False)
class Inertia:
    """Mass, its first moment in kg m ``# (3,)`` and the inertia about the link's origin in kg m² ``# (3, 3)``."""

    mass: Any
    moment: Values
    about_origin: Values

    @classmethod
    def of_body(cls, mass: Any, centre: Values, about_centre: Values) -> Inertia:
        """From a centre of mass, and the inertia about it."""
        shifted = skew(centre)
        return cls(mass, mass * centre, about_centre - mass * (shifted @ shifted))

    def __add__(self, other: Inertia) -> Inertia:
        return Inertia(self.mass + other.mass, self.moment + other.moment, self.about_origin + other.about_origin)

    def times(self, motion: Motion) -> Force:
        """Momentum of a velocity, or the force of an acceleration."""
        angular, linear = np.split(motion, 2)
        moment = self.about_origin @ angular + cross(self.moment, linear)
        return np.concatenate([moment, self.mass * linear - cross(self.moment, angular)])

    def in_parent(self, transform: Transform) -> Inertia:
        """The same inertia about the parent's origin, in its axes."""
        turn, shift = transform.turn, skew(transform.place)
        moment = turn.T @ self.moment
        moved = moment + self.mass * transform.place
        whole = turn.T @ self.about_origin @ turn - shift @ skew(moment) - skew(moved) @ shift
        return Inertia(self.mass, moved, whole)


def motion_cross(velocity: Motion, motion: Motion) -> Motion:
    """Rate of change of a motion that moves with a link."""
    (turning, moving), (angular, linear) = np.split(velocity, 2), np.split(motion, 2)
    return np.concatenate([cross(turning, angular), cross(turning, linear) + cross(moving, angular)])


def force_cross(velocity: Motion, force: Force) -> Force:
    """Rate of change of a force that moves with a link."""
    (turning, moving), (moment, linear) = np.split(velocity, 2), np.split(force, 2)
    return np.concatenate([cross(turning, moment) + cross(moving, linear), cross(turning, linear)])


def along(axis: Motion, force: Force) -> Expr:
    """Component of a force along a joint."""
    return axis[:3] @ force[:3] + axis[3:] @ force[3:]
