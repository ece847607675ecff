"""Which column of a log each standard column was read from, so that advice can name what a user wrote."""

from __future__ import annotations

from sym2real.logs.parts import ATTITUDES
from sym2real.logs.specification import LogSpec
from sym2real.logs.standard import TURNED_ABOUT_X, attitude_columns

ANGLES = ("roll", "pitch", "yaw")
ANGLES_TURNED = ("pitch", "yaw")
# What the reader makes of a column of its own kind.
MADE_OF = {"yaw": ("sin_yaw", "cos_yaw"), "wheel_speed": ("vx", "vy")}


def sources_of(spec: LogSpec) -> dict[str, str]:
    """Standard column → column of the log, with a minus where the frames turn its sign; as of ``Trajectory.sources``.

    What an order of components or an inverse changes of a quaternion is not told.
    """
    found = {name: source.column for name, source in spec.columns.items()}
    turned = set(TURNED_ABOUT_X)
    for made, columns in MADE_OF.items():
        if made in found and not {*columns} & found.keys():
            found |= dict.fromkeys(columns, found[made])
    for name in ATTITUDES:
        attitude, columns = getattr(spec, name), attitude_columns(name)
        first, last = ATTITUDES[name]
        if attitude.euler:
            found |= {f"{first}{a}{last}": column for a, column in zip(ANGLES, attitude.euler, strict=True)}
            turned |= {f"{first}{a}{last}" for a in ANGLES_TURNED}
        elif attitude.quaternion:
            order = attitude.quaternion if attitude.order == "wxyz" else (attitude.quaternion[3], *attitude.quaternion[:3])
            found |= dict(zip(columns, order, strict=True))
    if spec.frames == "z_up":
        return found
    return {name: f"-{column}" if name in turned else column for name, column in found.items()}
