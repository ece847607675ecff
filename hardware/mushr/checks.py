"""What must hold before a drive."""

from collections.abc import Sequence

import numpy as np

from hardware.checks import Check, inside, still, stream
from hardware.interfaces import Reading
from hardware.mushr.link import UNHEARD
from hardware.mushr.pilot import DriveLimits


def checks(readings: Sequence[Reading], limits: DriveLimits) -> list[Check]:
    """Judge what was observed of a car that stands."""
    last, states = readings[-1], np.array([reading.state for reading in readings])
    heard = UNHEARD not in last.flags
    listening = "the car listens" if heard else "nobody listens"
    return [
        stream("motion capture", "pose", "pose_stamp", readings, limits.pose_age),
        still(states[:, :2]),
        inside(states[-1, :2], limits.low, limits.high),
        Check("commands", listening, heard, "start the car's multiplexer; is the topic right?"),
    ]
