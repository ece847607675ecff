"""Errors that say what was expected, what was found, and what to try next."""

import difflib
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

MOST_LISTED = 30  # names that an error lists beside those that are near


class Sym2RealError(Exception):
    """Base of every error that a user of this package can cause and can mend."""


class UnknownNameError(Sym2RealError, KeyError):
    """A name that is not in a registry or layout; the message guesses the intent, and lists what is there.

    Args:
        kind: what it would be the name of.
        name: what was given.
        known: what there is; a long list is left out where something is near.
        near: what was likely meant; by default what is spelt like it.
    """

    def __init__(self, kind: str, name: str, known: Iterable[str], near: Iterable[str] | None = None) -> None:
        options = sorted(known)
        near = difflib.get_close_matches(name, options, n=3, cutoff=0.5) if near is None else list(near)
        hint = f"; did you mean {' or '.join(repr(option) for option in near)}?" if near else ""
        listed = "" if near and len(options) > MOST_LISTED else f" (known: {', '.join(options)})"
        self.message = f"unknown {kind} {name!r}{hint}{listed}"
        super().__init__(self.message)

    def __str__(self) -> str:
        return self.message


class DataError(Sym2RealError):
    """A file whose content cannot be used: where in the file, what was expected, what was found.

    Args:
        file: path of the file.
        expected: what a readable file holds there.
        found: what stands there instead.
        row: line of the file, counted from 1 with the header as line 1.
        column: name of the column.
    """

    def __init__(
        self,
        file: str | Path,
        expected: str,
        found: str,
        row: int | None = None,
        column: str | None = None,
    ) -> None:
        self.file, self.expected, self.found, self.row, self.column = file, expected, found, row, column
        place = [str(file)]
        if row is not None:
            place.append(f"row {row}")
        if column is not None:
            place.append(f"column {column!r}")
        super().__init__(f"{', '.join(place)}: expected {expected}, found {found}")


def reason(error: Exception) -> str:
    """What went wrong with a file in the system's words, without the path, which :class:`DataError` names."""
    if isinstance(error, KeyError) and not isinstance(error, Sym2RealError):
        return f"no {error}"
    if isinstance(error, RecursionError):
        return "values that are nested too deeply"
    if isinstance(error, OSError) and error.errno:
        return os.strerror(error.errno)  # pyarrow puts words of its own in place of the system's
    return str(error) or type(error).__name__


class ShapeError(Sym2RealError, ValueError):
    """An array whose shape, columns or units do not fit what it is given to."""


class ModelError(Sym2RealError):
    """Equations or a model that cannot be built, compiled, loaded or trusted."""


class CompilationError(Sym2RealError):
    """A kernel that cannot be compiled here: no compiler, no place for its output, or the compiler's own words."""


class MissingDependencyError(Sym2RealError, ImportError):
    """An optional package or program that is not installed; the message holds the command that installs it."""


@contextmanager
def needing(what: str, extra: str) -> Iterator[None]:
    """Around imports of an extra: says what needs it, and the command that installs it, where it is missing."""
    try:
        yield
    except ImportError as error:
        raise MissingDependencyError(f"{what}: pip install 'sym2real[{extra}]'") from error
