"""What the launch scripts share: options from a dataclass, errors in one line, JSON where it is asked for."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Any

from rich.markup import escape

from sym2real.cli.output import console_for, require_places, write_json
from sym2real.cli.parsing import fitted, parse
from sym2real.errors import Sym2RealError


def main(verb: Any, prog: str, arguments: Sequence[str] | None = None) -> None:
    """Run a verb; exit with 2 and one clear message on bad input or a robot that does not answer, 130 on Ctrl-C."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    chosen = parse(verb, prog, verb.__doc__, list(sys.argv[1:] if arguments is None else arguments))
    console = console_for(chosen.json)
    try:
        require_places(chosen)
        write_json(chosen.run(console), chosen.json)
    except Sym2RealError as error:
        text = fitted(f"error: {error}", console.width)
        console.print(escape(text).replace("error:", "[bold red]error:[/]", 1), soft_wrap=True)
        sys.exit(2)
    except KeyboardInterrupt:
        console.print("interrupted: the robot has landed, the record is closed")
        sys.exit(130)
