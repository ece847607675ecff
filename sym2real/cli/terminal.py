"""What a verb says: held back until its files are written, and fit for whatever stream it goes to."""

import contextlib
import io
import os
import sys
from collections.abc import Iterator
from functools import cache
from typing import NoReturn, TextIO

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment

from sym2real.errors import DataError, Sym2RealError, reason

# Control characters but for tabs and ends of lines: a terminal would obey them.
UNSHOWN = dict.fromkeys((*range(9), *range(11, 32), *range(127, 160)), "\N{REPLACEMENT CHARACTER}")


class PlainConsole(Console):
    """A console that shows control characters in texts as �: what a file holds moves no cursor and changes no title."""

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterator[Segment]:
        """Segments as rich makes them, their texts without control characters; rich's own controls stay."""
        for text, style, control in super().render(renderable, options):
            yield Segment(text if control else text.translate(UNSHOWN), style, control)


class Report(PlainConsole):
    """A console whose words wait for :meth:`release`: what cannot be shown must not keep anything from being saved.

    Args:
        stream: where they go; None, as Python gives a closed one, for nowhere.
    """

    def __init__(self, stream: TextIO | None) -> None:
        self._held = Held(stream)
        super().__init__(file=self._held, highlight=False, emoji=False)

    def release(self) -> None:
        """Say what has been held.

        Raises:
            DataError: when the stream takes nothing for another reason than that its reader has gone.
        """
        put(self._held.stream, self._held.getvalue())


class Held(io.StringIO):
    """Text on its way to a stream; rich and tyro ask it what the stream could show."""

    def __init__(self, stream: TextIO | None) -> None:
        super().__init__()
        self.stream = stream

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """Of the stream."""
        return encoding_of(self.stream)

    def isatty(self) -> bool:
        """Whether the stream is a terminal."""
        return self.stream is not None and self.stream.isatty()


def encoding_of(stream: TextIO | None) -> str:
    """Encoding of a stream; UTF-8 where it has none."""
    return getattr(stream, "encoding", None) or "utf-8"


def put(stream: TextIO | None, text: str) -> None:
    """Write to a stream: what it cannot show becomes ``?``, and nothing is written where nobody reads any more.

    Raises:
        DataError: when the stream takes nothing for another reason, such as a full disk.
    """
    if stream is None or not text:
        return
    encoding = encoding_of(stream)
    try:
        stream.write(text.encode(encoding, "replace").decode(encoding))
        stream.flush()
    except OSError as error:
        # What is left in the stream's buffer would fail again when Python ends.
        with contextlib.suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        if not isinstance(error, BrokenPipeError):
            raise DataError("standard output", "a place that takes the report", reason(error)) from error


@cache
def progress_console() -> Console:
    """Where progress is drawn: standard error, so that a pipe gets reports alone."""
    return PlainConsole(stderr=True, highlight=False, emoji=False)


def say_error(text: str) -> None:
    """Say on standard error what went wrong."""
    report = Report(sys.stderr)
    head, colon, rest = text.partition(":")
    report.print(head + colon, style="bold red", end="", markup=False)
    report.print(rest, soft_wrap=True, markup=False)
    with contextlib.suppress(DataError):
        report.release()


@contextlib.contextmanager
def ending_in_words(interrupted: str) -> Iterator[None]:
    """Around a program: it ends with one line and a status of 2 on bad input, of 130 on Ctrl-C.

    Args:
        interrupted: the text for Ctrl-C.
    """
    try:
        try:
            yield
        except Sym2RealError as error:
            stop(f"error: {error}", 2)
        except OSError as error:
            stop(f"error: {DataError(error.filename or 'a file', 'one that can be used', reason(error))}", 2)
    except KeyboardInterrupt:  # also while an error is printed
        stop(interrupted, 130)


def stop(text: str, status: int) -> NoReturn:
    """Say what went wrong and end the program."""
    say_error(" ".join(text.split()))  # names of files and the words of libraries may hold ends of lines
    sys.exit(status)
