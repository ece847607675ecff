"""A line on the terminal while a verb loads its libraries, which takes seconds: it has begun."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console, ConsoleRenderable, RenderHook
from rich.control import Control
from rich.segment import ControlType

from sym2real.cli.terminal import progress_console


@contextmanager
def loading(verb: str) -> Iterator[None]:
    """Show the line until progress is drawn or the verb is done; nothing where standard error is no terminal.

    Args:
        verb: what the line names.
    """
    terminal = progress_console()
    if not terminal.is_terminal or terminal.is_dumb_terminal:
        yield
        return
    line = _Line(terminal, f"{verb}: loading libraries")
    terminal.push_render_hook(line)
    try:
        yield
    finally:
        terminal.pop_render_hook()
        line.erase()


class _Line(RenderHook):
    """Text that goes as soon as anything else is rendered; a spinner could not turn while libraries are loaded."""

    def __init__(self, terminal: Console, text: str) -> None:
        self._terminal, self._shown = terminal, True
        terminal.print(text, style="dim", end="\r")

    def process_renderables(self, renderables: list[ConsoleRenderable]) -> list[ConsoleRenderable]:
        self.erase()
        return renderables

    def erase(self) -> None:
        if self._shown:
            self._shown = False
            self._terminal.control(Control((ControlType.ERASE_IN_LINE, 2)))
