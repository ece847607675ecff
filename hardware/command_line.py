"""What the launch scripts share: options from a dataclass, words as they come, errors in one line, JSON on request."""

import os
import signal
import sys
import threading
from collections.abc import Sequence
from typing import Any

from rich.console import Console

from sym2real.cli.output import STANDARD_OUTPUT, show_json, write_json
from sym2real.cli.parsing import parse
from sym2real.cli.places import kept_apart
from sym2real.cli.terminal import ending_in_words


def main(verb: Any, prog: str, description: str | None, arguments: Sequence[str] | None = None) -> None:
    """Run a verb, or the one of several that is named.

    Exits with 2 and one clear message on bad input or a robot that does not answer, with 130 on Ctrl-C. SIGTERM lands
    or brakes as Ctrl-C does, and Ctrl-C does so even where a shell in the background has it ignored.

    Args:
        verb: for ``tyro.cli``.
        prog: name of the program.
        description: text of its help.
        arguments: what was typed after the program's name.
    """
    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.default_int_handler)
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
