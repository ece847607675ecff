"""Manoeuvres that tell effects apart, and what each of them shows."""

from dataclasses import dataclass

from sym2real.effects.searching import Shown
from sym2real.tasks.standard_paths import Manoeuvre
from sym2real.vocabulary import RATE_COMMAND, SPEED_COLUMN, STEER_COLUMN, THRUST_COLUMN

SECONDS, LONG = 8.0, 16.0
# White dither on the commands of every manoeuvre: thrust N and rates rad/s; steering rad and speed m/s. And more of it.
DITHER = {THRUST_COLUMN: 0.005, **dict.fromkeys(RATE_COMMAND.columns, 0.05), STEER_COLUMN: 0.01, SPEED_COLUMN: 0.03}
MORE = 6.0


@dataclass(frozen=True)
class Trial:
    """A manoeuvre that may tell effects apart.

    Args:
        words: what is flown, for a sentence.
        paths: its parts.
        shows: what it is made for; it is flown first where an effect that this shows is in question.
        yaw_rate: of a quadrotor's heading in rad/s.
        dither: factor on :data:`DITHER`.
        seconds: of every part.
    """

    words: str
    paths: tuple[Manoeuvre, ...]
    shows: Shown
    yaw_rate: float = 0.0
    dither: float = 1.0
    seconds: float = SECONDS


HOVER = Manoeuvre("hover", height=0.6)
BOTH_WAYS, TIGHT = (
    tuple(Manoeuvre("circle", size, speed, clockwise=clockwise) for clockwise in (False, True))
    for size, speed in ((1.5, 1.0), (1.2, 1.9))
)
TRIALS = {
    "flight": (
        Trial("hover with a heading that turns at 0.6 rad/s", (HOVER,), Shown.YAW, yaw_rate=0.6),
        Trial(
            "circles at 0.5, 1 and 1.5 m/s",
            tuple(Manoeuvre("circle", 0.7, v, 0.6) for v in (0.5, 1.0, 1.5)),
            Shown.SPEEDS,
        ),
        Trial("climbs and descents by 0.3 m", (Manoeuvre("hover", height=0.8, swing=0.3),), Shown.CLIMBS),
        Trial(
            "low flight whose height moves between 0.08 and 0.2 m",
            (Manoeuvre("hover", height=0.14, swing=0.06),),
            Shown.LOW,
        ),
        Trial("hover with rate commands that are dithered by 0.3 rad/s", (HOVER,), Shown.DITHER, dither=MORE),
        Trial("16 s of hover in one go", (HOVER,), Shown.TIME, seconds=LONG),
    ),
    "drive": (
        Trial("circles of 1.5 m both ways", BOTH_WAYS, Shown.BOTH_WAYS),
        Trial(
            "wide circles at 0.5 to 2 m/s",
            tuple(Manoeuvre("circle", 3.0, v) for v in (0.5, 1.0, 1.5, 2.0)),
            Shown.SPEEDS,
        ),
        Trial("tight circles both ways at 3 m/s²", TIGHT, Shown.HARD),
        Trial(
            "figures of eight whose speed swings by a third",
            (Manoeuvre("eight", 2.0, 1.2, modulation=0.33),),
            Shown.SWINGING_SPEED,
        ),
        Trial("commands that are dithered", (Manoeuvre("circle", 2.0, 1.0),), Shown.DITHER, dither=MORE),
    ),
}
