"""What a robot was made from, as data: equations and simulators that have it need no registered robot."""

import msgspec


class Origin(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A robot from an MJCF, as :func:`sym2real.robots.from_mjcf.from_mjcf` makes it again.

    Args:
        mjcf: the description, which needs no file beside it.
        name: of the robot.
        title: what people call it.
        actions: every actuator that is commanded, and its column.
        state: columns of the state.
        dt: control period in s.
        numbers: of the robot by name, SI units.
    """

    mjcf: str
    name: str
    title: str
    actions: tuple[tuple[str, str], ...]
    state: tuple[str, ...]
    dt: float
    numbers: tuple[tuple[str, float], ...]
