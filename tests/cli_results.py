"""What the command line answers and what it refuses, for tests."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from sym2real.cli import main

Refused = Callable[[str | Sequence[str]], str]  # the fixture of conftest.py: what a command that is refused says


def result_of(arguments: list[str], folder: Path) -> dict[str, Any]:
    """Run a verb in this process; what it wrote as JSON."""
    file = folder / "result.json"
    main([*arguments, "--json", str(file)])
    result: dict[str, Any] = json.loads(file.read_text())
    return result
