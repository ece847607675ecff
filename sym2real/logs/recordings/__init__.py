"""Files that others record: ROS 1 and ROS 2 bags, MCAP, PX4's ULog, the Crazyflie's card.

A reader takes a path and gives a ``Recording``; :data:`RECORDINGS` lists them by the file's ending.
"""

from collections.abc import Callable
from pathlib import Path

from sym2real.logs.recordings import mcap_file, ros, ulog, usd
from sym2real.logs.recordings.recording import Recording
from sym2real.logs.recordings.ros import is_bag_folder
from sym2real.logs.recordings.usd import is_card_log

RECORDINGS: dict[str, Callable[[Path], Recording]] = {
    ".bag": ros.read,
    ".db3": ros.read,
    ".mcap": mcap_file.read,
    ".ulg": ulog.read,
    ".usd": usd.read,
}

__all__ = ["RECORDINGS", "is_bag_folder", "is_card_log"]
