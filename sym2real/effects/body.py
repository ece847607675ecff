"""What effects may know about a robot: its columns, the quantities that equations name, and its nominal numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import sqrt
from typing import Protocol

from sym2real.errors import ModelError
from sym2real.layout import Layouts, motors_of
from sym2real.vocabulary import (
    ATTITUDE,
    ATTITUDE_COMMAND,
    ATTITUDE_COMMANDED,
    HEADING,
    MOTOR_COLUMNS,
    SPEED_COLUMN,
    STEER_COLUMN,
    push_column,
    rate_column,
    rate_per_speed,
)

GRAVITY = 9.81  # m/s², as in the simulators; units have the standard one

# How far a column of that unit may be expected to be off; forces go by the robot's weight, motors by what carries it.
SCALES = {"rad/s": 0.5, "rad": 0.05, "m/s": 0.1, "m/s^2": 0.3, "m": 0.05, "1": 0.05}


# The same of an actuator whose range is known: a part of it.
SPAN_PART = 0.03
AT_ONCE = 1e9  # 1/s, of a loop without lag
# Unit of a joint that the state does not hold, by that of the force along it.
UNIT_BY_FORCE = {"N": "m", "N m": "rad"}


class Describable(Protocol):
    """A robot or equations: columns and numbers."""

    @property
    def layouts(self) -> Layouts:
        """Its columns."""

    @property
    def numbers(self) -> Mapping[str, float]:
        """Its numbers in SI units, as of :class:`Body`."""

    @property
    def dt(self) -> float:
        """Control period in s."""


@dataclass(frozen=True)
class Body:
    """A robot as its effects see it.

    Args:
        layouts: its columns.
        numbers: SI units, by name: ``mass``, inertia ``jx jy jz`` (car: ``jz`` about the centre of mass), gains of the
            rate loop ``kx ky kz``, time constant of the attitude loop ``attitude_time`` (s); rotors: ``arm``,
            ``torque_per_thrust`` (m), ``rotor_thrust`` (N s²/rad²); car: ``wheelbase``, ``track``,
            ``centre`` (of mass, ahead of the rear axle), ``wheel_drive`` (N s/m), time constant of the speed loop
            ``speed_time`` (s); joint J: ``J_inertia`` (what
            a force along it moves, kg or kg m²), ``J_alone`` (the same while no other joint is held: the least),
            ``J_braking`` (its damping and its servos', N s/m or N m s), ``J_friction``, ``J_stiffness``
            (its own by its description), ``J_strength`` (its actuators' largest force, N or N m); action A of an MJCF,
            or as it goes in logs: ``A_range``, in its unit;
            rate A of a wheel that rolls: ``A_per_speed`` (rad/m), ``A_per_turn`` (rad per rad of heading).
        quantities: names that equations derive (thrust of four motors).
        column: that an effect is bound to, or "".
        dt: control period in s.
        notes: of the equations that describe it.
        parameters: their named parameters, by name.
    """

    layouts: Layouts
    numbers: Mapping[str, float] = field(default_factory=dict)
    quantities: tuple[str, ...] = ()
    column: str = ""
    dt: float = 0.02
    notes: tuple[str, ...] = ()
    parameters: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, described: Describable, column: str = "") -> Body:
        """The body that equations or a robot describe."""
        quantities, notes = (tuple(getattr(described, name, ())) for name in ("quantities", "notes"))
        parameters = getattr(described, "parameters", {})
        return cls(described.layouts, described.numbers, quantities, column, described.dt, notes, parameters)

    @property
    def names(self) -> tuple[str, ...]:
        """Columns and quantities."""
        return (*self.layouts.columns, *self.quantities)

    @property
    def joints(self) -> tuple[str, ...]:
        """Joints whose rate is a column of the state, or a quantity beside the joint's number ``J_inertia``."""
        numbered = (name.removesuffix("_inertia") for name in self.numbers if name.endswith("_inertia"))
        derived = (joint for joint in numbered if rate_column(joint) in self.quantities)
        return (*self.layouts.state.joints, *derived)

    @property
    def planar(self) -> bool:
        """True for a robot that moves in a plane."""
        return "z" not in self.layouts.state

    @property
    def heading(self) -> str:
        """The first of the columns that tell where it points."""
        return (HEADING if self.planar else ATTITUDE).columns[0]

    @property
    def on_wheels(self) -> bool:
        """True for a robot in a plane that tyres hold across its heading: a steered car, or wheels of given rates."""
        steered = STEER_COLUMN in self.layouts.action and "wheelbase" in self.numbers
        rolling = any(name.endswith(rate_per_speed("")) for name in self.numbers)
        return self.planar and "sin_yaw" in self.layouts.state and (rolling or steered)

    @property
    def moves(self) -> str:
        """Where it moves, by its columns: in "space", in a "plane", or along its "joints" alone."""
        if "z" in self.layouts.state:
            return "space"
        return "plane" if "x" in self.layouts.state else "joints"

    @property
    def rotors(self) -> int:
        """Number of rotors: as many as are commanded, four where a loop commands them."""
        return len(motors_of(self.layouts.action)) or 4

    @property
    def mass(self) -> float:
        """In kg."""
        return self.number("mass")

    @property
    def role(self) -> str:
        """Name of the field that the column of an effect is in, whatever the column is called; "" without one."""
        if self.column in self.quantities:
            return self.column
        if self.column == ATTITUDE_COMMANDED:
            return ATTITUDE_COMMAND.name
        groups = (self.layouts.action, self.layouts.state)
        return next((field.name for group in groups for field in group.fields if self.column in field.columns), "")

    @property
    def unit(self) -> str:
        """Unit of the column that an effect is bound to."""
        if self.column in self.quantities:
            return "N"
        if self._turning:
            return "rad/s"
        for group in (self.layouts.action, self.layouts.state):
            if self.column in group:
                return group.units[self.column]
        return UNIT_BY_FORCE.get(self.layouts.inputs.units.get(push_column(self.column), ""), "1")

    @property
    def _turning(self) -> bool:
        """Whether the column is a rotor's speed: of such motors the thrust per squared speed is known."""
        return self.column in MOTOR_COLUMNS and "rotor_thrust" in self.numbers

    @property
    def scale(self) -> float:
        """How large a deviation of the column is to be expected beforehand, in its unit."""
        if self.unit == "N" and f"{self.column}_range" not in self.numbers:
            return 0.1 * GRAVITY * self.numbers.get("mass", 0.1)
        if self._turning:
            return 0.1 * sqrt(GRAVITY * self.numbers.get("mass", 0.1) / self.rotors / self.numbers["rotor_thrust"])
        span = self.numbers.get(f"{self.column}_range")
        return SCALES.get(self.unit, 0.1) if span is None else SPAN_PART * span

    def number(self, name: str) -> float:
        """One of the robot's numbers.

        Raises:
            ModelError: when nobody has given it.
        """
        if name not in self.numbers:
            known = ", ".join(self.numbers) or "none"
            raise ModelError(f"this effect needs the robot's number {name!r}; the equations carry {known}")
        return self.numbers[name]

    @property
    def loop_gains(self) -> tuple[float, ...]:
        """Gain in 1/s of the rate loop behind the bound action column, or behind each of all; 0 where there is none.

        A speed loop counts as none: what its mean moves, the position, is measured better than the speed it ends at.
        A gyro shows the steering that a period ends with, as if a loop without lag were behind it.
        """
        known = {f"w{axis}_cmd": self.numbers.get(f"k{axis}", 0.0) for axis in "xyz"}
        known |= {STEER_COLUMN: AT_ONCE} if self.shows_steering else {}
        return tuple(known.get(self.layouts.action.columns[place], 0.0) for place in self.action_indices())

    @property
    def shows_steering(self) -> bool:
        """Whether it is a car the yaw rate of which is a column."""
        return self.planar and STEER_COLUMN in self.layouts.action and "wz" in self.layouts.state

    @property
    def at_its_speed(self) -> bool:
        """Whether it is a car of first principles that reaches the commanded speed at once, whatever brakes it."""
        commanded = SPEED_COLUMN in self.layouts.action and "next_speed" in self.quantities
        return commanded and "speed_time" not in self.numbers

    @property
    def bound(self) -> tuple[str, ...]:
        """Columns that an effect on a command is bound to: one, those of a commanded attitude, or all actions."""
        if self.column == ATTITUDE_COMMANDED:
            return ATTITUDE_COMMAND.columns
        return (self.column,) if self.column else self.layouts.action.columns

    def action_indices(self) -> list[int]:
        """Positions of the bound action columns."""
        return [self.layouts.action.index(column) for column in self.bound]
