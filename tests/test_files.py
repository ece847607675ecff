"""A file appears whole or not at all, whatever goes wrong while it is written."""

import contextlib
import itertools
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType

import pytest

from sym2real.errors import DataError
from sym2real.files import make_folder, read_object, read_text, read_toml, reading, require_place, whole, write_text


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_file_is_written_and_replaced(tmp_path: Path) -> None:
    file = tmp_path / "new" / "folder" / "file.txt"
    for text in ("erste Fassung: ψ", "second"):
        write_text(file, text)
        assert file.read_text(encoding="utf-8") == text
    assert names(file.parent) == ["file.txt"]


@pytest.mark.parametrize("failure", [ValueError("bad"), KeyboardInterrupt()])
def test_what_fails_half_way_leaves_the_earlier_file_and_nothing_else(tmp_path: Path, failure: BaseException) -> None:
    file = tmp_path / "file.txt"
    file.write_text("earlier")

    def fail() -> None:
        with whole(file) as beside:
            beside.write_text("half")
            raise failure

    with pytest.raises(type(failure)):
        fail()
    assert file.read_text() == "earlier"
    assert names(tmp_path) == ["file.txt"]


def test_ctrl_c_at_any_line_leaves_a_whole_file_or_none(tmp_path: Path) -> None:
    lines = 0
    for line in itertools.count(1):
        place = tmp_path / str(line) / "text"
        # Ctrl-C while Python's rmtree closes a folder can end in an error of the system's instead.
        with contextlib.suppress(KeyboardInterrupt, DataError), interrupted_at(line):
            write_text(place, "whole")
            lines = line
        assert not list(tmp_path.rglob(".writing-*"))
        assert not place.exists() or place.read_text() == "whole"
        if lines:
            break
    assert lines > 20  # lines of this function's own and of those that make, move and remove


@contextlib.contextmanager
def interrupted_at(line: int) -> Iterator[None]:
    """Ctrl-C before the so-manieth line that the writer runs, its helpers in the standard library included."""
    left = itertools.count(line - 1, -1)

    def trace(frame: FrameType, event: str, _: object) -> Callable[..., object]:
        if event == "line" and frame.f_globals.get("__name__") in {"sym2real.files", "shutil"} and next(left) == 0:
            raise KeyboardInterrupt
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        yield
    finally:
        sys.settrace(before)


def test_an_object_is_read_or_refused_with_its_place(tmp_path: Path) -> None:
    file = tmp_path / "object.json"
    write_text(file, '{"ψ": [1, null]}')
    assert read_object(file, "an object") == {"ψ": [1, None]}
    for text, found in (("{broken", "Expecting property name"), ("[1]", r"\[1\]")):
        write_text(file, text)
        with pytest.raises(DataError, match=rf"object\.json: expected an object, found {found}"):
            read_object(file, "an object")
    with pytest.raises(DataError, match="found No such file"):
        read_object(tmp_path / "none.json", "an object")


def test_places_where_no_file_can_be_are_named(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(DataError, match=r"taken/file\.txt: expected a file that can be written"):
        write_text(tmp_path / "taken" / "file.txt", "")
    (tmp_path / "folder").mkdir()
    with pytest.raises(DataError, match=r"folder: expected a file that can be written, found Is a directory"):
        write_text(tmp_path / "folder", "")
    with pytest.raises(DataError, match="taken: expected a folder that can be written to, found File exists"):
        make_folder(tmp_path / "taken")
    assert names(tmp_path) == ["folder", "taken"]


def test_places_are_refused_before_the_work_and_nothing_is_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / "folder").mkdir()
    for path, folder in (("file", False), ("folder", True), ("new/one", True), ("new/file.json", False)):
        require_place(tmp_path / path, folder=folder)
    for path, folder, found in (
        ("file", True, "found a file"),
        ("folder", False, "found a folder"),
        ("file/below/it", True, "file is a file"),
    ):
        with pytest.raises(DataError, match=found):
            require_place(tmp_path / path, folder=folder)
    assert names(tmp_path) == ["file", "folder"]


@pytest.mark.skipif(sys.platform == "win32", reason="there are no named pipes in folders")
def test_a_pipe_is_refused_and_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.json")
    for read in (read_object, read_toml, read_text):
        with pytest.raises(DataError, match=r"pipe\.json: expected a file, found a pipe"):
            read(tmp_path / "pipe.json", "words")


def test_links_that_lead_to_themselves_are_no_place(tmp_path: Path) -> None:
    (tmp_path / "loop").symlink_to("loop")
    with reading({"logs": [tmp_path]}), pytest.raises(DataError, match=r"new: expected a file that can be written"):
        write_text(tmp_path / "loop" / "new", "")
