"""What a verb reads is kept: nothing is written over it, whichever option names the place.

A verb's fields say what it reads and what it writes: :data:`WRITTEN` are written, every other
:class:`Path` and every :data:`Place` is read.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import combinations
from pathlib import Path
from typing import Annotated, Any, get_args, get_type_hints

from sym2real.cli.output import STANDARD_OUTPUT
from sym2real.errors import DataError, ModelError
from sym2real.files import read_by, reading, require_place, same_place

IS_PLACE = "may name a file or a folder that is read"
Place = Annotated[str, IS_PLACE]
WRITTEN = ("out", "json", "report")


@contextmanager
def kept_apart(verb: Any) -> Iterator[None]:
    """Refuse places of :data:`WRITTEN` before the work where nothing may be written, and while it lasts.

    Args:
        verb: with ``json`` and perhaps ``report`` and ``out``: a folder unless ``OUT_IS_FILE``, a new or empty one
            where ``OUT_IS_NEW``, a log where ``OUT_IS_LOG``; ``FOLDERS`` are those inside it that get files too.

    Raises:
        DataError: naming the place, which cannot be written to, or is read by the same command.
        ModelError: for a file that a saved model consists of.
    """
    with reading(places_read(verb)):
        _require_places(verb)
        yield


def places_read(verb: Any) -> dict[str, list[Path]]:
    """The files and folders that a verb is given to read, by the name of the field that names them."""
    places: dict[str, list[Path]] = {}
    for name, hint in get_type_hints(type(verb), include_extras=True).items():
        if name not in WRITTEN and _names_places(hint):
            value = getattr(verb, name)
            given = value if isinstance(value, tuple) else (value,)
            places[name] = [Path(entry) for entry in given if entry is not None and there(Path(entry))]
    return places


def _names_places(hint: Any) -> bool:
    """Whether a type is that of places: a path, a place, or holds either."""
    inside = (*get_args(hint), *getattr(hint, "__metadata__", ()))
    return (
        hint is Path or IS_PLACE in inside or any(_names_places(part) for part in inside if not isinstance(part, str))
    )


def there(path: Path) -> bool:
    """Whether it is a place that exists."""
    try:
        return path.exists()
    except (OSError, ValueError):  # too long for a file's name, or with a zero byte: it is a name of something else
        return False


def _require_places(verb: Any) -> None:
    out, is_file = getattr(verb, "out", None), getattr(verb, "OUT_IS_FILE", False)
    named = {f"--{name}": getattr(verb, name, None) for name in WRITTEN if is_file or name != "out"}
    files = {option: file for option, file in named.items() if file not in (None, STANDARD_OUTPUT)}
    if out is not None and not is_file:
        require_place(out, folder=True)
        for place in (*(out / inside for inside in getattr(verb, "FOLDERS", ())), out):
            _require_unread("--out", place)
        if getattr(verb, "OUT_IS_NEW", False):
            _require_empty(out)
    for option, file in files.items():
        require_place(file, folder=False)
        _require_unread(option, file)
        _require_nothing_is_lost(option, file, log_for_log=option == "--out" and getattr(verb, "OUT_IS_LOG", False))
        if option != "--out" and out is not None and same_place(file.parent, out):
            _require_no_name_of_a_model(option, file)
    for (option, file), (other, place) in combinations(files.items(), 2):
        if same_place(file, place):
            raise DataError(file, f"a file of its own for {option}", f"the file that {other} names")


def _require_unread(option: str, place: Path) -> None:
    if reader := read_by(place):
        raise DataError(
            place, f"another place for {option}", f"what this command reads as {reader}, which would be lost"
        )


def _require_empty(folder: Path) -> None:
    """A model neither takes another's place nor lies among other files."""
    there = sorted(path.name for path in folder.iterdir()) if folder.is_dir() else []
    if there:
        held = f"{', '.join(there[:3])}{', …' if len(there) > 3 else ''}"
        raise DataError(folder, "a new or empty folder for --out", f"{held} in it; name another, or delete it first")


def _require_nothing_is_lost(option: str, file: Path, *, log_for_log: bool) -> None:
    """A measurement cannot be made again: only another log takes its place; nor may a model lose a part."""
    if not file.exists():
        return
    from sym2real.logs.table import IN_FOLDERS
    from sym2real.symbolic.storage import is_part_of_model

    if file.suffix.lower() in IN_FOLDERS and not log_for_log:
        raise DataError(file, f"a place for {option} that is no log's", "a log, which would be lost")
    if is_part_of_model(file):
        raise ModelError(f"{option}: {file} is a part of a model, which would be lost; name another file")


def _require_no_name_of_a_model(option: str, file: Path) -> None:
    from sym2real.symbolic.storage import PARTS, TRAINING

    if file.name in (*PARTS, TRAINING):
        raise DataError(file, f"a name for {option} that no file of a model has", repr(file.name))
