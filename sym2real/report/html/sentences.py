"""Remarks that other rooms write in lower case, as sentences."""

from collections.abc import Iterable


def sentence(remark: str) -> str:
    """A remark with a capital letter, unless its first word is a name: of a column, an effect or a log."""
    first, _, _ = remark.partition(" ")
    return remark[:1].upper() + remark[1:] if first.isalpha() else remark


def sentences(remarks: Iterable[str]) -> list[str]:
    """Every remark as a sentence."""
    return [sentence(remark) for remark in remarks]
