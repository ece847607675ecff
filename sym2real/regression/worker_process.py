"""The asking side of an engine that runs in a process of its own."""

from __future__ import annotations

import pickle
import subprocess
import sys
import tempfile
import weakref
from contextlib import suppress
from pathlib import Path
from typing import Any

from sym2real.errors import ModelError

LINES_OF_LOG = 15


class WorkerProcess:
    """A Python process that answers requests (:mod:`sym2real.regression.pysr_worker`); it ends with this object.

    Args:
        script: what the process runs; the script's folder is none that it imports from.
    """

    def __init__(self, script: Path) -> None:
        self._log = tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace")  # noqa: SIM115
        self._process = subprocess.Popen(
            [sys.executable, "-P", str(script)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._log
        )
        self._end = weakref.finalize(self, _end, self._process)

    def ask(self, command: str, **arguments: Any) -> Any:
        """The answer to a request.

        Raises:
            WorkerError: when the engine failed.
            ModelError: when the process has died.
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            pickle.dump((command, arguments), self._process.stdin)
            self._process.stdin.flush()
            result, error = pickle.load(self._process.stdout)
        except (BrokenPipeError, EOFError):
            raise self._died() from None
        if error is not None:
            raise WorkerError(*error)
        return result

    def close(self) -> None:
        """End the process."""
        self._end()

    def _died(self) -> ModelError:
        code = self._process.wait()
        self._log.seek(0)
        tail = "".join(self._log.readlines()[-LINES_OF_LOG:]).strip()
        return ModelError(f"the regression worker ended with exit code {code}; it last wrote: {tail or 'nothing'}")


class WorkerError(ModelError):
    """The engine in the worker process failed.

    Args:
        kind: name of its exception's type.
        message: its text.
    """

    def __init__(self, kind: str, message: str) -> None:
        self.kind = kind
        super().__init__(f"the regression worker failed: {kind}: {message}")


def _end(process: subprocess.Popen[bytes]) -> None:
    for stream in (process.stdin, process.stdout):
        if stream is not None:
            with suppress(OSError):  # what a dead process was sent is still to be written
                stream.close()
    try:
        process.wait(timeout=2)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
