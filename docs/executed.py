"""Runs a tutorial as its page shows it, part by part, and keeps what every part prints and draws.

    python docs/executed.py docs/tutorials/02_hidden_effect.py build/tutorials/02_hidden_effect --short

The folder is made anew and is where the tutorial runs: pictures are the files that it leaves there.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

ANSWER = "executed.json"
SHOWN = {".svg", ".png", ".html"}


def parts(source: str) -> list[tuple[str, str]]:
    """A script as ("text", …) and ("code", …): its docstring, then comments at the margin and what is between them."""
    tree = ast.parse(source)
    found = [("text", ast.get_docstring(tree) or "")]
    for block in _blocks(source.splitlines()[tree.body[0].end_lineno :]):
        if all(line.startswith("#") for line in block):
            found.append(("text", "\n".join(line[1:].strip() for line in block)))
        elif found[-1][0] == "code":
            found[-1] = ("code", "\n".join([found[-1][1], "", *block]))
        else:
            found.append(("code", "\n".join(block)))
    return found


def _blocks(lines: list[str]) -> list[list[str]]:
    """Runs of lines between empty ones."""
    blocks: list[list[str]] = [[]]
    for line in lines:
        if line.strip():
            blocks[-1].append(line)
        elif blocks[-1]:
            blocks.append([])
    return [block for block in blocks if block]


def current(script: Path, folder: Path) -> list[dict[str, Any]] | None:
    """What the parts of a script have left, if the folder is that of the script as it stands now."""
    answer = folder / ANSWER
    found = json.loads(answer.read_text("utf-8")) if answer.exists() else {}
    return found["parts"] if found.get("digest") == _digest(script) else None


def execute(script: Path, folder: Path, *arguments: str) -> None:
    """Run a script in a folder of its own; its code parts share one namespace, as in the script.

    The process is the script's from then on: its folder, arguments and environment change.
    """
    whole, folder = folder, folder.with_name(f".{folder.name}-{os.getpid()}")  # another may make the same one
    folder.mkdir(parents=True)
    os.chdir(folder)
    os.environ |= {"COLUMNS": "92", "OMP_NUM_THREADS": "1"}
    sys.argv = [str(script), *arguments]
    names: dict[str, Any] = {"__name__": "__main__", "__file__": str(script)}
    done = []
    for kind, text in parts(script.read_text("utf-8")):
        if kind == "code":
            there = set(_pictures(folder))
            with _printed(folder / "printed.txt"):
                exec(compile(text, str(script), "exec"), names)
            drawn = [name for name in _pictures(folder) if name not in there]
            done.append({"printed": (folder / "printed.txt").read_text("utf-8"), "drawn": drawn})
    (folder / ANSWER).write_text(json.dumps({"digest": _digest(script), "parts": done}), "utf-8")
    shutil.rmtree(whole, ignore_errors=True)
    folder.replace(whole)


def _pictures(folder: Path) -> list[str]:
    """Files at the top of a folder that a page can show, as they were written."""
    there = (path for path in folder.iterdir() if path.suffix in SHOWN)
    return [path.name for path in sorted(there, key=lambda path: path.stat().st_mtime_ns)]


@contextmanager
def _printed(file: Path) -> Iterator[None]:
    """Standard output into a file, that of child processes too, and on to where it went before."""
    sys.stdout.flush()
    before = os.dup(1)
    with file.open("wb") as written:
        os.dup2(written.fileno(), 1)
        try:
            yield
        finally:
            sys.stdout.flush()
            os.dup2(before, 1)
            os.close(before)
            sys.stdout.write(file.read_text("utf-8"))


def _digest(script: Path) -> str:
    return hashlib.sha256(script.read_bytes()).hexdigest()


if __name__ == "__main__":
    execute(Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve(), *sys.argv[3:])
