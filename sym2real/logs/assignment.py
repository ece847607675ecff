"""Which standard column each column of a log may be, by their names together."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from sym2real.layout import Layouts
from sym2real.logs.name_words import words_and_unit
from sym2real.logs.names import Named, read_name
from sym2real.logs.parts import HEADINGS, STANDARD_COLUMNS, UPRIGHT
from sym2real.vocabulary import ACCELERATION_COLUMN, EULER_ANGLES

PREFIX = {"position": "", "velocity": "v", "rate": "w", "force": "f", "torque": "t"}
STANDARD = {
    "motor": "motor", "speed": "measured speed", "wheel speed": "wheel_speed", "thrust": "thrust",
    "throttle": "throttle", "steer": "steer", "battery": "vbat",
}  # fmt: skip
MOVING = ("position", "velocity", "rate")
# Words of robots of joints, alone or with a number; and angles whose names are also those of joints.
JOINTS, NUMBERED = frozenset({"joint", "joints", "effort", "efforts"}), frozenset({"tau", "torque", "dq", "qd", "qdot"})
GREEK = frozenset({"theta", "phi", "psi"})
ATTITUDE_OF_ROLE = {"state": "attitude", "command": "attitude_command", "reference": "reference_attitude"}
WHOLE = ({*"wxyz"}, {*UPRIGHT}, {*"0123"}, {*"1234"})  # what a quaternion's components may be called by
# World axes as navigation names them, north-east-down or east-north-up, and aeronautics' letters: what they stand for.
XYZ = ("x", "y", "z")
ROTATION = ("rx", "ry", "rz")  # Vicon's angles, beside tx, ty, tz
LETTERS = {
    ("north", "east", "down"): XYZ, ("n", "e", "d"): XYZ, ("east", "north", "up"): XYZ, ("e", "n", "u"): XYZ,
    ("u", "v", "w"): ("vx", "vy", "vz"), ("p", "q", "r"): ("wx", "wy", "wz"),
    (*ROTATION, "rw"): ("qx", "qy", "qz", "qw"), ROTATION: EULER_ANGLES,
}  # fmt: skip
LEVEL = dict.fromkeys((("east", "north"), ("easting", "northing"), ("e", "n")), XYZ[:2])


@dataclass
class Assignment:
    """What names alone suggest.

    Args:
        times: columns that may hold stamps.
        columns: standard column → column of the log.
        quaternions: attitude → component ("w" or a digit) → column of the log.
        angles: attitude → "roll", "pitch", "yaw" → column of the log.
        named: column of the log → what its name says.
        duplicates: column of the log → the column that was taken in its place.
        beside: columns named like roll, pitch and yaw beside a measured quaternion, which need no angles.
    """

    times: list[str] = field(default_factory=list)
    columns: dict[str, str] = field(default_factory=dict)
    quaternions: dict[str, dict[str, str]] = field(default_factory=dict)
    angles: dict[str, dict[str, str]] = field(default_factory=dict)
    named: dict[str, Named] = field(default_factory=dict)
    duplicates: dict[str, str] = field(default_factory=dict)
    beside: tuple[str, ...] = ()

    def unit(self, column: str) -> str:
        """The unit that the column's name states, or ""."""
        return self.named[column].unit if column in self.named else ""

    @property
    def is_car(self) -> bool:
        """Whether a column is a steering angle."""
        return "steer" in self.columns


def assign(names: Sequence[str], motors: int = 4) -> Assignment:
    """Sort columns by what their names say; of two that say the same one that is called so is taken, else the first.

    Args:
        names: of the columns.
        motors: how many a robot has that is commanded motor by motor.
    """
    result = Assignment()
    result.columns = {name: name for pair in HEADINGS if {*pair} <= {*names} for name in pair}
    names = [name for name in names if name not in result.columns]
    sure = _compass(names) | _numbered(names)  # what several names say together goes before what one says
    result.named = sure | {name: meaning for name in names if name not in sure and (meaning := read_name(name))}
    for name in _counted_joints(result.named, [name for name in names if name not in sure]):
        del result.named[name]
    for name, named in sorted(result.named.items(), key=lambda item: item[0] not in STANDARD_COLUMNS):
        _place(result, name, named)
    _settle(result, motors)
    return result


def within(assignment: Assignment, layouts: Layouts) -> Assignment:
    """What of an assignment a model with these columns has a use for."""
    wanted = {*layouts.columns}
    turning = {"attitude", "reference_attitude"} if wanted & {"qw", "sin_yaw"} else set()
    attitudes = turning | ({"attitude_command"} if "qw_cmd" in wanted else set())
    made_of = {"yaw": "sin_yaw", "wheel_speed": "vx"}

    def is_of_use(column: str) -> bool:
        standard = column.removeprefix("ref_")
        return made_of.get(standard, standard) in wanted

    columns = dict(assignment.columns)
    if (source := columns.get("speed")) and "speed" not in wanted and assignment.named[source].role == "state":
        columns.setdefault("wheel_speed", source)
    return replace(
        assignment,
        columns={standard: name for standard, name in columns.items() if is_of_use(standard)},
        quaternions={name: parts for name, parts in assignment.quaternions.items() if name in attitudes},
        angles={name: parts for name, parts in assignment.angles.items() if name in attitudes},
    )


def _compass(names: Sequence[str]) -> dict[str, Named]:
    """Names that differ in a direction of the compass, or a letter, alone, all three there: ``v_n``, ``v_e``, ``v_d``.

    Where no name goes up or down, east and north are enough.
    """
    matches: dict[str, Named] = {}
    written = {name.lower(): name for name in names}  # ArduPilot's PN, PE, PD
    level = not any(re.search(r"up|down", name, re.IGNORECASE) for name in names)
    for axes, standard in (LETTERS | (LEVEL if level else {})).items():
        first = re.compile(rf"{axes[0]}(?=(([._][a-z/]+)*| *[\[(].*)$)", re.IGNORECASE)
        parted = [(text[: at.start()], text[at.end() :]) for text in names for at in first.finditer(text)]
        for head, tail in parted:
            alike = [written.get(f"{head}{axis}{tail}".lower(), "") for axis in axes]
            meant = [read_name(f"{head}{axis}{tail}") for axis in standard]
            placed = axes != ROTATION or any(name.startswith(f"{head}tx".lower()) for name in written)
            if all(alike) and all(meant) and placed and not matches.keys() & {*alike}:
                matches |= {column: named for column, named in zip(alike, meant, strict=True) if named}
    return matches


def _families(names: Sequence[str]) -> dict[tuple[str, str], dict[str, str]]:
    """Names that differ in a number alone: what stands before and behind it → number → name."""
    families: dict[tuple[str, str], dict[str, str]] = {}
    for name in names:
        if match := re.fullmatch(r"(.*?)_?\[?(\d)\]?(\D*)", name):
            families.setdefault((match[1], match[3]), {})[match[2]] = name
    return families


def speaks_of_joints(names: Sequence[str]) -> bool:
    """Whether a log is of a robot of joints, by the words in the names of its columns."""
    words = [set(words_and_unit(name)[0]) for name in names]
    return any(of_name & JOINTS or (of_name & NUMBERED and any(map(str.isdigit, of_name))) for of_name in words)


def _counted_joints(named: Mapping[str, Named], names: Sequence[str]) -> list[str]:
    """Names whose number would be an axis and counts joints: no axis has the number 3, and two from 1 are no y and z.

    Nor are those of a log that speaks of joints or efforts; and a robot has one heading, not a theta1 and a theta2.
    """
    of_joints = speaks_of_joints(names)
    return [
        name
        for columns in _families(names).values()
        for name in columns.values()
        if name in named
        and (
            (named[name].counted and (of_joints or {*columns} not in ({"0", "1"}, {"0", "1", "2"})))
            or (
                named[name].quantity in EULER_ANGLES
                and len(columns) > 1
                and GREEK.intersection(words_and_unit(name)[0])
            )
        )
    ]


def _numbered(names: Sequence[str]) -> dict[str, Named]:
    """Names that differ in a number alone: three from 1 are axes, four that would be rates or forces are rotors.

    PX4 has position, velocity and attitude under names of their own, and calls what a gyroscope says ``xyz``.
    """
    matches: dict[str, Named] = {}
    if speaks_of_joints(names):
        return matches
    for (head, tail), columns in _families(names).items():
        digits = "".join(sorted(columns))
        meant = {digit: read_name(f"{head}_{axis}{tail}") for digit, axis in zip("123", "xyz", strict=True)}
        if digits == "123" and all(named and named.quantity in MOVING for named in meant.values()):
            matches |= {columns[digit]: named for digit, named in meant.items() if named}
        elif head == "xyz" and digits == "012" and {*XYZ} <= {*names}:
            matches |= {columns[digit]: Named("rate", axis) for digit, axis in zip(digits, XYZ, strict=True)}
        elif digits in {"0123", "1234"} and (named := meant["1"]) and named.quantity in {"rate", "force"}:
            matches |= {column: Named("motor", digit, "command", named.unit) for digit, column in columns.items()}
    return matches


def _place(result: Assignment, name: str, named: Named) -> None:
    attitude = ATTITUDE_OF_ROLE[named.role]
    places, key = result.columns, STANDARD.get(named.quantity, "")
    if named.quantity == "time":
        result.times.append(name)
        return
    if named.quantity == "quaternion":
        places, key = result.quaternions.setdefault(attitude, {}), named.axis
    elif named.quantity in EULER_ANGLES:
        places, key = result.angles.setdefault(attitude, {}), named.quantity
    elif named.quantity in PREFIX:
        command = "_cmd" if (named.role, named.quantity) == ("command", "rate") else ""
        key = f"{'ref_' if named.role == 'reference' else ''}{PREFIX[named.quantity]}{named.axis}{command}"
    elif named.quantity == "motor":
        key += named.axis
    elif named.quantity in {"speed", "wheel speed"}:
        key = {"command": "speed", "reference": "ref_speed", "state": key}[named.role]
    elif named.quantity == "pull":
        key = ACCELERATION_COLUMN if named.role == "command" else ""
    elif (named.quantity, named.axis, named.role) == ("acceleration", "x", "reference"):
        key = ACCELERATION_COLUMN
    if key in places:
        result.duplicates[name] = places[key]
    elif key:
        places[key] = name


def _settle(result: Assignment, motors: int) -> None:
    _settle_motors(result, motors)
    _settle_throttle(result)
    _settle_speed(result)
    result.quaternions = {attitude: parts for attitude, parts in result.quaternions.items() if {*parts} in WHOLE}
    for attitude, parts in list(result.angles.items()):
        # A planar robot's theta is its heading.
        if "pitch" in parts and not {"roll", "yaw"} & parts.keys() and "theta" in parts["pitch"].lower():
            parts["yaw"] = parts.pop("pitch")
        if set(parts) == set(EULER_ANGLES) and attitude not in result.quaternions:
            continue
        if attitude not in result.quaternions and attitude != "attitude_command" and "yaw" in parts:
            result.columns["ref_yaw" if attitude == "reference_attitude" else "yaw"] = parts["yaw"]
        if attitude == "attitude" and set(parts) == set(EULER_ANGLES):
            result.beside = tuple(parts[angle] for angle in EULER_ANGLES)
        del result.angles[attitude]


def _settle_motors(result: Assignment, count: int) -> None:
    motors = {int(key.removeprefix("motor")): key for key in result.columns if key.startswith("motor")}
    named = [result.columns.pop(motors[number]) for number in sorted(motors)]
    if sorted(motors) in ([*range(count)], [*range(1, count + 1)]):
        result.columns |= {f"motor{i + 1}": name for i, name in enumerate(named)}


def _settle_throttle(result: Assignment) -> None:
    """A throttle commands the thrust where neither a thrust nor motors do, and nothing steers."""
    throttle = result.columns.pop("throttle", None)
    if throttle is not None and not result.is_car and "motor1" not in result.columns:
        result.columns.setdefault("thrust", throttle)


def _settle_speed(result: Assignment) -> None:
    """A car's commanded speed, and that of its wheels; where only one speed is there, it stands for the command.

    A reference of the speed is what was asked for: without a command it is the command. Beside an acceleration that was
    commanded a speed that nobody commanded is a measured one.
    """
    columns = result.columns
    measured, reference = columns.pop("measured speed", None), columns.pop("ref_speed", None)
    if not result.is_car or "speed" in columns:
        columns.pop(ACCELERATION_COLUMN, None)
    if not result.is_car:
        columns.pop("wheel_speed", None)
        return
    if ACCELERATION_COLUMN in columns:
        if measured is not None:
            columns.setdefault("wheel_speed", measured)
        return
    if "speed" not in columns and "ref_vx" in columns and "ref_vy" not in columns:
        columns["speed"] = columns.pop("ref_vx")
    if reference is not None:
        columns.setdefault("speed", reference)
    for column in (measured, columns.pop("wheel_speed", None)):
        if column is not None:
            columns.setdefault("wheel_speed" if "speed" in columns else "speed", column)
