"""The command line's results, for tests."""

import json
from pathlib import Path
from typing import Any

from sym2real.cli import main


def result_of(arguments: list[str], folder: Path) -> dict[str, Any]:
    """Run a verb in this process; what it wrote as JSON."""
    file = folder / "result.json"
    main([*arguments, "--json", str(file)])
    result: dict[str, Any] = json.loads(file.read_text())
    return result
