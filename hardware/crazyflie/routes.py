"""Two ways to tell a Crazyflie its total thrust and body rates; each has signs and a reach of its own.

Here rates are p, q, r about body x (forward), y (left), z (up). The firmware's pitch is that of aeronautics turned
about: port 7 and cflib's own function negate it; port 3 also negates yaw.

Sources: crazyflie-firmware, crtp_commander_rpyt.c and crtp_commander_generic.c; cflib, commander.py.
"""

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hardware.crazyflie.thrust_map import FULL_SCALE
from sym2real.registry import Registry
from sym2real.trajectory import Array

MANUAL = 11  # type of a port-7 packet: rates or angles, and a thrust count
WITH_RATES = 1
GENERIC_PORT = 7
# Of port 3: the firmware takes less for none.
LEAST_COMMANDER, MOST_COMMANDER = 1000, 60000

Packet = tuple[int, bytes]  # port, data on channel 0


@dataclass(frozen=True)
class Route:
    """One way.

    Args:
        name: what a user calls it.
        protocol: least CRTP protocol version that understands it.
        reachable: the count that is sent for a wanted one.
        tell: sends rates in °/s ``# (3,)`` and a count, by cflib's ``Crazyflie`` and a function that sends a packet.
        parameters: of the firmware that must be set first, by name.
        unlocked_by_zero: whether the thrust is locked until a set-point without any has come.
    """

    name: str
    protocol: int
    reachable: Callable[[int], int]
    tell: Callable[[Any, Callable[[Packet], None], Array, int], None]
    parameters: Mapping[str, int] = field(default_factory=dict)
    unlocked_by_zero: bool = False


def wire_rates(rates: Array) -> tuple[Array, Array]:
    """Rates in rad/s ``# (3,)`` as they go over the wire, in °/s of single precision, and in rad/s again."""
    degrees = np.rad2deg(rates).astype(np.float32).astype(np.float64)
    return degrees, np.deg2rad(degrees)


def _packet(crazyflie: Any, send: Callable[[Packet], None], rates_deg: Array, counts: int) -> None:
    p, q, r = rates_deg.tolist()
    send((GENERIC_PORT, struct.pack("<BfffHB", MANUAL, p, -q, r, counts, WITH_RATES)))


def _commander(crazyflie: Any, send: Callable[[Packet], None], rates_deg: Array, counts: int) -> None:
    p, q, r = rates_deg.tolist()
    crazyflie.commander.send_setpoint(p, q, -r, counts)


def _commander_counts(wanted: int) -> int:
    return 0 if wanted < LEAST_COMMANDER else min(wanted, MOST_COMMANDER)


ROUTES: Mapping[str, Route] = Registry(
    "set-point route",
    {
        "packet": Route("packet", 10, lambda wanted: min(max(wanted, 0), FULL_SCALE), _packet),
        "commander": Route(
            "commander",
            0,
            _commander_counts,
            _commander,
            {f"flightmode.stabMode{axis}": 0 for axis in ("Roll", "Pitch", "Yaw")},
            unlocked_by_zero=True,
        ),
    },
)
