"""A diagnosis with two findings on two logs, as a page; and a browser to open it in."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path
from shutil import which
from typing import Any

import pytest
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset
from sym2real.diagnosis import Diagnosis, Estimate, Finding, Floor
from sym2real.diagnosis.errors.rungs import Rung, RungError
from sym2real.diagnosis.predict.competitors import NotTested
from sym2real.diagnosis.score.held_out import Gate
from sym2real.diagnosis.unexplained.leftover import Leftover
from sym2real.robots import CRAZYFLIE

# What a file may be called, or say of itself, that would be a program in a careless page.
HOSTILE = """</script><script>window.broken=1</script><img src=x onerror="window.broken=1">{{7*7}}'"&\u2028"""
TRUTH: dict[str, dict[str, float]] = {"added_mass": {"value": 0.005}, "wind": {"fx": 0.02, "fy": -0.01}}
CHANNELS = {"position": "m", "attitude": "rad", "velocity": "m/s", "rate": "rad/s"}
HORIZONS = (0.1, 0.5, 0.8)
# Chromium as root, offline; without these it calls its makers' hosts at every start.
FLAGS = ("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking")
PATIENCE = 120_000  # ms; a busy machine takes its time
QUIET = ("--disable-component-update", "--disable-sync")


@cache
def logs() -> Dataset:
    """Two flights of a Crazyflie that is heavier, in wind; the second has a hostile name."""
    flown = simulate_case(Case("crazyflie", tuple(TRUTH.items()), seed=1), 2, 220)
    return Dataset([flown[0], replace(flown[1], name=HOSTILE)])


def finding(effect: str, **more: Any) -> Finding:
    """The true effect with made-up intervals."""
    units = {"added_mass": "kg", "wind": "N"}
    values = {name: Estimate(value, 0.9 * value, 1.1 * value, units[effect]) for name, value in TRUTH[effect].items()}
    return Finding(effect, values, **more)


def stage(name: str, size: float) -> Rung:
    """A step of a ladder whose errors grow with the horizon."""
    errors = {
        horizon: {
            channel: RungError(size * horizon, size * horizon, 0.9 * size * horizon, 1.1 * size * horizon, unit)
            for channel, unit in CHANNELS.items()
        }
        for horizon in HORIZONS
    }
    return Rung(name, errors)


def diagnosis() -> Diagnosis:
    """Both effects found, with hostile remarks."""
    findings = (
        finding("added_mass", share=0.7, group=("added_mass", "gain:thrust"), separate_by=HOSTILE, fix="weigh it",
                probability=0.93, log_spread={"value": 0.0002}),
        finding("wind", share=0.2, provisional=True, fix="shut the window"),
    )  # fmt: skip
    stages = (stage("base", 1.0), stage("+ added_mass", 0.5), stage("+ wind", 0.2))
    return Diagnosis(
        "EFFECT",
        f"Missing: added_mass and wind. {HOSTILE}",
        findings=findings,
        leftovers=(Leftover("height", "fz", 0.3, "above 1 m"),),
        ladder=stages,
        floor=tuple(Floor(one, {name: (0.05 * one, unit) for name, unit in CHANNELS.items()}) for one in HORIZONS),
        held_out=("run_1", HOSTILE),
        gate=Gate(stages[0], stages[-1]),
        seconds=12.0,
        tried=88,
        not_tried=(NotTested("payload", HOSTILE),),
        notes=(HOSTILE,),
        misfit=(31.0, 1.04),
    )


BASE = CRAZYFLIE.nominal()


def chromium() -> str:
    """The browser's program; skips where there is none."""
    found = which("chromium") or which("chromium-browser") or which("google-chrome")
    if found is None:
        pytest.skip("no Chromium on this machine (Debian: apt-get install chromium): the page is not opened")
    return found


@contextmanager
def browser() -> Iterator[Any]:
    """A headless Chromium."""
    program = chromium()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=program, args=[*FLAGS, *QUIET], timeout=PATIENCE)
        try:
            yield opened
        finally:
            opened.close()


def picture(name: str) -> Path:
    """Where a screenshot is kept for people."""
    folder = Path(__file__).resolve().parents[1] / "build" / "report"
    folder.mkdir(parents=True, exist_ok=True)
    return folder / f"{name}.png"
