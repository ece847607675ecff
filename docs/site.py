"""Pages of the site that are made from code: the tutorials from their scripts and what these print and draw, the
catalogue from the registry."""

from __future__ import annotations

import dataclasses
import re
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from html import escape
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parent
sys.path.append(str(DOCS))

import executed  # noqa: E402 — beside this file, which MkDocs loads by its path

RUN = DOCS.parent / "build" / "tutorials"
TUTORIALS = DOCS / "tutorials"
AS_RUN = "It writes its files where you start it. Below its parts stands what they printed and drew with `--short`."
# What Sphinx would make a link of, in docstrings.
ROLE = re.compile(r":(?:class|func|meth|mod|data|attr|exc):<code>~?(?:[\w.]*\.)?(\w+)</code>")


def on_config(config: Any) -> Any:
    """Runs the tutorials that have changed since they last ran, two at a time, in short mode."""
    with ThreadPoolExecutor(max_workers=2) as pool:
        list(pool.map(_executed, sorted(TUTORIALS.glob("*.py"))))
    return config


def on_files(files: Any, config: Any) -> Any:
    """Adds the made pages, and the pictures that tutorials draw, to those of the folder."""
    from mkdocs.structure.files import File  # noqa: PLC0415 — only a build of the site has MkDocs

    for script in sorted(TUTORIALS.glob("*.py")):
        done = executed.current(script, RUN / script.stem) or []
        page = tutorial(script.read_text("utf-8"), done, script.stem)
        files.append(File.generated(config, f"tutorials/{script.stem}.md", content=page))
        for name in (name for part in done for name in part["drawn"]):
            place = RUN / script.stem / name
            files.append(File.generated(config, f"tutorials/{script.stem}/{name}", abs_src_path=str(place)))
    files.append(File.generated(config, "effects.md", content=catalogue()))
    files.append(File.generated(config, "thresholds.md", content=thresholds()))
    return files


def _executed(script: Path) -> None:
    folder = RUN / script.stem
    if executed.current(script, folder) is None:
        command = [sys.executable, str(DOCS / "executed.py"), str(script), str(folder), "--short"]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        if run.returncode:
            raise RuntimeError(f"{script.name} does not run: {run.stderr[-2000:]}")


def on_page_content(html: str, **_: Any) -> str:
    """Roles of docstrings become code."""
    return ROLE.sub(r"<code>\1</code>", html)


def tutorial(source: str, done: Sequence[dict[str, Any]] = (), folder: str = "") -> str:
    """A script as a page: its text, its code and, where it has run, what every part of it printed and drew."""
    shown, left = [], iter(done)
    for place, (kind, text) in enumerate(executed.parts(source)):
        if place == 1 and done:
            shown.append(AS_RUN)
        shown.append(text if kind == "text" else f"```python\n{text}\n```")
        part = next(left, None) if kind == "code" else None
        if part is not None:
            shown += [f"```text\n{part['printed'].rstrip()}\n```"] if part["printed"].strip() else []
            shown += [_drawn(folder, name) for name in part["drawn"]]
    return "\n\n".join(text for text in shown if text) + "\n"


def _drawn(folder: str, name: str) -> str:
    title = Path(name).stem.replace("_", " ")
    return f"[Open {name}]({folder}/{name})" if name.endswith(".html") else f"![{title}]({folder}/{name})"


def thresholds() -> str:
    """Every threshold of the diagnosis: its value, where that comes from, and what it decides."""
    from sym2real.diagnosis import settings  # noqa: PLC0415 — heavy

    lines = ["# Thresholds of the diagnosis\n", settings.__doc__ or "", "| threshold | value | source | what it is |"]
    lines.append("|---|---:|---|---|")
    for one in dataclasses.fields(settings.Settings):
        lines.append(f"| `{one.name}` | {one.default:.4g} | {one.metadata['source']} | {one.metadata['why']} |")
    return "\n".join(lines)


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
            f'<div class="formula">{_formula(kind.formula)}</div>\n',
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


def _formula(latex: str) -> str:
    """MathML, which browsers draw without a script, with its LaTeX for those that do not."""
    from latex2mathml.converter import convert  # noqa: PLC0415 — of the extra docs

    return str(convert(latex, display="block")).replace("<math", f'<math alttext="{escape(latex)}"', 1)


def _size(value: float) -> str:
    return "none" if abs(value) >= 1e15 else f"{value:.3g}"
