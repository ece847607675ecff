"""Tasks: references over time and their running cost, by name.

>>> TASKS["circle"](ROBOTS["mushr"], radius=2.0).name
'circle'
"""

from collections.abc import Callable
from typing import Any

from sym2real.registry import Registry
from sym2real.robots.robot import Robot
from sym2real.tasks import circle, hover, lemniscate, park, regulate, track
from sym2real.tasks.hover import unseen_goal as unseen_goal
from sym2real.tasks.task import Task as Task

TASKS: Registry[Callable[..., Task]] = Registry(
    "task",
    {
        "hover": hover.hover,
        "circle": circle.circle,
        "lemniscate": lemniscate.lemniscate,
        "track": track.track,
        "park": park.park,
        "reverse_circle": circle.reverse_circle,
        "regulate": regulate.regulate,
    },
)


def make_task(name: str, robot: Robot, **options: Any) -> Task:
    """The task of that name for a robot; options are the arguments of the function in :data:`TASKS`.

    Raises:
        UnknownNameError: when there is no such task.
        ShapeError: when the robot cannot be given this task.

    Examples:
        >>> make_task("hover", ROBOTS["crazyflie"]).name
        'hover'
    """
    return TASKS[name](robot, **options)
