"""How the logs that are judged were read: the columns and axes that a user's advice must be in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from sym2real.dataset import Dataset


@dataclass(frozen=True)
class AsRead:
    """The columns of the files behind the standard ones.

    Args:
        sources: as of :class:`~sym2real.Trajectory`; nothing where nobody knows.
    """

    sources: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, data: Dataset) -> AsRead:
        """Of logs that were read alike."""
        return cls(data[0].sources)

    def column(self, name: str) -> str:
        """The file's column of a standard one, by which that goes where there is no other."""
        return self.sources.get(name, name).removeprefix("-")

    def columns(self, names: Sequence[str]) -> tuple[str, ...]:
        """The files' columns of several standard ones, each once."""
        return tuple(dict.fromkeys(map(self.column, names)))

    def sign(self, name: str) -> int:
        """-1 where the axes of the log turn the sign of a standard column."""
        return -1 if self.sources.get(name, "").startswith("-") else 1

    def scale(self, factor: float) -> str:
        """The entry of a specification by which a column's numbers are multiplied."""
        return f"scale = {factor:.4g} (times one that it has)"

    @property
    def frame(self) -> str:
        """A remark on signs where nobody knows the log's own axes."""
        return "" if self.sources else " (signs as of z up, and forward, left, up of the body)"
