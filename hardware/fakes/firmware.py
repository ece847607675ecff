"""The fake's side of CRTP: packets in, packets out, and log blocks when they are due. It knows no socket.

A packet is its header (port, channel) and its data. Ports: crazyflie-firmware, crtp.h.
"""

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from hardware.fakes.tables import (
    INITIAL,
    LOG_TYPES,
    PARAMETER_TYPES,
    RESET,
    Sample,
    kind_of,
    log_variables,
    packed_value,
    parameters,
    table_item,
)
from hardware.fakes.vehicle import Vehicle

PARAMETERS, COMMANDER, MEMORY, LOG, LOCALISATION, GENERIC, SUPERVISOR, PLATFORM, LINK = 2, 3, 4, 5, 6, 7, 9, 13, 15
SUPERVISED = 12  # protocol with a supervisor's port
MANUAL, STOP = 11, 0  # types of generic set-points
MANUAL_SINCE = 10
RESET_LOG, CREATE, APPEND, START, STOP_LOG, DELETE = 5, 6, 7, 3, 4, 2
NO_MEMORY = 12  # errno


@dataclass
class Block:
    """A log block: places and types of its variables, its period in s, when it is due next."""

    variables: list[tuple[int, int]] = field(default_factory=list)
    period: float = 0.0
    due: float = 0.0


class Firmware:
    """Answers packets and logs.

    Args:
        vehicle: what it flies.
        protocol: version that it speaks: 9, 10 or 12.

    Attributes:
        commands: set-points that have come.
        position: the last that it was told, m.
    """

    def __init__(self, vehicle: Vehicle, protocol: int = 12) -> None:
        self.vehicle, self.protocol = vehicle, protocol
        self.variables, self.parameters = log_variables(protocol), parameters()
        self.commands, self.position, self._unlocked = 0, (0.0, 0.0, 0.0), False
        self._blocks: dict[int, Block] = {}
        self._boot = vehicle.time
        self._ports = {
            PARAMETERS: self._on_parameters,
            COMMANDER: self._on_commander,
            MEMORY: lambda channel, data: [bytes([data[0], 0])],  # no memories
            LOG: self._on_log,
            LOCALISATION: self._on_localisation,
            GENERIC: self._on_generic,
            SUPERVISOR: self._on_supervisor,
            PLATFORM: self._on_platform,
            LINK: self._on_link,
        }

    def answer(self, packet: bytes) -> list[bytes]:
        """Packets that answer one."""
        port, channel, data = packet[0] >> 4, packet[0] & 3, packet[1:]
        handle = self._ports.get(port)
        if packet[0] == 0xFF or handle is None or not data:
            return [packet[:1]] if packet[0] == 0xFF else []  # a scan asks whether anybody is there
        return [packet[:1] + answer for answer in handle(channel, data)]

    def logged(self) -> Iterator[bytes]:
        """Log packets that are due now; those of periods that have gone by unseen are left out."""
        now = self.vehicle.time
        for number, block in self._blocks.items():
            if block.period and now >= block.due:
                block.due += block.period * (1 + int((now - block.due) / block.period))
                sample = Sample.of(self.vehicle)
                values = b"".join(packed_value(kind, self.variables[at].value(sample)) for at, kind in block.variables)
                stamp = round(1000.0 * (now - self._boot)) & 0xFFFFFF
                yield bytes([LOG << 4 | 3 << 2 | 2, number]) + stamp.to_bytes(3, "little") + values

    @property
    def next_due(self) -> float:
        """When the next log packet is due, s."""
        return min((block.due for block in self._blocks.values() if block.period), default=float("inf"))

    def _on_link(self, channel: int, data: bytes) -> list[bytes]:
        if channel == 0:
            return [data]  # echo
        return [b"Bitcraze Crazyflie\0\0"] if channel == 1 else []

    def _on_platform(self, channel: int, data: bytes) -> list[bytes]:
        if channel == 1 and data[0] == 0:
            return [bytes([0, self.protocol])]
        if channel == 0 and data[0] == 1 and self.protocol < SUPERVISED:
            return [bytes([1, self.vehicle.supervisor.arm(bool(data[1]), self.vehicle.time), data[1]])]
        return []

    def _on_supervisor(self, channel: int, data: bytes) -> list[bytes]:
        supervisor, command = self.vehicle.supervisor, data[0]
        if self.protocol < SUPERVISED:
            return []
        if channel == 0 and command == 0x0C:
            return [bytes([command | 0x80]) + supervisor.bits.to_bytes(2, "little")]
        if channel == 1 and command == 1:
            done = supervisor.arm(bool(data[1]), self.vehicle.time)
            return [bytes([command | 0x80, done, supervisor.armed])]
        if channel == 1 and command == 3:
            supervisor.lock()
        return []

    def _on_localisation(self, channel: int, data: bytes) -> list[bytes]:
        if channel == 0:
            self.position = struct.unpack("<fff", data)
            self.vehicle.estimator.tell(self.vehicle.time)
        elif channel == 1 and data[0] == 3 and self.protocol < SUPERVISED:
            self.vehicle.supervisor.lock()
        return []

    def _on_commander(self, channel: int, data: bytes) -> list[bytes]:
        roll, pitch, yaw, counts = struct.unpack("<fffH", data)
        self._unlocked = self._unlocked or counts == 0
        rated = all(self.parameters[f"flightmode.stabMode{axis}"] == 0 for axis in ("Roll", "Pitch", "Yaw"))
        if not self._unlocked or counts < 1000:
            counts = 0
        # In any other mode the numbers are angles, and a vehicle that is told rates would turn over: it stays down.
        self._command(counts if rated else 0, (roll, -pitch, -yaw))
        return []

    def _on_generic(self, channel: int, data: bytes) -> list[bytes]:
        if channel == 0 and data[0] == STOP:
            self.vehicle.stop()
        elif channel == 0 and data[0] == MANUAL and self.protocol >= MANUAL_SINCE:
            _, roll, pitch, yaw, counts, rated = struct.unpack("<BfffHB", data)
            self._command(counts if rated else 0, (roll, -pitch, yaw))
        return []

    def _command(self, counts: int, rates_deg: tuple[float, float, float]) -> None:
        self.commands += 1
        self.vehicle.command(counts, np.deg2rad(rates_deg))

    def _on_parameters(self, channel: int, data: bytes) -> list[bytes]:
        names = list(self.parameters)
        if channel == 0:
            return self._table(data, [table_item(name, PARAMETER_TYPES[kind_of(name)]) for name in names])
        if channel not in (1, 2):
            return []
        name = names[int.from_bytes(data[:2], "little")]
        layout = "<f" if kind_of(name) == "float" else "<B"
        if channel == 1:
            value = self.parameters[name]
            return [data[:2] + b"\0" + struct.pack(layout, value if layout == "<f" else int(value))]
        (self.parameters[name],) = struct.unpack(layout, data[2:])
        if name == RESET and self.parameters[name]:
            vehicle = self.vehicle
            vehicle.estimator.reset(vehicle.state[3:7], self.parameters[f"{INITIAL}Yaw"], vehicle.time)
        return [data]

    def _on_log(self, channel: int, data: bytes) -> list[bytes]:
        if channel == 0:
            items = [table_item(variable.name, LOG_TYPES[variable.kind]) for variable in self.variables]
            return self._table(data, items, bytes([16, 128]))
        return [data[:1] + self._settings(data[0], data[1:])] if channel == 1 else []

    def _settings(self, command: int, data: bytes) -> bytes:
        if command == RESET_LOG:
            self._blocks.clear()
            return bytes(2)
        number, error = data[0], 0
        if command == CREATE:
            self._blocks[number] = Block()
        block = self._blocks.get(number, Block())
        if command in (CREATE, APPEND):
            # cflib may leave a byte of a variable that did not fit; the firmware takes whole ones alone.
            whole = range(1, len(data) - 2, 3)
            block.variables += [(data[at + 1] | data[at + 2] << 8, data[at] & 15) for at in whole]
            size = sum(len(packed_value(kind, 0)) for _, kind in block.variables)
            error = NO_MEMORY if size > 26 else 0
        elif command == START:
            block.period, block.due = data[1] / 100.0, self.vehicle.time
        elif command == STOP_LOG:
            block.period = 0.0
        elif command == DELETE:
            self._blocks.pop(number, None)
        return bytes([number, error])

    def _table(self, data: bytes, items: list[bytes], limits: bytes = b"") -> list[bytes]:
        if data[0] == 3:
            return [struct.pack("<BHI", 3, len(items), zlib.crc32(b"".join(items))) + limits]
        if data[0] == 2:
            at = int.from_bytes(data[1:3], "little")
            return [data[:3] + items[at]] if at < len(items) else []
        return []
