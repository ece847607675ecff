"""What is left after the effects that were found, and where it changes, in words."""

from collections.abc import Sequence
from dataclasses import dataclass

from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.kind import with_unit
from sym2real.trajectory import Array

# Whitened squares per degree of freedom of an answer that leaves something out: null data leave 1.07 at most.
MISFIT = "misfit"
# What a disturbance depends on that each log has of its own.
LOG = "log"


@dataclass(frozen=True)
class Leftover:
    """A disturbance that depends on something, or is the same everywhere: an entry of ``leftovers`` in docs/method.md.

    Args:
        explained_by: the feature it depends on most, "constant", "log" where each has its own, "misfit" where no
            disturbance is left, or where the pieces lie that are unlike all others.
        channel: direction of the disturbance; of a misfit what is predicted so badly, empty for all, and of pieces.
        r2: share of its variance (of its squares, where it is constant) that logs not seen confirm; of its squares that
            are between logs; of a misfit's squares that noise and disturbances do not make; of all squares in pieces.
        term: where the disturbance changes, in words.
        size, unit: of a constant disturbance, as the model lacks it.
        motion: part of the robot's motion that it makes (``features.py``); None of a measurement that is off.
        instead: key of an effect that explains more than the channel's, which was found, in the part of the logs that
            ``explained_by`` names (``part_of_logs.py``); ``r2`` is then how much more.
        faint: beyond chance, and too small a part of the whole loss to be a reason for an answer.
    """

    explained_by: str
    channel: str
    r2: float
    term: str
    size: float | None = None
    unit: str = ""
    motion: float | None = None
    instead: str = ""
    faint: bool = False

    @property
    def unseen(self) -> bool:
        """Whether its share is one of logs that were not seen."""
        return bool(self.channel) and self.explained_by not in (MISFIT, LOG) and not self.instead

    @property
    def matters(self) -> bool:
        """Whether predictions need it, and no honest sensor has it."""
        return not (self.faint or self.usual) and (self.motion is None or self.motion >= SETTINGS.negligible)

    @property
    def usual(self) -> bool:
        """Whether it is no more than a gyro's usual bias."""
        return self.motion is None and self.unit == "rad/s" and abs(self.size or 0.0) <= SETTINGS.sensor_bias


def find_misfit(squares: float, motion: float | None = None) -> tuple[Leftover, ...]:
    """A misfit that neither noise nor disturbances describe; none where the data are explained.

    Args:
        squares: whitened, per degree of freedom.
        motion: part of the robot's motion that the errors make, noise included.
    """
    if squares <= SETTINGS.misfit:
        return ()
    share, words = 1.0 - 1.0 / squares, f"{squares:.2f} whitened squares per degree of freedom"
    return (Leftover(MISFIT, "", share, words, motion=motion and share**0.5 * motion),)


def split_in_words(names: Sequence[str], features: Array, target: Array, unit: str) -> str:
    """The first split of a tree on the signed disturbance, in words."""
    from sklearn.tree import DecisionTreeRegressor  # noqa: PLC0415 — heavy, and only needed at the end

    stump = DecisionTreeRegressor(max_depth=1, min_samples_leaf=len(target) // 20, random_state=0)
    tree = stump.fit(features, target).tree_
    if tree.node_count == 1:  # so few pieces are unlike the others that no split is one
        return f"{with_unit(float(target.mean()), unit)} on average"
    low, high = (float(tree.value[child].item()) for child in (tree.children_left[0], tree.children_right[0]))
    below = f"{with_unit(low, unit)} where {names[tree.feature[0]]} is below {tree.threshold[0]:.3g}"
    return f"{below}, {with_unit(high, unit)} above"
