"""What the launch scripts share: options from a dataclass, words as they come, errors in one line, JSON on request."""

import os
import signal
import sys
import threading
from collections.abc import Sequence
from types import FrameType
from typing import Any

from rich.console import Console

from sym2real.cli.output import STANDARD_OUTPUT, show_json, write_json
from sym2real.cli.parsing import parse
from sym2real.cli.places import kept_apart
from sym2real.cli.terminal import ending_in_words


def main(verb: Any, prog: str, description: str | None, arguments: Sequence[str] | None = None) -> None:
    """Run a verb, or the one of several that is named.

    Exits with 2 and one clear message on bad input or a robot that does not answer, with 130 on Ctrl-C. SIGTERM,
    SIGQUIT and a terminal that goes away land or brake as Ctrl-C does, and Ctrl-C does so even where a shell in the
    background has it ignored. Ctrl-Z does nothing: a program that is held in flight lands nobody.

    Args:
        verb: for ``tyro.cli``.
        prog: name of the program.
        description: text of its help.
        arguments: what was typed after the program's name.
    """
    if threading.current_thread() is threading.main_thread():
        _listen_to_signals()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    chosen = parse(verb, prog, description or "", list(sys.argv[1:] if arguments is None else arguments))
    # A person beside a robot reads what it waits for while it waits.
    console = Console(stderr=chosen.json == STANDARD_OUTPUT, highlight=False)
    with ending_in_words("interrupted: the robot stands, the record is closed"):
        with kept_apart(chosen):
            result = chosen.run(console)
            write_json(result, chosen.json)
        if chosen.json == STANDARD_OUTPUT:
            show_json(result)


def _listen_to_signals() -> None:
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    if os.name != "posix":  # Windows has no others
        return
    signal.signal(signal.SIGQUIT, signal.default_int_handler)
    signal.signal(signal.SIGTSTP, signal.SIG_IGN)
    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:  # as nohup has it
        signal.signal(signal.SIGHUP, _hang_up)


def _hang_up(number: int, frame: FrameType | None) -> None:
    """End as by one Ctrl-C: shell and kernel both tell of a terminal that is gone, and a second one cuts the motors."""
    signal.signal(number, signal.SIG_IGN)
    signal.default_int_handler(number, frame)
