"""A fake robot in a process of its own, beside a script."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from hardware.errors import LinkError

ROOT = Path(__file__).resolve().parents[2]


@contextmanager
def beside(module: str, options: Sequence[str]) -> Iterator[str]:
    """The address of a fake robot, which ends with this or when this process dies.

    Args:
        module: to run; it prints its address first.
        options: of its command line.

    Raises:
        LinkError: where it does not start, with its words.
    """
    command = [sys.executable, "-m", module, *options]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT)
    assert process.stdout is not None
    assert process.stdin is not None
    try:
        words = process.stdout.readline().strip()
        if "://" not in words:
            raise LinkError(f"the fake robot did not start: {words or 'no word'}")
        yield words
    finally:
        process.stdin.close()
        process.terminate()
        process.wait()
        process.stdout.close()
