"""The asking side of an engine that runs in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import weakref
from pathlib import Path
from typing import Any

from sym2real.errors import ModelError

PACKAGE_FOLDER = Path(__file__).resolve().parents[2]
LINES_OF_LOG = 15


class WorkerProcess:
    """A Python process that answers requests (:mod:`sym2real.regression.worker_loop`); it ends with this object.

    Args:
        module: what the process runs (``python -m``).
    """

    def __init__(self, module: str) -> None:
        paths = [str(PACKAGE_FOLDER), *filter(None, [os.environ.get("PYTHONPATH")])]
        self._log = tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace")  # noqa: SIM115
        self._process = subprocess.Popen(
            [sys.executable, "-m", module],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            encoding="utf-8",
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
        )
        self._end = weakref.finalize(self, _end, self._process)

    def send(self, command: str, **arguments: Any) -> None:
        """Ask; :meth:`receive` waits for the answer.

        Raises:
            ModelError: when the process has died.
        """
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps({"command": command, **arguments}) + "\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            raise self._died() from None

    def receive(self) -> Any:
        """The answer to the oldest unanswered request.

        Raises:
            WorkerError: when the engine failed.
            ModelError: when the process has died.
        """
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise self._died()
        answer = json.loads(line)
        if "error" in answer:
            raise WorkerError(answer["error"]["type"], answer["error"]["message"])
        return answer["result"]

    def ask(self, command: str, **arguments: Any) -> Any:
        """Send and receive."""
        self.send(command, **arguments)
        return self.receive()

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


def _end(process: subprocess.Popen[str]) -> None:
    for stream in (process.stdin, process.stdout):
        if stream is not None:
            stream.close()
    try:
        process.wait(timeout=2)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
