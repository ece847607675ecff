"""Files that appear whole or not at all: written beside their place, then moved there; and how JSON is read back."""

import difflib
import json
import os
import secrets
import shutil
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path
from typing import Any, TypeVar

from sym2real.errors import DataError, reason

Kind = TypeVar("Kind")

# By what marks it on the disk, or by its name: who reads a file or folder.
_READ: ContextVar[dict[object, str]] = ContextVar("what is read")


@contextmanager
def reading(places: Mapping[str, Iterable[Path]]) -> Iterator[None]:
    """While it lasts nothing is written over these files, or over those that lie in these folders now.

    Args:
        places: files and folders that exist, by the name of what reads them.
    """
    read: dict[object, str] = {}
    for reader, paths in places.items():
        for path in paths:
            inside = [file for file in path.iterdir() if file.is_file()] if path.is_dir() else []
            read |= {mark: reader for place in (path, *inside) for mark in _marks(place)}
    token = _READ.set(read)
    try:
        yield
    finally:
        _READ.reset(token)


def read_by(path: str | Path) -> str:
    """The name of what reads this very file or folder, under :func:`reading`; empty where nothing does."""
    read = _READ.get({})
    return next((read[mark] for mark in _marks(Path(path)) if mark in read), "")


def same_place(first: Path, second: Path) -> bool:
    """Whether two names are those of one file or folder, whether it is there or not."""
    return not set(_marks(first)).isdisjoint(_marks(second))


def _marks(path: Path) -> list[object]:
    """The name of a file or folder, links above it followed, and its number on the disk, which links of it share."""
    marks: list[object] = []
    with suppress(OSError, RuntimeError):  # Python's word for links that lead to themselves
        marks.append(path.parent.resolve() / path.name if path.name else path.resolve())
    with suppress(OSError):
        status = path.stat()
        marks.append((status.st_dev, status.st_ino))
    return marks


@contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """Where to write a file of that name; it takes its place in the end, and is gone where writing fails.

    Args:
        path: the file's place; its folder is made where it is missing.

    Raises:
        DataError: when there is no writing there, or something that is read lies there (see :func:`reading`).
    """
    target = Path(path)
    if reader := read_by(target):
        raise DataError(target, "another file to write to", f"what this command reads as {reader}, which would be lost")
    made = [place for place in target.parents if not place.exists()]
    folder = target.parent / f".writing-{secrets.token_hex(4)}"
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            try:
                folder.mkdir()
                yield folder / target.name
                (folder / target.name).replace(target)
            finally:
                shutil.rmtree(folder, ignore_errors=True)
        finally:  # once more: Ctrl-C may have come in the midst of it
            shutil.rmtree(folder, ignore_errors=True)
    except BaseException as error:
        for place in made:
            with suppress(OSError):
                place.rmdir()
        if isinstance(error, OSError):
            raise DataError(target, "a file that can be written", reason(error)) from error
        raise


def make_folder(path: str | Path) -> Path:
    """Make a folder, and those above it, where it is missing.

    Raises:
        DataError: when it cannot be made.
    """
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DataError(path, "a folder that can be written to", reason(error)) from error
    return Path(path)


def write_text(path: str | Path, text: str) -> None:
    """Write a text in UTF-8, whole or not at all; arguments and errors as of :func:`whole`."""
    with whole(path) as beside:
        # A file's name may hold bytes that are no text.
        beside.write_text(text, encoding="utf-8", errors="backslashreplace")


def read_object(path: str | Path, what: str) -> dict[str, Any]:
    """The JSON object that a file holds.

    Args:
        path: of the file.
        what: it holds, for the error's words.

    Raises:
        DataError: when it cannot be read, or holds something else.
    """
    try:
        content = json.loads(read_text(path, what))
    except (ValueError, RecursionError) as error:
        raise DataError(path, what, reason(error)) from error
    if not isinstance(content, dict):
        raise DataError(path, what, f"{content!r:.80}")
    return content


def read_as(path: str | Path, kind: type[Kind], what: str) -> Kind:
    """The JSON object that a file holds, as an object of a class with annotations.

    Null, which JSON has for a number that is none, is the field's default. Arguments and errors as of
    :func:`read_object`.
    """
    import msgspec  # noqa: PLC0415 — the help of the command line does not wait for it

    try:
        return msgspec.convert(_without_null(read_object(path, what)), kind)
    except ValueError as error:
        raise DataError(path, what, str(error)) from error


def _without_null(content: Any) -> Any:
    if isinstance(content, dict):
        return {name: _without_null(value) for name, value in content.items() if value is not None}
    return [_without_null(value) for value in content] if isinstance(content, list) else content


def read_toml(path: str | Path, what: str) -> dict[str, Any]:
    """The table that a TOML file holds; arguments and errors as of :func:`read_object`."""
    try:
        return tomllib.loads(read_text(path, what))
    except (ValueError, RecursionError) as error:
        raise DataError(path, what, reason(error)) from error


def read_text(path: str | Path, what: str) -> str:
    """The text of a file in UTF-8.

    Args:
        path: of the file.
        what: it is expected to be, for the error.

    Raises:
        DataError: when it cannot be read; for a pipe, which would be waited for, or a device, which may never end.
    """
    refuse_pipe(path)
    try:
        return Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(path, what, reason(error)) from error


def refuse_pipe(path: str | Path) -> None:
    """Refuse what would be waited for or never ends; errors as of :func:`require_file`."""
    if Path(path).is_fifo() or Path(path).is_char_device():
        require_file(path)


def require_file(path: str | Path) -> None:
    """Refuse what is not there, and what never ends or blocks: a folder, a pipe, a device.

    Raises:
        DataError: naming what is there.
    """
    place = Path(path)
    if place.is_file():
        return
    kinds = {"a folder": place.is_dir, "a pipe": place.is_fifo, "a device": place.is_char_device}
    there = next((words for words, holds in kinds.items() if holds()), "")
    raise DataError(place, "a file", there or f"nothing of that name{meant(place)}")


def meant(path: Path) -> str:
    """Which file beside a path that is none may have been meant, in words."""
    with suppress(OSError, ValueError):
        near = difflib.get_close_matches(str(path), map(str, path.parent.iterdir()), n=1, cutoff=0.8)
        return f"; did you mean {near[0]}?" if near else ""
    return ""


def require_place(path: str | Path, *, folder: bool) -> None:
    """Refuse a place that nothing can be written to, before the work whose result is to go there; nothing is made.

    Args:
        path: of a folder or a file, which need not exist.
        folder: which of the two it is to be.

    Raises:
        DataError: when the other one is there, or the nearest folder above is none or may not be written to.
    """
    place = Path(path)
    if place.exists() and place.is_dir() != folder:
        wanted, there = ("folder", "file") if folder else ("file", "folder")
        raise DataError(place, f"a {wanted}, or a name that is free", f"a {there}")
    above = next(
        parent for parent in (place, *place.absolute().parents) if parent.exists() and (folder or parent != place)
    )
    if not above.is_dir():
        raise DataError(place, "a place inside folders", f"{above} is a file")
    if not os.access(above, os.W_OK):
        raise DataError(place, "a place that can be written to", f"{above} may not be written to")
