"""Names of the columns and quantities that robots have in common, and what they mean."""

from math import pi
from typing import Literal, get_args

from sym2real.field import Field, Group

# Front right, rear right, rear left, front left.
MOTORS = ("motor1", "motor2", "motor3", "motor4")
# Of rotorcraft with any number of rotors.
MOTOR_COLUMNS = tuple(f"motor{number}" for number in range(1, 13))
# What the columns of a robot are for; code that is not of one robot asks these for its columns.
POSITION = Field("position", ("x", "y", "z"), "m", "world")
ATTITUDE = Field("attitude", ("qw", "qx", "qy", "qz"), "1", "world", "quaternion")
HEADING = Field("heading", ("sin_yaw", "cos_yaw"), "1", "world", "circle")
VELOCITY = Field("velocity", ("vx", "vy", "vz"), "m/s", "world")
RATE = Field("rate", ("wx", "wy", "wz"), "rad/s", "body")
THRUST = Field("thrust", ("thrust",), "N", "body")
TORQUE_COMMAND = Field("torque command", ("tx_cmd", "ty_cmd", "tz_cmd"), "N m", "body")
RATE_COMMAND = Field("rate command", ("wx_cmd", "wy_cmd", "wz_cmd"), "rad/s", "body")
ATTITUDE_COMMAND = Field("attitude command", ("qw_cmd", "qx_cmd", "qy_cmd", "qz_cmd"), "1", "world", "quaternion")
ATTITUDE_COMMANDED = "attitude_cmd"  # all columns of a commanded attitude, which act together
STEERING = Field("steering", ("steer",), "rad", "body")
SPEED = Field("speed", ("speed",), "m/s", "body")
ACCELERATION = Field("acceleration", ("acceleration",), "m/s^2", "body")
FORCE = Field("force", ("fx", "fy", "fz"), "N", "world")
TORQUE = Field("torque", ("tx", "ty", "tz"), "N m", "body")
# Of an attitude, where a log or a chart has angles: about the axes x, y and z.
EULER_ANGLES = ("roll", "pitch", "yaw")
BATTERY = Field("battery", ("vbat",), "V")
CLOCK = Field("time", ("t",), "s")
# Of the joints of any robot, whose columns are called after them.
JOINT_DISPLACEMENT, JOINT_ANGLE = Field("joint displacement", (), "m"), Field("joint angle", (), "rad")
JOINT_SPEED, JOINT_RATE = Field("joint speed", (), "m/s"), Field("joint rate", (), "rad/s")
JOINT_FORCE, JOINT_TORQUE = Field("joint force", (), "N"), Field("joint torque", (), "N m")
# The group says where a column of a file goes when no log specification does.
VOCABULARY: tuple[tuple[Group, Field], ...] = (
    *(("state", field) for field in (POSITION, ATTITUDE, HEADING, VELOCITY, RATE)),
    *(("action", field) for field in (THRUST, RATE_COMMAND, TORQUE_COMMAND, ATTITUDE_COMMAND)),
    ("action", Field("motors", MOTOR_COLUMNS, "1", "body")),
    *(("action", field) for field in (STEERING, SPEED, ACCELERATION)),
    *(("inputs", field) for field in (FORCE, TORQUE, BATTERY, CLOCK)),
)
WHOLE_TURNS = "by whole turns"  # what a note on a joint's angle says that was changed so
# Bounds and null of what is not limited; finite, so that it can be a parameter's value and stand in a file.
UNLIMITED = 1e15
# Beyond these sizes, a turn and a reach of robots on tables and wheels, a coordinate of a joint is in another unit.
LARGEST_PLACE = {"rad": 2.0 * pi, "m": 5.0}
# Quantities of equations that effects change: gravity in m/s², world axes.
GRAVITY_COMPONENTS = ("gravity_x", "gravity_y", "gravity_z")
# What rotors that are commanded themselves give together, beside their thrust: N m, body axes.
MOTOR_TORQUES = ("torque_x", "torque_y", "torque_z")
WRENCH = (*FORCE.columns, *TORQUE.columns)
# On wheels of one axle: the torque in N m by which they brake a turn, and the inertia in kg m² that turns.
DRILLING, TURNING_INERTIA = "drilling", "turning_inertia"
# The same: the mass in kg that moves ahead and the inertia in kg m² that turns, with what turns with a wheel; the first
# moment in kg m of the mass ahead of the axle.
MASS_AHEAD, MASS_MOMENT, MASS_TURNING = "mass_ahead", "mass_moment", "mass_turning"
# Of a log: 1 in rows at which a joint is at an end stop that the equations do not have, else 0.
AT_A_STOP = "at_a_stop"
HEIGHT = POSITION.columns[2]
(THRUST_COLUMN,), (STEER_COLUMN,), (SPEED_COLUMN,) = THRUST.columns, STEERING.columns, SPEED.columns
(ACCELERATION_COLUMN,) = ACCELERATION.columns
CarCommand = Literal["speed", "acceleration"]  # what a car is commanded beside its steering
CAR_COMMANDS: tuple[CarCommand, ...] = get_args(CarCommand)
MechanicalQuantity = Literal[
    "armature",
    "damping",
    "drag",
    "friction",
    "stiffness",
    "link_mass",
    "link_centre",
    "link_inertia",
    "link_length",
    "servo_gain",
    "servo_limit",
    "load",
]


def rate_column(coordinate: str) -> str:
    """Column of the rate at which a coordinate of a body or a joint changes."""
    return f"v{coordinate}" if coordinate in POSITION.columns else f"{coordinate}_rate"


def push_column(joint: str) -> str:
    """Input of the force in N or torque in N m along a joint."""
    return f"{joint}_push"


def is_push(column: str) -> bool:
    """Whether a column is a force or torque from outside, on a body or along a joint: zero where none acts."""
    return column in WRENCH or column.endswith(push_column(""))


def known_field(column: str) -> Field:
    """The field of a standard column; any other name is a dimensionless field of its own."""
    for _, field in VOCABULARY:
        if column in field.columns:
            return field
    return Field(column, (column,))


def rate_per_speed(action: str) -> str:
    """Number of a command that is the rate of a rolling wheel, or quantity of the wheel: rate per speed, rad/m."""
    return f"{action}_per_speed"


def rate_per_turn(action: str) -> str:
    """The same per turning rate of the robot, 1."""
    return f"{action}_per_turn"


def wheel_lever(wheel: str) -> str:
    """Distance of a rolling wheel to the right of the robot's middle, m: its rate per turn over that per speed."""
    return f"{wheel}_lever"


def wheel_grip(wheel: str) -> str:
    """Largest torque that the floor holds a rolling wheel by, N m."""
    return f"{wheel}_grip"


def wheel_load(wheel: str) -> str:
    """Number of a robot on wheels: what presses a wheel on the floor, N."""
    return f"{wheel}_load"


def quantity_of(kind: MechanicalQuantity, place: str) -> str:
    """Quantity of equations from an MJCF that effects change.

    Args:
        kind: of a joint the inertia that turns or slides with its motor ("armature", kg m² or kg), "damping" (N m s or
            N s/m), "drag" (N m s² or N s²/m²), dry "friction" (N m or N), "stiffness" (N m/rad or N/m), how many times
            its mass in the description the link behind it weighs ("link_mass"), as far as which from its hinge its
            centre lies ("link_centre") and the next joints do ("link_length"), how hard it is to turn about its centre
            ("link_inertia"), its servo's gain ("servo_gain") or largest force ("servo_limit", N m or N); of a site the
            mass that hangs there ("load", kg).
        place: name of the joint or site.
    """
    return f"{kind}_{place}"


def roughly(ends: tuple[float, float]) -> tuple[float, float]:
    """Ends of a joint's range, as rough as descriptions are: to either side wider by the whole width."""
    low, high = ends
    return 2 * low - high, 2 * high - low
