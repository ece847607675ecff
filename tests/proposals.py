"""Proposed specifications as a person would accept them."""

from __future__ import annotations


def with_proposed_motors(text: str) -> str:
    """The proposal with the motors' commented order in place of the recorded one; itself where none is proposed."""
    lines = text.splitlines(keepends=True)
    proposed = {line[2:].partition(" ")[0]: line[2:] for line in lines if line.startswith("# motor")}
    kept = [line for line in lines if not line.startswith("# motor")]
    return "".join(proposed.get(line.partition(" ")[0], line) for line in kept)
