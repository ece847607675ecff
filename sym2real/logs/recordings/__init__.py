"""Files that others record: ROS 1 and ROS 2 bags, MCAP, PX4's ULog.

A reader takes a path and gives a :class:`Recording`; :data:`RECORDINGS` lists them by the file's ending.
"""

from collections.abc import Callable
from pathlib import Path

from sym2real.logs.recordings import mcap_file, ros, ulog
from sym2real.logs.recordings.recording import BY_NAMES, Recording, Said, Topic
from sym2real.logs.recordings.ros import is_bag_folder

RECORDINGS: dict[str, Callable[[Path], Recording]] = {
    ".bag": ros.read,
    ".db3": ros.read,
    ".mcap": mcap_file.read,
    ".ulg": ulog.read,
}

__all__ = ["BY_NAMES", "RECORDINGS", "Recording", "Said", "Topic", "is_bag_folder"]
