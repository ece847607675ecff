"""What a control loop feels: first calls, missed periods alone, beside busy processes and without a compiler."""

from __future__ import annotations

import logging
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from unittest.mock import patch

import numpy as np
from figures import Figure
from mppi_models import Subject

from sym2real.control import MPPI
from sym2real.symbolic import compile_model

PERIOD = 0.02

FIRST_CALL = """
import sys, time
sys.path.insert(0, {tools!r})
from pathlib import Path
from mppi_models import subject
from sym2real.control import MPPI
from sym2real.symbolic import compile_model
one = subject("crazyflie", Path({file!r}))
model = compile_model(one.equations)
started = time.perf_counter()
MPPI(model, one.robot, one.task, backend="c").act(one.start, 0)
print(time.perf_counter() - started)
"""


def first_calls(file: Path) -> list[Figure]:
    """Building MPPI and its first action, in fresh processes: empty cache, then the same again."""
    code = FIRST_CALL.format(tools=str(Path(__file__).parent), file=str(file))
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "XDG_CACHE_HOME": cache}
        runs = (subprocess.check_output([sys.executable, "-c", code], env=environment) for _ in range(4))
        cold, *warm = map(float, runs)
    return [
        Figure("first call, cold cache", cold, "s", "< 1.5"),
        Figure("first call, warm cache", min(warm), "s", "< 0.05"),
    ]


BUSY = "while True: sum(range(10_000))"


def held(subject: Subject, seconds: float) -> list[Figure]:
    """Missed periods at 50 Hz: the kernel alone and beside a busy process on every core it may use; no compiler."""
    fused = MPPI(compile_model(subject.equations), subject.robot, subject.task, backend="c")
    figures = _loop("c", fused, subject, seconds, "< 1")
    crowd = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(len(os.sched_getaffinity(0)))]
    try:
        figures += _loop(f"c beside {len(crowd)} busy process(es)", fused, subject, seconds, "")
    finally:
        for one in crowd:
            one.kill()
            one.wait()
    logging.getLogger("sym2real").setLevel(logging.ERROR)
    with patch.dict(os.environ, CC="/nonexistent/cc"):
        slow = MPPI(compile_model(subject.equations), subject.robot, subject.task)
    return [*figures, *_loop(f"no compiler, {slow.samples} samples", slow, subject, seconds, "")]


def _loop(name: str, mppi: MPPI, subject: Subject, seconds: float, bar: str) -> list[Figure]:
    durations, missed = _paced(lambda step: mppi.act(subject.start, step), seconds)
    return [
        Figure(f"{name}: median at 50 Hz", 1e3 * float(np.median(durations)), "ms"),
        Figure(f"{name}: p99 at 50 Hz", 1e3 * _p99(durations), "ms", bar),
        Figure(f"{name}: longest at 50 Hz", 1e3 * max(durations), "ms"),
        Figure(f"{name}: missed periods of {len(durations)}", missed, "", "<= 0"),
    ]


def _paced(work: Callable[[int], object], seconds: float) -> tuple[list[float], int]:
    """Seconds that each of the periods' work took, and how many ended after their period."""
    durations, missed, due = [], 0, time.perf_counter()
    for step in range(round(seconds / PERIOD)):
        due += PERIOD
        started = time.perf_counter()
        work(step)
        ended = time.perf_counter()
        durations.append(ended - started)
        missed += ended > due
        time.sleep(max(0.0, due - time.perf_counter()))
    return durations, missed


def _p99(durations: list[float]) -> float:
    return float(np.quantile(durations, 0.99))
