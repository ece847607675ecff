"""Effects and tasks with their values as a user types them: ``wind fx=0.02 slope gx=1``, ``circle radius=2``."""

import inspect
import math
from collections.abc import Callable, Mapping, Sequence

from rich.console import Console

from sym2real.cli.numbers import number_of
from sym2real.effects import Effect, catalogue
from sym2real.effects.body import Describable
from sym2real.effects.kind import Parameter
from sym2real.errors import ModelError, UnknownNameError
from sym2real.robots import Robot
from sym2real.tasks import TASKS, Task, make_task
from sym2real.tasks.regulate import regulate
from sym2real.vocabulary import UNLIMITED

NUMBERS = (float, bool, float | None)


def with_values(
    texts: Sequence[str], what: str, parameter_of: Callable[[str], str] = lambda _: "OPTION"
) -> list[tuple[str, dict[str, float]]]:
    """Every name with the values that follow it.

    Args:
        texts: names, each followed by its ``PARAMETER=VALUE``.
        what: a name is the name of, for the error's words.
        parameter_of: the parameter that a number after a name may have been meant for.

    Raises:
        ModelError: when a value stands before the first name, without its parameter, is given twice or is not a number.
    """
    chosen: list[tuple[str, dict[str, float]]] = []
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals and chosen and not math.isnan(number_of(text)):
            key = chosen[-1][0]
            raise ModelError(f"expected `{key} {parameter_of(key)}={text}`, found {text!r} alone")
        if not equals:
            chosen.append((text, {}))
        elif not name:
            raise ModelError(f"expected PARAMETER=VALUE, found {text!r}")
        elif chosen:
            key, values = chosen[-1]
            if name in values:
                raise ModelError(f"{key}: expected {name} once, found {name}={values[name]:g} and {text}")
            values[name] = number = number_of(value)
            if not math.isfinite(number):
                raise ModelError(f"parameter {name!r}: expected a number, found {value!r}")
        else:
            raise ModelError(f"expected {what} before its values, found {text!r}")
    return chosen


def chosen_effects(texts: Sequence[str], described: Describable) -> list[tuple[Effect, dict[str, float]]]:
    """Every effect with the values that follow its key.

    Args:
        texts: keys, ``KIND`` or ``KIND:COLUMN``, each followed by its ``PARAMETER=VALUE``.
        described: the robot or the equations that they are for.

    Raises:
        ModelError: when a value stands before the first key or is not a number, or an effect does not apply or is named
            twice.
        UnknownNameError: for a kind or column that does not exist.
    """
    named = with_values(texts, "the name of an effect", lambda key: catalogue.effect(key, described).parameters[0].name)
    keys = [key for key, _ in named]
    for key in keys:
        if keys.count(key) > 1:
            raise ModelError(f"{key}: expected once with all its values behind it, found {keys.count(key)} times")
    chosen = [(catalogue.effect(key, described), values) for key, values in named]
    for chosen_effect, _ in chosen:
        if reason := catalogue.refusal(chosen_effect, described):
            raise ModelError(reason)
    return chosen


def require_values(chosen: Sequence[tuple[Effect, Mapping[str, float]]], otherwise: str = "") -> None:
    """Refuse effects without a value, which would change nothing.

    Args:
        chosen: effects with their values.
        otherwise: what else the user can give, for the error's words.

    Raises:
        ModelError: with the parameters that an effect has, their units and bounds.
    """
    for effect, values in chosen:
        if not values:
            known = "; ".join(f"{parameter.name}=… {_unit_and_bounds(parameter)}" for parameter in effect.parameters)
            raise ModelError(f"{effect.key}: expected a value ({known}){otherwise}, found none")


def warn_of_values(chosen: Sequence[tuple[Effect, Mapping[str, float]]], console: Console) -> None:
    """A line per value outside the bounds that the catalogue gives it for this robot; impossible ones are errors."""
    for effect, values in chosen:
        for parameter in effect.parameters:
            value = values.get(parameter.name, math.nan)
            if value in parameter.domain and not parameter.low <= value <= parameter.high:
                text = f"{effect.key} {parameter.name}={value:g} is outside what is likely here"
                console.print(f"warning: {text}: {_unit_and_bounds(parameter)}", markup=False)


def _unit_and_bounds(parameter: Parameter) -> str:
    unit = "without unit," if parameter.unit == "1" else f"in {parameter.unit},"
    bounds = [
        f"{word} {bound:.3g}"
        for word, bound in (("from", parameter.low), ("to", parameter.high))
        if abs(bound) < UNLIMITED
    ]
    return " ".join((unit, *bounds))


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
