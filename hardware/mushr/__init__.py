"""The MuSHR racecar: Ackermann commands out, poses in."""

from hardware.mushr.limits import CarLimits
from hardware.mushr.link import MushrLink
from hardware.mushr.pilot import DriveLimits, DrivePilot

__all__ = ["CarLimits", "DriveLimits", "DrivePilot", "MushrLink"]
