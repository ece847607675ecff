"""A fake robot in a process of its own, beside a script."""

import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from hardware.errors import LinkError

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Fake:
    """A fake robot that runs.

    Args:
        address: where it answers.
        tell: writes it a line, and returns once it has answered with one.
    """

    address: str
    tell: Callable[[str], None]


@contextmanager
def beside(module: str, options: Sequence[str]) -> Iterator[Fake]:
    """A fake robot, which ends with this or when this process dies.

    Args:
        module: to run; it prints its address first.
        options: of its command line.

    Raises:
        LinkError: where it does not start, with its words.
    """
    command = [sys.executable, "-m", module, *options]
    # In a session of its own, where no Ctrl-C reaches it; it ends with its input, which this process holds.
    process = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT, start_new_session=True
    )
    assert process.stdout is not None
    assert process.stdin is not None
    told, heard = process.stdin, process.stdout

    def tell(line: str) -> None:
        told.write(f"{line}\n")
        told.flush()
        if not heard.readline():
            raise LinkError(f"the fake robot ended before it answered: {line}")

    try:
        words = heard.readline().strip()
        if "://" not in words:
            raise LinkError(f"the fake robot did not start: {words or 'no word'}")
        yield Fake(words, tell)
    finally:
        process.kill()  # it would linger, for the watchdogs of a client that was killed
        process.wait()
        told.close()
        heard.close()
