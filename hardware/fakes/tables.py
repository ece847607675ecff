"""What the fake's firmware logs and which parameters it has, by the version of its protocol."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hardware.fakes.vehicle import Vehicle
from sym2real.trajectory import Array

# Codes of C types in the tables of contents: log variables, parameters; and how struct packs them.
LOG_TYPES = {"uint8_t": 1, "uint16_t": 2, "uint32_t": 3, "int8_t": 4, "int16_t": 5, "int32_t": 6, "float": 7, "FP16": 8}
PARAMETER_TYPES = {"uint8_t": 8, "uint16_t": 9, "uint32_t": 10, "float": 6}
PACKED = {1: "B", 2: "H", 3: "I", 4: "b", 5: "h", 6: "i", 7: "f", 8: "e"}
RESET, INITIAL = "kalman.resetEstimation", "kalman.initial"
COMPACT_SINCE = 10  # protocol whose firmware logs the supervisor and the compressed state


@dataclass(frozen=True, eq=False)
class Sample:
    """What the sensors say at one moment: one draw of noise for all variables."""

    attitude: Array
    rates: Array
    battery: float
    bits: int
    variance: float

    @classmethod
    def of(cls, vehicle: Vehicle) -> Sample:
        """The present."""
        variance = vehicle.estimator.variance(vehicle.time)
        return cls(vehicle.attitude(), vehicle.rates(), vehicle.battery, vehicle.supervisor.bits, variance)


@dataclass(frozen=True)
class Variable:
    """A log variable: group.name, its C type, its value."""

    name: str
    kind: str
    value: Callable[[Sample], float]


def log_variables(protocol: int) -> list[Variable]:
    """All of a firmware's, in the order of its table."""
    older = [
        *(_quaternion(f"stateEstimate.q{axis}", place) for place, axis in enumerate("wxyz")),
        *(_gyro(axis, place) for place, axis in enumerate("xyz")),
        *(Variable(f"kalman.var{axis}", "float", lambda sample: sample.variance) for axis in "XYZ"),
        Variable("pm.vbat", "float", lambda sample: sample.battery),
        Variable("sys.canfly", "uint8_t", lambda sample: sample.bits >> 3 & 1),
        Variable("sys.isFlying", "uint8_t", lambda sample: sample.bits >> 4 & 1),
        Variable("sys.isTumbled", "uint8_t", lambda sample: sample.bits >> 5 & 1),
    ]
    newer = [
        Variable("stateEstimateZ.quat", "uint32_t", lambda sample: compressed(sample.attitude)),
        _milli("Roll", 0, 1.0),
        _milli("Pitch", 1, -1.0),  # about the right-hand axis
        _milli("Yaw", 2, 1.0),
        Variable("pm.vbatMV", "uint16_t", lambda sample: round(1000.0 * sample.battery)),
        Variable("supervisor.info", "uint16_t", lambda sample: sample.bits),
    ]
    return [*older, *(newer if protocol >= COMPACT_SINCE else [])]


def parameters() -> dict[str, float]:
    """The firmware's parameters with their values after a start."""
    stabilised = {"flightmode.stabModeRoll": 1, "flightmode.stabModePitch": 1, "flightmode.stabModeYaw": 0}
    initial = {f"{INITIAL}{column}": 0.0 for column in ("X", "Y", "Z", "Yaw")}
    return {**stabilised, "stabilizer.estimator": 1, RESET: 0, **initial}


def kind_of(parameter: str) -> str:
    """Its C type."""
    return "float" if parameter.startswith(INITIAL) else "uint8_t"


def compressed(attitude: Array) -> int:
    """A quaternion w x y z in 32 bits: the place of the greatest of x y z w, then sign and 9 bits of the others."""
    ordered = np.roll(attitude, -1)
    greatest = int(np.argmax(np.abs(ordered)))
    signed = ordered * math.copysign(1.0, ordered[greatest])
    packed = greatest
    for place in range(4):
        if place != greatest:
            size = min(511, round(abs(float(signed[place])) * math.sqrt(2.0) * 511))
            packed = packed << 10 | (signed[place] < 0) << 9 | size
    return int(packed)


def packed_value(kind: int, value: float) -> bytes:
    """A value as the firmware sends it in a type."""
    code = PACKED[kind]
    return struct.pack(f"<{code}", float(value) if code in "fe" else int(value))


def table_item(name: str, code: int) -> bytes:
    """An entry of a table of contents: type, group, name."""
    group, own = name.split(".")
    return bytes([code]) + group.encode() + b"\0" + own.encode() + b"\0"


def _quaternion(name: str, place: int) -> Variable:
    return Variable(name, "float", lambda sample: float(sample.attitude[place]))


def _gyro(axis: str, place: int) -> Variable:
    return Variable(f"gyro.{axis}", "float", lambda sample: math.degrees(float(sample.rates[place])))


def _milli(axis: str, place: int, sign: float) -> Variable:
    def value(sample: Sample) -> float:
        return min(32767, max(-32768, round(1000.0 * sign * float(sample.rates[place]))))

    return Variable(f"stateEstimateZ.rate{axis}", "int16_t", value)
