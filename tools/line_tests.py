"""A pytest plugin: which test runs which line of some folders, and how long every test takes.

Set ``LINE_TESTS_ROOT`` to the repository, ``LINE_TESTS_FOLDERS`` to the folders, one per line, and ``LINE_TESTS_OUT``
to the folder that gets a JSON file from every process.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

ROOT = Path(os.environ["LINE_TESTS_ROOT"])
WATCHED = tuple(str(ROOT / folder) + os.sep for folder in os.environ["LINE_TESTS_FOLDERS"].splitlines())
OUT = Path(os.environ["LINE_TESTS_OUT"])

_seconds: dict[str, float] = {}
_lines: dict[str, dict[str, set[int]]] = {}


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Follow the lines of a test with its fixtures."""
    mine: dict[str, set[int]] = defaultdict(set)

    def enter(frame: FrameType, _: str, __: Any) -> Any:
        name = frame.f_code.co_filename
        if not name.startswith(WATCHED):
            return None
        seen = mine[os.path.relpath(name, ROOT)]
        seen.add(frame.f_lineno)

        def follow(inner: FrameType, event: str, _: Any) -> Any:
            if event == "line":
                seen.add(inner.f_lineno)
            return follow

        return follow

    began = time.perf_counter()
    sys.settrace(enter)
    yield
    sys.settrace(None)
    _seconds[item.nodeid] = time.perf_counter() - began
    _lines[item.nodeid] = dict(mine)


def pytest_sessionfinish() -> None:
    """Write what this process has seen."""
    tests = {
        name: {"seconds": _seconds[name], "lines": {file: sorted(rows) for file, rows in files.items()}}
        for name, files in _lines.items()
    }
    if tests:
        (OUT / f"{os.getpid()}.json").write_text(json.dumps(tests))
