"""What counts as a line of code."""

from __future__ import annotations

from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path

loader = SourceFileLoader("size", str(Path(__file__).resolve().parents[1] / "tools" / "size"))
spec = spec_from_loader("size", loader)
assert spec is not None
size = module_from_spec(spec)
loader.exec_module(size)

PYTHON = '''"""A module.

Of two paragraphs.
"""

# why
LIMIT = (
    1,

    2,  # one of them
)


def name() -> str:
    """Its docstring."""
    return """a text
    of two lines"""
'''


def test_blank_lines_comments_and_docstrings_are_no_code() -> None:
    assert size.lines_of_python(PYTHON) == 4 + 3
    assert size.lines_of_c("/* why\n and how */\nint a; // b\n\n// c\nint b; /* d */\n") == 2


def test_every_file_of_a_package_counts_in_its_room(tmp_path: Path) -> None:
    (tmp_path / "room" / "inner").mkdir(parents=True)
    (tmp_path / "top.py").write_text("a = 1\n")
    (tmp_path / "room" / "inner" / "one.py").write_text("a = 1\nb = 2\n")
    (tmp_path / "room" / "two.h").write_text("int a;\n")
    (tmp_path / "room" / "page.css").write_text("body {}\n")
    assert size.sizes(tmp_path) == {tmp_path.name: 1, "room": 3}
