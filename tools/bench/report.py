#!/usr/bin/env python3
"""The report as a page: how long it takes to write, how large it is, and how fast Chromium shows and follows it.

Ten simulated flights of 400 rows and five effects, so that every one of 32 models predicts every window. The effects
are those that were simulated, with their true values: what is measured is the page, not the diagnosis.
"""

import time
from dataclasses import dataclass
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory
from typing import Any

import tyro
from figures import Figure, report
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset
from sym2real.diagnosis import Diagnosis, Estimate, Finding
from sym2real.diagnosis.faults.sanity import check
from sym2real.experiments.models import open_model
from sym2real.report.html.pages import diagnosis_page
from sym2real.report.html.render import write_page

EFFECTS: tuple[tuple[str, dict[str, float]], ...] = (
    ("added_mass", {"value": 0.005}),
    ("wind", {"fx": 0.02, "fy": -0.01, "fz": 0.0}),
    ("mounting_tilt", {"roll": 0.03, "pitch": -0.02}),
    ("delay", {"value": 0.02}),
    ("motor_lag", {"value": 0.02}),
)
FLAGS = ("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking")
QUIET = ("--disable-component-update", "--disable-sync")
TIMES = 11  # switched so often
PAINT = "performance.getEntriesByName('first-contentful-paint')[0].startTime"
FOLLOWED = "performance.getEntriesByName('follow').map((one) => one.duration)"


@dataclass(frozen=True)
class Bench:
    """Write the page of ten flights and five effects, open it, switch.

    Args:
        quick: two flights instead of ten.
        json: write the figures to this file.
    """

    quick: bool = False
    json: Path | None = None

    def run(self) -> None:
        """Measure, print, write."""
        base, data = open_model("crazyflie"), self._data()
        found = Diagnosis("EFFECT", "Missing: five effects.", findings=tuple(_finding(*one) for one in EFFECTS))
        check(base, data)  # a diagnosis has done that before its page is drawn
        with TemporaryDirectory() as folder:
            file = Path(folder) / "report.html"
            started, worked = time.perf_counter(), time.process_time()
            write_page(diagnosis_page(base, data, found, "five effects"), file)
            took, work = time.perf_counter() - started, time.process_time() - worked
            paint, follow = _in_browser(file)
            size = file.stat().st_size / 1e6
        figures = [
            Figure(f"report of {len(data)} flights of {len(data[0])} rows", took, "s", "< 10"),
            Figure("the same in processor time, where others use the machine too", work, "s"),
            Figure("its size", size, "MB", "< 5"),
            Figure("first contentful paint", paint, "s", "< 1"),
            Figure("an effect switched, median", follow, "ms", "< 50"),
        ]
        report("the report as a page", figures, [1], self.json)

    def _data(self) -> Dataset:
        return Dataset(simulate_case(Case("crazyflie", EFFECTS, seed=1), 2 if self.quick else 10, 400))


def _finding(effect: str, values: dict[str, float]) -> Finding:
    return Finding(effect, {name: Estimate(one, one, one, "") for name, one in values.items()}, 0.2)


def _in_browser(file: Path) -> tuple[float, float]:
    """First contentful paint in s, and the median time in ms from a switch to the new curves in view."""
    from playwright.sync_api import sync_playwright

    program = which("chromium") or which("google-chrome")
    assert program is not None, "a Chromium is needed: apt-get install chromium"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=[*FLAGS, *QUIET])
        page = browser.new_page(viewport={"width": 1600, "height": 1000})
        page.goto(file.as_uri())
        page.wait_for_function("document.documentElement.dataset.ready === 'yes'")
        paint = page.evaluate(PAINT) / 1e3
        page.locator("#added h3").last.scroll_into_view_if_needed()
        page.wait_for_timeout(500)
        durations = _switched(page)
        browser.close()
    return float(paint), sorted(durations)[len(durations) // 2]


def _switched(page: Any) -> list[float]:
    for _ in range(TIMES):
        page.locator("input[name=switch]").first.click()
        page.wait_for_timeout(50)
    return page.evaluate(FOLLOWED)


if __name__ == "__main__":
    tyro.cli(Bench).run()
