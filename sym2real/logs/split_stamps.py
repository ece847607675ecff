"""Stamps that a file holds in two columns, as ROS' messages do: whole seconds, and the nanoseconds since."""

import re
from collections.abc import Mapping

from sym2real.trajectory import Array

SECONDS = re.compile(r"((.*?)[._/]?)secs?")
NANOSECONDS = ("nanosec", "nsecs", "nsec")


def whole_stamps(columns: Mapping[str, Array]) -> dict[str, Array]:
    """The columns ``# (rows,)``, where both halves of a stamp stand one column in s in the place of the first.

    It is called what both names begin with, ``header.stamp``, or ``stamp``.
    """
    joined = dict[str, Array]()
    halves = set[str]()
    for name, values in columns.items():
        found = SECONDS.fullmatch(name)
        beside = [found[1] + word for word in NANOSECONDS if found[1] + word in columns] if found else []
        whole = (found[2] or "stamp") if found and beside else name
        if whole == name or whole in columns:
            joined[name] = values
        else:
            joined[whole] = values + 1e-9 * columns[beside[0]]
            halves.add(beside[0])
    return {name: values for name, values in joined.items() if name not in halves}
