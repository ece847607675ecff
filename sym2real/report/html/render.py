"""A page as one HTML file that asks for nothing else: styles, scripts and numbers are in it.

Text comes from files that people name and write, so it is escaped: by the template in HTML, and as escape sequences in
the JSON of the page's script. The page's own policy lets it run its own two scripts and load nothing.
"""

import base64
import hashlib
import json
import math
import zlib
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from sym2real import __version__
from sym2real.files import write_text
from sym2real.report.charts import Chart, Line
from sym2real.report.html.page import Page
from sym2real.report.html.sentences import plain, sentence
from sym2real.report.tables import number
from sym2real.trajectory import Array

STYLES = ("uPlot.min.css", "page.css")
CHART_SCRIPTS = ("uPlot.iife.min.js",)
SCRIPTS = ("data.js", "charts.js", "page.js")


class Arrays:
    """Numbers for the page's script by the number of their array; each is put in once."""

    def __init__(self) -> None:
        self._rows: list[list[list[float | None]]] = []
        self._known: dict[int, tuple[int, Array]] = {}  # the arrays too: no other may get the address of one

    def add(self, values: Array) -> int:
        """Put in an array ``# (n,)`` or ``# (rows, n)``, to five digits; its number. A script sees null as a gap."""
        if id(values) not in self._known:
            self._known[id(values)] = len(self._rows), values
            rows = np.atleast_2d(values).tolist()
            self._rows.append([[float(f"{x:.5g}") if math.isfinite(x) else None for x in row] for row in rows])
        return self._known[id(values)][0]

    @property
    def text(self) -> str:
        """All arrays: base64 of the zlib stream of their JSON."""
        return base64.b64encode(zlib.compress(json.dumps(self._rows, separators=(",", ":")).encode())).decode("ascii")


def write_page(page: Page, file: Path) -> Path:
    """Write a page; the file."""
    write_text(file, render(page))
    return file


def render(page: Page) -> str:
    """HTML of a page."""
    arrays, charts = Arrays(), list[Any]()
    # The page's modules as one: what they export, the last one uses.
    script = _text(SCRIPTS).replace("\nexport class ", "\nclass ")
    assets = {"style": _text(STYLES), "chart": _text(CHART_SCRIPTS), "page": script}

    def numbered(chart: Chart) -> int:
        charts.append(_packed(chart, arrays))
        return len(charts) - 1

    def data() -> Markup:
        """All that the script reads; last of all, because the template asks for numbers on its way."""
        about = {"charts": charts, "arrays": arrays.text, "seconds": [log[1] for log in page.logs]}
        return Markup(in_script(about))

    template = _environment().from_string(_text(("page.html",)))
    return template.render(
        page=page,
        number_of=numbered,
        array_of=arrays.add,
        assets={name: Markup(text) for name, text in assets.items()},
        hashes={name: Markup(f"'sha256-{_digest(text)}'") for name, text in assets.items()},
        data=data,
        version=__version__,
    )


def _packed(about: Any, arrays: Arrays) -> Any:
    """A chart, a line or what they hold, with the number of every array in its place."""
    if isinstance(about, np.ndarray):
        return arrays.add(about)
    if isinstance(about, list | tuple):
        return [_packed(part, arrays) for part in about]
    if isinstance(about, Chart | Line):
        return {name: _packed(part, arrays) for name, part in vars(about).items()}
    return about


def in_script(data: Any) -> str:
    """JSON that may stand inside a script element: no sign in it can end the element or begin a comment."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def _environment() -> Environment:
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters["figures"] = lambda value: "–" if not math.isfinite(value) else number(value)
    environment.filters["kind"] = lambda part: type(part).__name__
    environment.filters |= {"plain": plain, "sentence": sentence}
    environment.filters["rows"] = lambda table: zip(*(column.cells for column in table.columns), strict=True)
    return environment


@cache
def _text(names: tuple[str, ...]) -> str:
    folder = resources.files(__package__) / "assets"
    return "\n".join((folder / name).read_text(encoding="utf-8").strip() for name in names)


def _digest(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")
