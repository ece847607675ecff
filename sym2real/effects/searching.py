"""What a search knows of an effect beside its form: whether it is a candidate, from where, and with what of it free."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import TypeVar

from sympy import Expr

from sym2real.effects.body import Body
from sym2real.effects.inputs import ANGLE
from sym2real.symbolic.expressions import names_in
from sym2real.trajectory import Array, Trajectory

Answer = TypeVar("Answer")

SETTLED = "settled by the checks of the data before the search"
LATER = "tried only where something is left; `sym2real add MODEL EFFECT --fit LOG` tests it alone"
ALONE = "not searched for; `sym2real add MODEL EFFECT --fit LOG` tests it alone"


class Shown(Enum):
    """What a manoeuvre has that shows an effect among those that look like it."""

    YAW = "a heading that turns"
    SPEEDS = "several speeds"
    CLIMBS = "climbs and descents"
    LOW = "heights near the ground"
    DITHER = "commands with dither"
    TIME = "a long time"
    BOTH_WAYS = "turns both ways"
    HARD = "tight turns"
    SWINGING_SPEED = "a speed that swings"


def by_role(answers: Mapping[str, Answer], otherwise: Answer) -> Callable[[Body], Answer]:
    """One answer for each role of the column that an effect is bound to (its field's name), another for the rest."""
    return lambda body: answers.get(body.role, otherwise)


def alone_on(*roles: str) -> Callable[[Body], str]:
    """Not searched for on columns of these roles."""
    return by_role(dict.fromkeys(roles, ALONE), "")


@dataclass(frozen=True)
class Searching:
    """How an effect takes part in a search.

    Args:
        why_not: why a search leaves it out on such a robot and column, "" where it does not.
        stood_for_by: key of the effect that it equals on every flight, so that only that is a candidate; "" for none.
        starts: further starting values of its first parameter, from the values of its column in the logs ``# (rows,)``
            (empty for an effect of no column).
        from_null: whether the null value is a start: false where nothing changes there.
        fixed: parameters that stay at null beside what else competes, from values as before and the logs.
        choices: a parameter that is a choice among few, and its values.
        given: values that it always has in a search, by parameter.
        varying: columns that must vary for it to show; those that it is bound to need no mention.
        sizes: those that a plan tries of an effect that begins at a threshold, the mildest first, from such values.
        shown_in: what manoeuvres show it among its like.
        repeats: whether its first parameter counts what repeats along its joint, which is found before a search.
        attenuated: whether it is a factor on what commands do, which looks smaller where they change between rows.
    """

    why_not: Callable[[Body], str] = lambda _: ""
    stood_for_by: Callable[[Body], str] = lambda _: ""
    starts: Callable[[Body, Array], tuple[float, ...]] = lambda _body, _values: ()
    from_null: bool = True
    fixed: Callable[[Body, Array, Iterable[Trajectory]], tuple[str, ...]] = lambda _body, _values, _logs: ()
    choices: Callable[[Body], tuple[str, tuple[float, ...]]] | None = None
    given: Mapping[str, Expr | float] = field(default_factory=dict)
    varying: tuple[str, ...] = ()
    sizes: Callable[[Body, Array], tuple[float, ...]] = lambda _body, _values: ()
    shown_in: Callable[[Body], tuple[Shown, ...]] = lambda _: ()
    repeats: bool = False
    attenuated: bool = False

    @property
    def swings(self) -> bool:
        """Whether it takes part only where a force that swings was found in the logs."""
        return any(ANGLE in names_in(value) for value in self.given.values() if isinstance(value, Expr))


def steps(*counts: float) -> Callable[[Body, Array], tuple[float, ...]]:
    """Starts at so many control periods."""
    return lambda body, _values: tuple(body.dt * count for count in counts)
