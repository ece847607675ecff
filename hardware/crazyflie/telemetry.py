"""What a Crazyflie says of itself, 100 times a second in one log block, so that attitude and rates belong together.

Newer firmware fits in 14 bytes: a compressed quaternion, rates in mrad/s, battery and supervisor. Older firmware has
no supervisor's word in its log: floats of the attitude, the gyroscope, voltage and two flags fit in 26.
"""

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

import numpy as np

from hardware.errors import LinkError
from sym2real.trajectory import Array

PERIOD_MS = 10
# Bits of supervisor.info (cflib, supervisor.py).
BITS = {"armed": 1, "can_fly": 3, "flying": 4, "tumbled": 5, "locked": 6, "crashed": 7}


@dataclass(frozen=True, eq=False)
class Telemetry:
    """One log packet.

    Args:
        attitude: quaternion w x y z, body→world ``# (4,)``.
        rates: of the body about its axes, forward, left, up, rad/s ``# (3,)``.
        battery: V.
        flags: what the supervisor says, as of :class:`hardware.interfaces.Reading`.
        stamp: of the robot's own clock, s.
        arrival: here, s.
    """

    attitude: Array
    rates: Array
    battery: float
    flags: frozenset[str]
    stamp: float
    arrival: float


Values = Mapping[str, float]
Unpack = Callable[[int], Array]


@dataclass(frozen=True)
class Block:
    """A log block: its variables with the type that they are fetched as, and how they are read.

    Args:
        variables: name → C type.
        decode: values by name and what unpacks a quaternion (x y z w) → attitude, rates, battery, flags.
        arming: whether its flags tell when the robot is armed.
    """

    variables: Mapping[str, str]
    decode: Callable[[Values, Unpack], tuple[Array, Array, float, frozenset[str]]]
    arming: bool


def _compact(values: Values, unpack: Unpack) -> tuple[Array, Array, float, frozenset[str]]:
    attitude = np.roll(unpack(int(values["stateEstimateZ.quat"])), 1)
    # The firmware's pitch rate is that about the right-hand axis.
    p, q, r = (values[f"stateEstimateZ.rate{axis}"] for axis in ("Roll", "Pitch", "Yaw"))
    flags = frozenset(name for name, bit in BITS.items() if int(values["supervisor.info"]) >> bit & 1)
    return attitude, np.array([p, -q, r]) / 1000.0, values["pm.vbatMV"] / 1000.0, flags


def _with_floats(values: Values, unpack: Unpack) -> tuple[Array, Array, float, frozenset[str]]:
    attitude = np.array([values[f"stateEstimate.q{axis}"] for axis in "wxyz"])
    rates = np.deg2rad([values[f"gyro.{axis}"] for axis in "xyz"])
    said = {"can_fly": "sys.canfly", "tumbled": "sys.isTumbled"}
    return attitude, rates, values["pm.vbat"], frozenset(flag for flag, name in said.items() if values[name])


BLOCKS = (
    Block(
        {
            "stateEstimateZ.quat": "uint32_t",
            "stateEstimateZ.rateRoll": "int16_t",
            "stateEstimateZ.ratePitch": "int16_t",
            "stateEstimateZ.rateYaw": "int16_t",
            "pm.vbatMV": "uint16_t",
            "supervisor.info": "uint16_t",
        },
        _compact,
        arming=True,
    ),
    Block(
        {
            **{f"stateEstimate.q{axis}": "float" for axis in "wxyz"},
            **{f"gyro.{axis}": "FP16" for axis in "xyz"},
            "pm.vbat": "FP16",
            "sys.canfly": "uint8_t",
            "sys.isTumbled": "uint8_t",
        },
        _with_floats,
        arming=False,
    ),
)


def block_for(names: Collection[str]) -> Block:
    """The first block whose variables a firmware logs, from the names of all that it logs.

    Raises:
        LinkError: naming what the last block misses.
    """
    for block in BLOCKS:
        if set(block.variables) <= set(names):
            return block
    missing = sorted(set(BLOCKS[-1].variables) - set(names))
    raise LinkError(f"this firmware logs no {', '.join(missing)}: it is too old to be flown from here")


def read(block: Block, values: Values, unpack: Unpack, stamp_ms: int, arrival: float) -> Telemetry:
    """A log packet's values by name → telemetry; an attitude that is none comes out as NaN."""
    with np.errstate(invalid="ignore"):
        attitude, rates, battery, flags = block.decode(values, unpack)
        norm = float(np.linalg.norm(attitude))
    unit = attitude / norm if 0.9 < norm < 1.1 else np.full(4, math.nan)
    return Telemetry(unit, rates, battery, flags, stamp_ms / 1000.0, arrival)
