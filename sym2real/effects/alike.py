"""Conditions under which effects look alike, each with a name that effects say they belong to."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from sym2real.effects import manoeuvres
from sym2real.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class Alike:
    """What makes some effects one.

    Args:
        while_: the condition under which they cannot be told apart.
        holds: whether logs show that condition; None where only a fit can say.
        one_of: where it holds only one of them can be found: the other would fit what neither of them models.
        counts: whether they count as each other also where nobody looks at the condition. Of those that are equal on
            such logs only, and that a fit tells apart elsewhere, the first is named.
    """

    while_: str
    holds: Callable[[Iterable[Trajectory]], bool] | None = None
    one_of: bool = False
    counts: bool = True


@dataclass(frozen=True)
class Member:
    """An effect's place among those that look alike.

    Args:
        of: what makes them one.
        place: in their order; the first is the one that is named.
        on: column, or a pattern of columns, that the effect is bound to; "" for none.
    """

    of: Alike
    place: int
    on: str = ""


ONE_STRENGTH = Alike("no motor's torque is predicted", manoeuvres.no_motor_torques)
ONE_THRUST = Alike("thrust stays near one value", manoeuvres.steady_thrust_alone)
ONE_TORQUE = Alike("always", manoeuvres.always)
ONE_TORQUE_AT_ONE_THRUST = Alike("thrust hardly varies")
ONE_TURN = Alike("speed is low")
ONE_PULL = Alike("a loop controls the speed, in one direction", manoeuvres.one_direction)
ONE_LEAN = Alike("yaw stays", manoeuvres.steady_yaw, one_of=True)
ONE_FORCE = Alike("always", manoeuvres.always)
ONE_HEADING = Alike("the car drives one circle", manoeuvres.one_circle)
ONE_LAG = Alike("the rate commands carry no dither", manoeuvres.calm_rates)
ONE_DELAY = Alike("only that command is excited")
ONE_BRAKE = Alike("the tyres hold", manoeuvres.tyres_hold)
# The law that holds at the speeds of small robots is named (rotors in inflow, G. Hoffmann et al., AIAA 2007-6461), and
# the mass, because near one thrust every thrust map is a gain; a steering gain, a lever arm and a lag of the steering,
# because at one speed tyres turn the car by one part less, move it by one arm, and are late by one time.
ONE_DRAG = Alike("speed stays near one value", manoeuvres.one_speed, one_of=True, counts=False)
ONE_MAP = Alike("thrust stays near one value", manoeuvres.steady_thrust_alone, one_of=True, counts=False)
# Where motors turn the body as well, their torques tell what scales them from what does not.
ONE_LIFT = Alike("thrust stays near one value", manoeuvres.steady_thrust, one_of=True, counts=False)
ONE_ROTOR = Alike("thrust stays near one value", manoeuvres.steady_thrust, one_of=True, counts=False)
ONE_STEERING = Alike("speed stays near one value", manoeuvres.one_speed, one_of=True, counts=False)
ONE_ARM = Alike("speed stays near one value", manoeuvres.one_speed, one_of=True, counts=False)
ONE_WAY_TO_TURN = Alike("speed stays near one value", manoeuvres.one_speed, one_of=True, counts=False)
ONE_CURVE = Alike("the car drives one circle", manoeuvres.one_circle, one_of=True, counts=False)
ALL = (
    *(ONE_STRENGTH, ONE_THRUST, ONE_TORQUE, ONE_TORQUE_AT_ONE_THRUST, ONE_TURN, ONE_PULL, ONE_LEAN, ONE_FORCE),
    *(ONE_HEADING, ONE_LAG, ONE_DELAY, ONE_BRAKE, ONE_DRAG, ONE_MAP, ONE_LIFT, ONE_ROTOR),
    *(ONE_STEERING, ONE_ARM, ONE_WAY_TO_TURN, ONE_CURVE),
)
