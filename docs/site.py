"""Pages of the site that are made from code: the tutorials from their scripts, the catalogue from the registry."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parent
TUTORIALS = DOCS / "tutorials"
# What Sphinx would make a link of, in docstrings.
ROLE = re.compile(r":(?:class|func|meth|mod|data|attr|exc):<code>~?(?:[\w.]*\.)?(\w+)</code>")


def on_files(files: Any, config: Any) -> Any:
    """Adds the made pages to those of the folder."""
    from mkdocs.structure.files import File  # noqa: PLC0415 — only a build of the site has MkDocs

    for script in sorted(TUTORIALS.glob("*.py")):
        files.append(File.generated(config, f"tutorials/{script.stem}.md", content=tutorial(script.read_text("utf-8"))))
    files.append(File.generated(config, "effects.md", content=catalogue()))
    return files


def on_page_content(html: str, **_: Any) -> str:
    """Roles of docstrings become code."""
    return ROLE.sub(r"<code>\1</code>", html)


def tutorial(source: str) -> str:
    """A script as a page: its docstring, then comments at the margin as text and what is between them as code."""
    tree = ast.parse(source)
    intro = ast.get_docstring(tree) or ""
    parts, code = [intro], list[str]()
    for block in _blocks(source.splitlines()[tree.body[0].end_lineno :]):
        if all(line.startswith("#") for line in block):
            parts += [_fenced(code), "\n".join(line[1:].strip() for line in block)]
            code = []
        else:
            code += ["", *block]
    return "\n\n".join(part for part in [*parts, _fenced(code)] if part) + "\n"


def _blocks(lines: list[str]) -> list[list[str]]:
    """Runs of lines between empty ones."""
    blocks: list[list[str]] = [[]]
    for line in lines:
        if line.strip():
            blocks[-1].append(line)
        elif blocks[-1]:
            blocks.append([])
    return [block for block in blocks if block]


def _fenced(code: list[str]) -> str:
    text = "\n".join(code).strip("\n")
    return f"```python\n{text}\n```" if text else ""


def catalogue() -> str:
    """Every kind of effect of the registry: formula, numbers, what it is confused with, and how to tell."""
    from sym2real.effects import EFFECTS  # noqa: PLC0415 — heavy

    head = "# Catalogue of effects\n\nMade from the registry; `sym2real effects NAME` prints the same for one robot.\n"
    return "\n".join([head, *(_entry(kind) for kind in EFFECTS.values())])


def _entry(kind: Any) -> str:
    from sym2real.effects.catalogue import known  # noqa: PLC0415
    from sym2real.robots import ROBOTS  # noqa: PLC0415

    bound = [one for robot in ROBOTS.values() for one in known(robot) if one.kind == kind.name]
    numbers = {one.name: one for effect in bound[:1] for one in effect.parameters}
    rows = [f"| `{one.name}` | {one.unit} | {_size(one.null)} | {_size(one.scale)} |" for one in numbers.values()]
    columns = sorted({one.column for one in bound if one.column})
    return "\n".join(
        [
            f"## {kind.name}\n",
            f"{kind.summary}\n",
            f"    {kind.formula}\n",
            *(
                [f"Bound to a column: {', '.join(f'`{kind.name}:{column}`' for column in columns)}.\n"]
                if columns
                else []
            ),
            *(
                ["| parameter | unit | does nothing at | expected size |", "|---|---|---|---|", *rows, ""]
                if rows
                else []
            ),
            f"- **Looks like** {kind.confused_with}.",
            f"- **Shown by** {kind.shown_by}.",
            f"- **Fix**: {kind.fix}.\n",
        ]
    )


def _size(value: float) -> str:
    return "none" if abs(value) >= 1e15 else f"{value:.3g}"
