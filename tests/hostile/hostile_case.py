"""A hostile case: what is done to a copy of the world, what is typed then, and what an answer must hold."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from random import Random

from hostile_world import READERS


@dataclass(frozen=True)
class Case:
    """One run of the command line on something damaged.

    Args:
        arguments: what is typed after the program's name, in the folder.
        named: patterns, each of which an error must hold: the file or option, the place in it where it has one, and
            what is wrong there; none where nothing is missing, so that an error is a failure.
        told: pattern of the words for this damage and its place, where another answer may be given; the answer to the
            undamaged file must lack them. Empty where no other answer may be given.
        reads: what of ``READERS`` the answer is held against; empty where only an error will do.
        renamed: whether names in the answer differ, so that its figures alone are compared.
        encoding: of standard output.
    """

    arguments: tuple[str, ...]
    named: tuple[str, ...]
    told: str = ""
    reads: str = ""
    renamed: bool = False
    encoding: str = "utf-8"


Maker = Callable[[Path, Random], Case]
KINDS: dict[str, Maker] = {}


def kind(name: str) -> Callable[[Maker], Maker]:
    """Register what makes a case of that kind in a folder that holds a copy of the world."""

    def register(make: Maker) -> Maker:
        KINDS[name] = make
        return make

    return register


def reading(target: str, *named: str, told: str = "", renamed: bool = False) -> Case:
    """The case that reads one of the world's files, whose answer is known."""
    return Case(READERS[target], named, told, target, renamed)
