"""What a log specification is made of: sources of columns, the time base, attitudes."""

from dataclasses import dataclass
from typing import Literal

from sym2real.logs.units import UNIT_OF_COLUMN
from sym2real.toml_tables import Positive

Order = Literal["wxyz", "xyzw"]
Direction = Literal["body_to_world", "world_to_body"]
Frames = Literal["z_up", "ned_frd"]
Derived = Literal["velocity", "rate"]
VelocityFrame = Literal["world", "body"]

# Attitudes that a specification can hold, and what stands before and after their standard columns.
ATTITUDES = {"attitude": ("", ""), "attitude_command": ("", "_cmd"), "reference_attitude": ("ref_", "")}
# A heading as this package writes it, the measured one and where it should be.
HEADINGS = (("sin_yaw", "cos_yaw"), ("ref_sin_yaw", "ref_cos_yaw"))
UPRIGHT = "wz"  # the components of a quaternion that does not tilt
ROWS_A_SECOND = "a number > 0, the rows a second, which a log without stamps does not say"
STANDARD_COLUMNS = (*UNIT_OF_COLUMN, *(f"ref_{column}" for column in UNIT_OF_COLUMN))


@dataclass(frozen=True)
class Source:
    """Where a standard column comes from.

    Args:
        column: name in the log.
        unit: unit in the log, a key of :data:`sym2real.logs.units.UNITS`; empty for the SI unit.
        scale: a further factor, for counts whose worth was measured (N per PWM count).
        zero: reading of the log that stands for zero (a servo's pulse straight ahead), taken off before the factors.
    """

    column: str
    unit: str = ""
    scale: Positive = 1.0
    zero: float = 0.0


@dataclass(frozen=True)
class TimeBase:
    """When rows were measured.

    Args:
        column: name of the column of stamps; empty where the log has none.
        unit: its unit, "s", "ms", "us" or "ns".
        rate: rows per second where there is no column; 0 until somebody says how many, with which no log is read.
        dt: step in s of the log where the reader is given none, unless it is slower; None leaves rows as they are.
    """

    column: str = "t"
    unit: Literal["s", "ms", "us", "ns"] = "s"
    rate: Positive | None = None
    dt: Positive | None = None


@dataclass(frozen=True)
class Attitude:
    """Which columns of a log hold an attitude, as a quaternion or as roll, pitch and yaw.

    Args:
        quaternion: the four columns, in the log's order; those of w and z alone where nothing tilts.
        order: "wxyz" or "xyzw".
        direction: "body_to_world", or "world_to_body" for its inverse.
        euler: columns of roll, pitch, yaw instead (yaw about z first, then pitch about y, then roll about x).
        unit: unit of those angles.
    """

    quaternion: tuple[str, ...] = ()
    order: Order = "wxyz"
    direction: Direction = "body_to_world"
    euler: tuple[str, ...] = ()
    unit: Literal["rad", "mrad", "deg"] = "rad"

    @property
    def sources(self) -> tuple[str, ...]:
        """Columns of the log."""
        return self.quaternion + self.euler
