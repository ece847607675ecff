"""The mistakes that are made with each robot; of the quadrotor and of the car forty and more.

Of a robot of joints most are one mistake at one of its joints, or at all of them.
"""

from collections.abc import Iterator

import numpy as np
from mistakes import (
    DEGREES,
    JUMP,
    LATE,
    ORDER,
    QUATERNION,
    STALE,
    WRITTEN_EARLY,
    WRITTEN_LATE,
    Apply,
    Columns,
    Mistake,
    Rng,
    angles_times,
    attitude_turned,
    biased,
    clipped,
    frozen,
    gained,
    in_plane,
    in_unit,
    jumping,
    late,
    moved,
    repeating,
    reversed_sign,
    scaled,
    spiked,
    swapped,
    to_body,
    to_world,
)

from sym2real.layout import Layouts
from sym2real.robots import ROBOTS
from sym2real.robots.robot import GRAVITY

POSITION, VELOCITY, RATES = ("x", "y", "z"), ("vx", "vy", "vz"), ("wx", "wy", "wz")
RATE_COMMANDS, YAW = ("wx_cmd", "wy_cmd", "wz_cmd"), ("sin_yaw", "cos_yaw")
SCALAR_LAST = dict(zip(QUATERNION, ("qx", "qy", "qz", "qw"), strict=True))
PWM = 132_000.0  # per N
MASS = 0.027  # kg
LIMIT = r"\b(limit|clipped|saturated)\b"
OF_DEGREES, OF_RADIANS = r"(yaw|heading|attitude) in degrees", r"(yaw|heading|attitude) in radians"
OFF_BY_AN_ANGLE = r"(yaw|heading|attitude|world|frame).*\b(off by|turned by|turned frame|a zero of|180|bias)\b"
OF_VELOCITY = r"\b(v[xy]|velocity)\b"
MIRRORED = r"\b(mirrored|left-handed|other hand)\b"
# What a joint and a command that is all that moves it have in common: where one is mirrored, the other may be.
SIGN = r"(mirrored|other sign|wrong sign|reversed|opposite)"
SIZE = r"(instead of|in no unit of|gear ratio|times)"


def half_turn(_: Rng) -> float:
    """180°."""
    return np.pi


def quarter_turn(rng: Rng) -> float:
    """90° to either side."""
    return float(rng.choice([-0.5, 0.5]) * np.pi)


def some_turn(rng: Rng) -> float:
    """17° to 86° to either side."""
    return float(rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 1.5))


def yaw_times(factor: float) -> Apply:
    """Sine and cosine of a yaw in another unit."""

    def change(log: Columns, _: Rng) -> Columns:
        yaw = factor * np.arctan2(log["sin_yaw"], log["cos_yaw"])
        return {"sin_yaw": np.sin(yaw), "cos_yaw": np.cos(yaw)}

    return change


def along_the_car(log: Columns, _: Rng) -> Columns:
    """A car's velocity written along its own axes."""
    sine, cosine = log["sin_yaw"], log["cos_yaw"]
    return {"vx": cosine * log["vx"] + sine * log["vy"], "vy": cosine * log["vy"] - sine * log["vx"]}


FLIGHT = (
    in_unit("mm", POSITION, 1e3),
    in_unit("mm", ("z",), 1e3),
    in_unit("cm/s", VELOCITY, 1e2),
    in_unit("deg/s", RATES, DEGREES),
    in_unit("deg/s", RATE_COMMANDS, DEGREES),
    in_unit("grams", ("thrust",), 1e3 / GRAVITY),
    in_unit("PWM", ("thrust",), PWM),
    in_unit("m/s²", ("thrust",), 1.0 / MASS),
    *map(reversed_sign, (*RATES, "vz", *RATE_COMMANDS)),
    Mistake("quaternion scalar last", moved(SCALAR_LAST), "scalar last"),
    Mistake("quaternion from world to body", scaled(QUATERNION[1:], -1.0), "attitude turned the other way|conjugate"),
    Mistake("wx and wy swapped", swapped("wx", "wy"), rf"\bw[xy]\b.*{ORDER}"),
    Mistake("wx_cmd and wy_cmd swapped", swapped("wx_cmd", "wy_cmd"), rf"\bw[xy]_cmd\b.*{ORDER}"),
    Mistake("x and y of the position swapped", swapped("x", "y"), rf"\b[xy]\b.*{ORDER}|{ORDER}.*\b[xy]\b"),
    Mistake("vx and vy swapped", swapped("vx", "vy"), rf"\bv[xy]\b.*{ORDER}|{ORDER}.*\bv[xy]\b"),
    Mistake("x and y of position and velocity swapped", swapped("x", "y", "vx", "vy"), rf"{ORDER}|{MIRRORED}"),
    Mistake("velocity along body axes", to_body(VELOCITY), r"\bv[xyz]\b.*(body|frame)"),
    Mistake("rates along world axes", to_world(RATES), r"\bw[xyz]\b.*(world|frame)"),
    Mistake("z down", scaled(("z", "vz"), -1.0), r"z down|downwards|\bz\b.*(reversed|wrong sign|mirror|down)"),
    Mistake("y mirrored", scaled(("y", "vy"), -1.0), rf"\bv?y\b.*(reversed|wrong sign)|{MIRRORED}"),
    Mistake("yaw + 180°", attitude_turned(half_turn), OFF_BY_AN_ANGLE),
    Mistake("yaw off by an angle", attitude_turned(some_turn), OFF_BY_AN_ANGLE),
    Mistake("world turned under the attitude", in_plane(some_turn, ("x", "y"), ("vx", "vy")),
            OFF_BY_AN_ANGLE),
    Mistake("commands a row late", late(("thrust", *RATE_COMMANDS), 1, 1), WRITTEN_LATE),
    Mistake("commands a row early", late(("thrust", *RATE_COMMANDS), -1, -1), WRITTEN_EARLY, ("delay",)),
    Mistake("positions late", late(POSITION, 2, 5), rf"\b([xyz]|position)\b.*{LATE}", ("time_shift:[xyz]",)),
    Mistake("attitude late", late(QUATERNION, 2, 5), rf"(attitude|quaternion|\bq[wxyz]\b).*{LATE}", ("time_shift:q?",)),
    Mistake("rates late", late(RATES, 2, 5), rf"\b(w[xyz]|rate)\b.*{LATE}", ("time_shift:w?", "sensor_lag:w?")),
    Mistake("position jumps", jumping("x"), JUMP),
    Mistake("states repeat", repeating((*POSITION, *QUATERNION, *VELOCITY, *RATES)), STALE),
    Mistake("positions freeze", frozen(POSITION), STALE),
    Mistake("thrust clipped", clipped("thrust", 0.27, 0.285), rf"thrust.*{LIMIT}", ("limit:thrust",)),
    Mistake("bias of wx", biased("wx", 0.1, 0.3), r"\bwx\b.*(off by|bias)", ("sensor_bias:wx",)),
    Mistake("wz times a factor", gained("wz", 1.15, 1.5), r"\bwz\b.*(times|scale)", ("sensor_scale:wz",)),
    Mistake("attitude in degrees taken for radians", angles_times(DEGREES), OF_DEGREES),
    Mistake("attitude in radians taken for degrees", angles_times(1.0 / DEGREES), OF_RADIANS),
)  # fmt: skip

DRIVE = (
    in_unit("mm", ("x", "y"), 1e3),
    in_unit("km/h", ("vx", "vy"), 3.6),
    in_unit("deg/s", ("wz",), DEGREES),
    in_unit("degrees", ("steer",), DEGREES),
    in_unit("percent", ("steer",), 100.0 / 0.38),
    in_unit("km/h", ("speed",), 3.6),
    in_unit("cm/s", ("speed",), 1e2),
    in_unit("motor rpm", ("speed",), 3500.0),
    Mistake("yaw in degrees taken for radians", yaw_times(DEGREES), OF_DEGREES),
    *map(reversed_sign, ("wz", "steer", "speed", "vx", "vy")),
    Mistake("yaw reversed", scaled(("sin_yaw",), -1.0), "heading (that )?turns against", ("sensor_sign:sin_yaw",)),
    Mistake("x and y of the position swapped", swapped("x", "y"), rf"\b[xy]\b.*{ORDER}|{ORDER}.*\b[xy]\b"),
    Mistake("vx and vy swapped", swapped("vx", "vy"), rf"\bv[xy]\b.*{ORDER}|{ORDER}.*\bv[xy]\b"),
    Mistake("x and y of position and velocity swapped", swapped("x", "y", "vx", "vy"), rf"{ORDER}|{MIRRORED}"),
    Mistake("sine and cosine swapped", swapped(*YAW), rf"sin_yaw.*{ORDER}|heading counted otherwise|turns against"),
    Mistake("steer and speed swapped", swapped("steer", "speed"), rf"(steer|speed).*{ORDER}"),
    Mistake("velocity along body axes", along_the_car, r"\bv[xy]\b.*(body|frame)"),
    Mistake("y mirrored", scaled(("y", "vy"), -1.0), rf"\bv?y\b.*(reversed|wrong sign)|{MIRRORED}"),
    Mistake("yaw + 180°", in_plane(half_turn, ("cos_yaw", "sin_yaw")), OFF_BY_AN_ANGLE, ("yaw_bias",)),
    Mistake("yaw + 90°", in_plane(quarter_turn, ("cos_yaw", "sin_yaw")), OFF_BY_AN_ANGLE, ("yaw_bias",)),
    Mistake("yaw off by an angle", in_plane(some_turn, ("cos_yaw", "sin_yaw")), OFF_BY_AN_ANGLE, ("yaw_bias",)),
    Mistake("velocity in a turned frame", in_plane(some_turn, ("vx", "vy")), rf"{OF_VELOCITY}.*(frame|turned by)"),
    Mistake("commands a row late", late(("steer", "speed"), 1, 1), WRITTEN_LATE),
    Mistake("commands a row early", late(("steer", "speed"), -1, -1), WRITTEN_EARLY, ("delay",)),
    Mistake("positions late", late(("x", "y"), 2, 5), rf"\b([xy]|position)\b.*{LATE}", ("time_shift:[xy]",)),
    Mistake("yaw late", late(YAW, 2, 5), rf"(yaw|heading).*{LATE}", ("time_shift:*_yaw",)),
    Mistake(
        "velocities late",
        late(("vx", "vy"), 2, 5),
        rf"{OF_VELOCITY}.*{LATE}",
        ("time_shift:v?", "sensor_lag:v?"),
    ),
    Mistake("wz late", late(("wz",), 2, 5), rf"\b(wz|rate)\b.*{LATE}", ("time_shift:wz", "sensor_lag:wz")),
    Mistake("position jumps", jumping("x"), JUMP),
    Mistake("states repeat", repeating(("x", "y", *YAW, "vx", "vy", "wz")), STALE),
    Mistake("yaw freezes", frozen(YAW), rf"(yaw|heading).*{STALE}|{STALE}.*(yaw|heading)"),
    Mistake("steering clipped", clipped("steer", 0.1, 0.2), rf"steer.*{LIMIT}", ("limit:steer",)),
    Mistake("speed clipped", clipped("speed", 0.8, 1.1), rf"speed.*{LIMIT}", ("limit:speed",)),
    Mistake("spikes in wz", spiked("wz", 5.0), rf"\bwz\b.*{JUMP}|{JUMP}.*\bwz\b"),
    Mistake("bias of wz", biased("wz", 0.1, 0.3), r"\bwz\b.*(off by|bias)", ("sensor_bias:wz",)),
    Mistake("wz times a factor", gained("wz", 1.15, 1.5), r"\bwz\b.*(times|scale)", ("sensor_scale:wz",)),
    Mistake("yaw in radians taken for degrees", yaw_times(1.0 / DEGREES), OF_RADIANS),
)


def wrapped(joint: str) -> Apply:
    """An encoder that counts within one turn, and begins anew where the joint often is."""

    def wrap(log: Columns, _: Rng) -> Columns:
        seam = np.median(log[joint])
        return {joint: seam + (log[joint] - seam) % (2 * np.pi)}

    return wrap


def geared(joint: str, rate: str) -> Apply:
    """A joint that is measured at the motor, before a gear of 20 to 100."""

    def turn(log: Columns, rng: Rng) -> Columns:
        ratio = float(rng.integers(20, 101))
        return {name: ratio * log[name] for name in (joint, rate)}

    return turn


def mirrored(joint: str, rate: str) -> Mistake:
    """A joint that counts the other way."""
    keys = (f"sensor_sign:{joint}", f"sensor_sign:{rate}")
    return Mistake(f"{joint} mirrored", scaled([joint, rate], -1.0), rf"\b{joint}\b.*{SIGN}", keys)


def of_joint(joint: str, rate: str, unit: str) -> Iterator[Mistake]:
    """At one joint, whose coordinate has this unit."""
    name, factor = ("deg", DEGREES) if unit == "rad" else ("mm", 1e3)
    yield mirrored(joint, rate)
    yield reversed_sign(rate)
    yield reversed_sign(joint)
    yield in_unit(name, (joint, rate), factor)
    yield in_unit(name, (joint,), factor)
    yield in_unit(f"{name}/s", (rate,), factor)
    if unit == "rad":
        yield Mistake(f"{joint} wraps", wrapped(joint), rf"\b{joint}\b.*(unwrapped|whole turns)")
        yield Mistake(f"{joint} without its gear ratio", geared(joint, rate), rf"\b{joint}\b.*{SIZE}")
    yield Mistake(f"{joint} jumps", jumping(joint), rf"\b{joint}\b.*{JUMP}|{JUMP}.*\b{joint}\b")
    yield Mistake(f"spikes in {rate}", spiked(rate, 20.0), rf"\b{rate}\b.*{JUMP}|{JUMP}.*\b{rate}\b")
    yield Mistake(f"bias of {rate}", biased(rate, 0.1, 0.3), rf"\b{rate}\b.*(off by|bias)", (f"sensor_bias:{rate}",))
    yield Mistake(f"{rate} times a factor", gained(rate, 1.15, 1.5), rf"\b{rate}\b.*(times|scale)",
                  (f"sensor_scale:{rate}",))  # fmt: skip


def of_command(command: str, reach: float) -> Iterator[Mistake]:
    """At one command, of at most this size."""
    yield reversed_sign(command)
    factor = 100.0 / reach
    # Of a few times it is a gain.
    gain = (f"gain:{command}",) if factor < 10.0 else ()
    named = rf"\b{command}\b.*( instead of|in no unit of|in another unit)"
    yield Mistake(f"{command} in percent", scaled((command,), factor), named, gain)
    yield in_unit("mN or mN m", (command,), 1e3)


def of_all(layouts: Layouts) -> Iterator[Mistake]:
    """At all joints, all rates, all commands."""
    joints, rates = tuple(layouts.state.rates), tuple(layouts.state.rates.values())
    commands = layouts.action.columns
    yield Mistake("commands a row late", late(commands, 1, 1), WRITTEN_LATE)
    yield Mistake("commands two rows late", late(commands, 2, 2), WRITTEN_LATE)
    yield Mistake("commands a row early", late(commands, -1, -1), WRITTEN_EARLY, ("delay",))
    yield Mistake("coordinates late", late(joints, 2, 5), rf"\b({'|'.join(joints)}|angle|displacement)\b.*{LATE}",
                  tuple(f"time_shift:{name}" for name in joints))  # fmt: skip
    yield Mistake("rates late", late(rates, 2, 5), rf"\b({'|'.join(rates)}|rate|speed)\b.*{LATE}",
                  tuple(f"{kind}:{name}" for name in rates for kind in ("time_shift", "sensor_lag")))  # fmt: skip
    yield Mistake("states repeat", repeating((*joints, *rates)), STALE)
    yield Mistake("coordinates freeze", frozen(joints), STALE)


def between(layouts: Layouts) -> Iterator[Mistake]:
    """In which two joints of a kind, or two commands, stand in each other's place."""
    state, commands = layouts.state, layouts.action.columns
    alike = [name for name in state.rates if state.units[name] == "rad"]
    for one, two in ((alike[0], alike[2]), (alike[3], alike[5])) if len(alike) == 6 else ():
        both = (one, two, state.rates[one], state.rates[two])
        yield Mistake(f"{one} and {two} swapped", swapped(*both), rf"\b({one}|{two})\b.*{ORDER}")
        yield Mistake(f"angles of {one} and {two} swapped", swapped(one, two), rf"\b({one}|{two})\b.*{ORDER}")
    if len(commands) > 2:
        one, two = commands[0], commands[2]
        yield Mistake(f"{one} and {two} swapped", swapped(one, two), rf"\b({one}|{two})\b.*{ORDER}")


def mistakes_of(robot: str, joints: int = 3) -> tuple[Mistake, ...]:
    """Those of a robot, at so many of its joints and commands."""
    known, layouts = ROBOTS[robot], ROBOTS[robot].layouts
    chosen = list(layouts.state.rates.items())[:joints]
    found = [one for joint, rate in chosen for one in of_joint(joint, rate, layouts.state.units[joint])]
    reach = dict(zip(layouts.action, known.high, strict=True))
    found += [one for command in list(reach)[:joints] for one in of_command(command, float(reach[command]))]
    turning = [name for name, unit in layouts.state.units.items() if unit in ("rad", "rad/s")]
    everywhere = (in_unit("degrees", tuple(turning), DEGREES),) if len(turning) > 2 else ()
    return (*found, *everywhere, *of_all(layouts), *between(layouts))


JOINTS = {"arm": mistakes_of("arm"), "cart_pole": mistakes_of("cart_pole")}
MISTAKES = {"crazyflie": FLIGHT, "mushr": DRIVE, **JOINTS}
