"""Mistakes in the logs of a robot of joints: most are one mistake at one of its joints, or at all of them."""

from collections.abc import Iterator

import numpy as np
from mistakes import (
    DEGREES,
    JUMP,
    LATE,
    ORDER,
    STALE,
    WRITTEN_EARLY,
    WRITTEN_LATE,
    Apply,
    Columns,
    Mistake,
    Rng,
    biased,
    frozen,
    gained,
    in_unit,
    jumping,
    late,
    repeating,
    reversed_sign,
    scaled,
    spiked,
    swapped,
)

from sym2real.layout import Layouts
from sym2real.robots import ROBOTS

# What a joint and a command that is all that moves it have in common: where one is mirrored, the other may be.
SIGN = r"(mirrored|other sign|wrong sign|reversed|opposite)"
SIZE = r"(instead of|in no unit of|gear ratio|times)"


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
