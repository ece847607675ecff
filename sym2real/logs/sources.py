"""Which column of a log each standard column was read from, so that advice can name what a user wrote."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from sym2real.layout import Layouts
from sym2real.logs.parts import ATTITUDES
from sym2real.logs.resample import COMMANDS
from sym2real.logs.specification import LogSpec
from sym2real.logs.standard import TURNED_ABOUT_X, attitude_columns
from sym2real.vocabulary import EULER_ANGLES, VELOCITY

# What the reader makes of a column of its own kind.
MADE_OF = {"yaw": ("sin_yaw", "cos_yaw"), "wheel_speed": ("vx", "vy")}


def commands_of(spec: LogSpec, layouts: Layouts | None) -> frozenset[str]:
    """Columns of the log that hold commands: of the vocabulary, and of a model's own."""
    actions = actions_of(layouts)
    return frozenset(source.column for name, source in spec.columns.items() if name in actions)


def actions_of(layouts: Layouts | None) -> frozenset[str]:
    """Standard columns that hold commands: of the vocabulary, and a model's own."""
    return COMMANDS.union(layouts.action if layouts else ())


def sources_of(spec: LogSpec) -> dict[str, str]:
    """Standard column → column of the log, with a minus where the frames turn its sign; as of ``Trajectory.sources``.

    What an order of components or an inverse changes of a quaternion is not told.
    """
    origins = {name: source.column for name, source in spec.columns.items()}
    turned = set(TURNED_ABOUT_X)
    for made, columns in MADE_OF.items():
        if made in origins and not {*columns} & origins.keys():
            origins |= dict.fromkeys(columns, origins[made])
    for name, (first, last) in ATTITUDES.items():
        attitude = getattr(spec, name)
        angles = [f"{first}{angle}{last}" for angle in EULER_ANGLES]
        turned |= {*angles[1:]}
        components = np.roll(attitude.quaternion, 1) if attitude.order == "xyzw" else attitude.quaternion
        origins |= dict(zip(angles, attitude.euler, strict=False))
        origins |= dict(zip(attitude_columns(name), map(str, components), strict=False))
    if spec.frames == "z_up":
        return origins
    return {name: f"-{column}" if name in turned else column for name, column in origins.items()}


def _angles_behind(name: str) -> tuple[str, ...]:
    """The angles that a component of an attitude may be made of; none of another column."""
    ends = [ends for kind, ends in ATTITUDES.items() if name in attitude_columns(kind)]
    return tuple(f"{first}{angle}{last}" for first, last in ends for angle in EULER_ANGLES)


def along_body(spec: LogSpec) -> tuple[str, ...]:
    """Velocities that stand in the log along the body's axes; as of ``Trajectory.along_body``."""
    return tuple(name for name in VELOCITY.columns if name in spec.columns) if spec.velocity_frame == "body" else ()


@dataclass(frozen=True)
class AsRead:
    """How logs were read: the columns and axes that advice to a user must be in.

    Args:
        sources: as of :class:`~sym2real.Trajectory`; nothing where nobody knows.
    """

    sources: Mapping[str, str] = field(default_factory=dict)

    def column(self, name: str) -> str:
        """The file's column of a standard one, by which that goes where there is no other."""
        return self.sources.get(name, name).removeprefix("-")

    def columns(self, names: Sequence[str]) -> tuple[str, ...]:
        """The files' columns behind several standard ones, each once; those alone that a file has, if it has any.

        Behind an attitude's components stand the angles that it was made of.
        """
        known = [own for name in names for own in (name, *_angles_behind(name)) if own in self.sources]
        return tuple(dict.fromkeys(map(self.column, known or names)))

    def logged(self, names: Sequence[str]) -> tuple[str, ...]:
        """Those that have a column of the file for themselves; the reader has made the others."""
        known = [name for name in names if name in self.sources or not self.sources]
        own = [self.column(name) for name in known]
        return tuple(name for name, column in zip(known, own, strict=True) if own.count(column) == 1)

    def sign(self, name: str) -> int:
        """-1 where the axes of the log turn the sign of a standard column."""
        return -1 if self.sources.get(name, "").startswith("-") else 1

    def scale(self, factor: float) -> str:
        """The entry of a specification by which a column's numbers are multiplied."""
        return f"scale = {factor:.4g} (times one that it has)"

    @property
    def frame(self) -> str:
        """A remark on signs where nobody knows the log's own axes."""
        return "" if self.sources else " (signs as of z up, and forward, left, up of the body)"
