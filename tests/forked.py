"""The command line in a fork of this process: a run of its own, without the seconds that loading libraries takes."""

import os
import resource
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import torch

from sym2real.cli import TRACEBACK, main

SECONDS = 300  # after which a run counts as hung, on a machine that others use; most take one


@dataclass(frozen=True)
class Ran:
    """What a run left: its exit status (negative: the signal that ended it) and what it said."""

    status: int
    out: str
    err: str


def forked(
    arguments: Sequence[str],
    folder: Path,
    *,
    most_bytes: int | None = None,
    seconds: int = SECONDS,
    net: bool = True,
    encoding: str = "utf-8",
) -> Ran:
    """Run the command line in a folder.

    Args:
        arguments: what is typed after the program's name.
        folder: where it runs.
        most_bytes: that a file may have, as on a full disk.
        seconds: after which it is ended by SIGALRM.
        net: whether an error that nobody foresaw becomes one line.
        encoding: of standard output.
    """

    def work() -> None:
        sys.stdout = open(1, "w", encoding=encoding, closefd=False)  # noqa: SIM115
        os.environ[TRACEBACK] = "" if net else "1"
        if most_bytes is not None:
            sys.dont_write_bytecode = True  # what Python compiles would be cut off, and kept so for every other run
            resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))
        main(arguments)

    return in_fork(work, folder, seconds)


def in_fork(work: Callable[[], None], folder: Path, seconds: int = SECONDS) -> Ran:
    """Do something in a fork and say how it ended."""
    with tempfile.TemporaryDirectory() as said:
        streams = Path(said, "out"), Path(said, "err")
        _, status = os.waitpid(_forked(work, folder, streams, seconds), 0)
        out, err = (file.read_bytes().decode(errors="replace") for file in streams)
    return Ran(os.waitstatus_to_exitcode(status), out, err)


def started(work: Callable[[], None], folder: Path, seconds: int = SECONDS) -> int:
    """Begin something in a fork, unheard; its process, which is to be waited for."""
    return _forked(work, folder, (Path(os.devnull), Path(os.devnull)), seconds)


def _forked(work: Callable[[], None], folder: Path, streams: tuple[Path, Path], seconds: int) -> int:
    process = os.fork()
    if process == 0:
        try:
            _child(work, folder, streams, seconds)
        finally:
            os._exit(99)  # whatever a signal interrupts: a second process of the tests would be left
    return process


def _child(work: Callable[[], None], folder: Path, streams: tuple[Path, Path], seconds: int) -> None:
    status = 99
    try:
        for number, file in enumerate(streams, start=1):
            os.dup2(os.open(file, os.O_WRONLY | os.O_CREAT), number)
        sys.stdout, sys.stderr = (open(number, "w", encoding="utf-8", closefd=False) for number in (1, 2))  # noqa: SIM115
        os.chdir(folder)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell in the background has it ignored
        signal.alarm(seconds)
        torch.set_num_threads(1)  # as in PyTorch's data loaders: threads that torch has begun are not in a fork
        work()
        status = 0
    except SystemExit as stopped:
        status = int(stopped.code or 0)
    except BaseException:
        traceback.print_exc()
    finally:
        _ignore_ctrl_c()
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def _ignore_ctrl_c() -> None:
    """One that comes after the work was done is raised here."""
    while signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        with suppress(KeyboardInterrupt):
            signal.signal(signal.SIGINT, signal.SIG_IGN)
