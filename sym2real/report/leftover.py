"""What is left beside an answer, for a sentence."""

from sym2real.diagnosis.unexplained.leftover import LOG, MISFIT, Leftover
from sym2real.effects import EFFECTS
from sym2real.effects.kind import with_unit
from sym2real.vocabulary import is_push


def statement(left: Leftover) -> str:
    """What is left."""
    if left.explained_by == MISFIT:
        of = f" of {left.channel}" if left.channel else ""
        beside = "noise alone" if left.channel else "noise and disturbances"
        return f"an error{of} {max(1 - left.r2, 1e-12) ** -0.5:.2f} times that of {beside}"
    if not left.channel:
        return f"an error where {left.explained_by}, in pieces that are unlike all others"
    if left.instead:
        return f"what {left.instead} {left.explained_by} explains better than {left.channel}"
    what, by = ("disturbance along", "of") if is_push(left.channel.partition(" ")[0]) else ("change of", "by")
    if left.size is not None:
        return f"a constant {what} {left.channel} {by} {with_unit(left.size, left.unit)}"
    how = "differs from log to log" if left.explained_by == LOG else f"depends on {left.explained_by}"
    return f"a {what} {left.channel} that {how}"


def measure(left: Leftover, by: str = "") -> str:
    """How much of what is left that is, in words, with what tells where it is no fit of its own."""
    much = f"R² {left.r2:.2f}" if left.unseen else f"{100 * left.r2:.0f} % of the squares"
    if left.unseen and left.channel.partition(":")[0] in EFFECTS:
        much = f"confirmed to {100 * left.r2:.0f} %"  # what is left of an effect varies with nothing else
    much += by if left.unseen else ""
    part = "a small part of the errors" if left.faint else f"{100 * (left.motion or 0.0):.1g} % of the motion"
    why = "no more than gyros have" if left.usual else f"{part}: too small to matter"
    return much if left.matters else f"{much}, and {why}"
