"""Remarks that other rooms write in lower case, as sentences."""

from collections.abc import Iterable

from rich.text import Text


def sentence(remark: str) -> str:
    """A remark with a capital letter, unless its first word is a name: of a column, an effect or a log."""
    first, _, _ = remark.partition(" ")
    return remark[:1].upper() + remark[1:] if first.isalpha() else remark


def sentences(remarks: Iterable[str]) -> list[str]:
    """Every remark as a sentence."""
    return [sentence(remark) for remark in remarks]


def plain(markup: str | None) -> str:
    """What the terminal shows of a text with rich's markup, in one line; "" for None."""
    return " ".join(Text.from_markup(markup or "").plain.split("\n"))
