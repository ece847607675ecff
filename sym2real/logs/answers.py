"""How late a robot answers a command, and whether it goes the other way."""

from dataclasses import dataclass

from sym2real.logs.draft import Draft
from sym2real.logs.reading import WEAK
from sym2real.trajectory import Array

SHORTEST_PULSE, LONGEST_PULSE = 900.0, 2200.0  # µs, of servos and speed controllers


@dataclass(frozen=True)
class Answer:
    """How a robot answers a command, in words for the evidence, and whether it goes the other way."""

    said: str = ""
    reversed: bool = False


def answer_to(draft: Draft, command: Array, response: Array | None) -> Answer:
    """The delay and correlation of a response; nothing where none is known, or it is too weak to count.

    It is reversed where its mean is, too: a car that starts on a circle turns faster and faster, and steers less.
    """
    if response is None:
        return Answer()
    late, found = draft.rows.delay(command, response)
    if abs(found) <= WEAK:
        return Answer()
    said = f"; answered {1e3 * late:.0f} ms later (correlation {found:+.2f})"
    return Answer(said, found < 0 and float(command @ response) < 0)


def turning(draft: Draft, rate: str) -> Array | None:
    """A body rate by attitude or heading, else by the gyro; None where none is known."""
    return draft.turning.get(rate, draft.series(rate) if draft.has(rate) else None)


def are_pulses(values: Array) -> bool:
    """Whether these are pulses in µs, of servos or speed controllers."""
    return bool(((values >= SHORTEST_PULSE) & (values <= LONGEST_PULSE)).all())
