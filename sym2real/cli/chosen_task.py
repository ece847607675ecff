"""A task with its options as a user types them: ``circle radius=2``, ``regulate q1=0.8``."""

import inspect
from collections.abc import Sequence

from sym2real.cli.typed_values import with_values
from sym2real.errors import ModelError, UnknownNameError
from sym2real.robots import Robot
from sym2real.tasks import TASKS, Task, make_task
from sym2real.tasks.regulate import regulate

NUMBERS = (float, bool, float | None)


def chosen_task(name: str, options: Sequence[str], robot: Robot) -> Task:
    """The task of that name for a robot.

    Args:
        name: of the task.
        options: each ``OPTION=VALUE``, of those that are numbers; of ``regulate`` the goals of columns as well.
        robot: that is to do it.

    Raises:
        UnknownNameError: for a task, an option or a column that does not exist.
        ModelError: for what is no option with its value.
        ShapeError: when the robot cannot be given this task.
    """
    (task, values), *others = with_values([name, *options], "a task")
    if others:
        raise ModelError(f"{task}: expected OPTION=VALUE behind the task, found {others[0][0]!r}")
    parameters = inspect.signature(TASKS[task]).parameters
    numbers = [option for option, parameter in parameters.items() if parameter.annotation in NUMBERS]
    given = {option: value for option, value in values.items() if option in numbers}
    goals = {option: value for option, value in values.items() if option not in numbers}
    if goals and TASKS[task] is regulate:
        return make_task(task, robot, goal=goals, **given)
    if goals:
        raise UnknownNameError(f"option of {task} that is a number", next(iter(goals)), numbers or ["none"])
    for option, value in given.items():
        if parameters[option].annotation is bool and value not in (0, 1):
            raise ModelError(f"{task}: expected {option}=1 or {option}=0, found {value:g}")
    return make_task(task, robot, **given)
