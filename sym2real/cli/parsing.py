"""From what is typed to a verb: numbers with errors for people, and help that fits 80 columns."""

import contextlib
import io
import re
import shutil
import sys
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any, get_args

import tyro
from tyro.constructors import ConstructorRegistry, PrimitiveConstructorSpec, PrimitiveTypeInfo

from sym2real.cli.numbers import option
from sym2real.cli.terminal import Held, put, say_error

WIDTH = 80
BOX = "╭│╰"  # what tyro wraps itself
WANTED = {
    float: ("FLOAT", "a number"),
    int: ("INT", "a whole number"),
    str: ("TEXT", "a text"),
    Path: ("PATH", "a path"),
}
REGISTRY = ConstructorRegistry()  # of how options are read


def parse(verbs: Any, prog: str, description: str, arguments: Sequence[str]) -> Any:
    """The verb that was typed, with its options.

    Args:
        verbs: union of the verbs, for ``tyro.cli``.
        prog: name of the program.
        description: text above the verbs in the program's help.
        arguments: what was typed after the program's name.

    Raises:
        SystemExit: with 2 and a message for what cannot be read, with 0 after help.
    """
    help_text, error_text = Held(sys.stdout), io.StringIO()
    try:
        with REGISTRY, contextlib.redirect_stdout(help_text), contextlib.redirect_stderr(error_text):
            return tyro.cli(verbs, prog=prog, description=description, args=arguments)
    finally:
        if help_text.getvalue():
            put(sys.stdout, fitted(help_text.getvalue(), min(WIDTH, shutil.get_terminal_size().columns)) + "\n")
        if error_text.getvalue():
            say_error(f"error: {_unboxed(error_text.getvalue()).removeprefix('Error parsing ')}")


def _unboxed(text: str) -> str:
    """What tyro says in a box: a line for what is wrong, one for what may have been meant, one for where help is."""
    lines = [line.strip("│╭╮╰╯| ") for line in text.splitlines() if line[:1] in "│|"]
    parts = [" ".join(part.split()) for part in re.split(r"\s─{3,}\s|\s-{5,}\s", "\n".join(lines))]
    return "\n".join([parts[0], *parts[1:-1][:1], *parts[1:][-1:]]) if lines else " ".join(text.split())


def fitted(text: str, width: int) -> str:
    """A text in lines of at most so many columns, wrapped between words: a long path stays in one piece."""
    return "\n".join(part for line in text.splitlines() for part in _wrapped(line, width))


def _wrapped(line: str, width: int) -> list[str]:
    if len(line) <= width or line.startswith(tuple(BOX)):
        return [line]
    is_prose = not line.startswith((" ", "usage:", "Example:"))
    indent = "" if is_prose else " " * (len(line) - len(line.lstrip()) + 4)
    spaced = line.replace(",", ", ") if line.startswith("usage:") else line
    return textwrap.wrap(spaced, width, subsequent_indent=indent, break_on_hyphens=False, break_long_words=False)


@REGISTRY.primitive_rule
def _number_or_text(info: PrimitiveTypeInfo) -> PrimitiveConstructorSpec[Any] | None:
    """Numbers, and what may also be left out: tyro's own names Python's classes where a value cannot be read."""
    options = get_args(info.type)
    optional = len(options) == 2 and type(None) in options
    kind = next(option for option in options if option is not type(None)) if optional else info.type
    if kind not in WANTED or not (optional or kind in (float, int)):
        return None
    return option(kind, *WANTED[kind])
