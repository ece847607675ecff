"""What a control loop feels: first calls, missed periods alone and beside busy processes, the diagnosis, the import."""

import logging
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import numpy as np
from figures import Figure
from mppi_limit import multiply_adds
from mppi_models import Subject
from standard_cases import standard_cases
from standard_set import simulate_case

from sym2real.control import MPPI
from sym2real.diagnosis import diagnose
from sym2real.robots import ROBOTS
from sym2real.symbolic import compile_model
from sym2real.symbolic.native_choice import torch_alone

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
        cold, *warm = (_printed(code, XDG_CACHE_HOME=cache) for _ in range(4))
    return [
        Figure("first call, cold cache", cold, "s", "< 1.5"),
        Figure("first call, warm cache", min(warm), "s", "< 0.05"),
    ]


def _printed(code: str, **environment: str) -> float:
    """The number that a fresh process prints."""
    command, around = [sys.executable, "-c", code], {**os.environ, **environment}
    return float(subprocess.run(command, env=around, capture_output=True, text=True, check=True).stdout)


def import_time() -> Figure:
    """What ``import sym2real`` takes beyond ``import torch``, least of five."""

    def seconds(code: str) -> float:
        timed = f"import torch, time; t = time.perf_counter(); {code}; print(time.perf_counter() - t)"
        return _printed(timed)

    return Figure("import sym2real beyond torch", min(seconds("import sym2real") for _ in range(5)), "s", "< 0.3")


BUSY = "while True: sum(range(10_000))"


def held(subject: Subject, seconds: float) -> list[Figure]:
    """Missed periods at 50 Hz: the kernel alone and beside a busy process on every core it may use; no compiler."""
    fused = MPPI(compile_model(subject.equations), subject.robot, subject.task, backend="c")
    figures = [_pauses(seconds), *_loop("c", fused, subject, seconds, "< 1")]
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


def _pauses(seconds: float) -> Figure:
    """What this machine itself adds: a fixed piece of arithmetic, about as long as an action, in the same loop."""
    durations, _ = _paced(lambda _: multiply_adds(), seconds)
    return Figure("fixed arithmetic: p99 at 50 Hz over its median", _p99(durations) / float(np.median(durations)), "×")


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


def diagnosis() -> list[Figure]:
    """8 × 400 rows with a wind, the rollouts in C and in torch."""
    case = next(case for case in standard_cases("crazyflie", quick=True) if case.keys == ("wind",))
    data, base = simulate_case(case), ROBOTS["crazyflie"].nominal()
    answers, seconds = {}, {}
    for name, back_end in (("c", nullcontext), ("torch", torch_alone), ("c", nullcontext)):  # first with compiling
        started = time.perf_counter()
        with back_end():
            found = diagnose(base, data, None)
        seconds[name] = time.perf_counter() - started
        answers[name] = {f.effect: {k: p.value for k, p in f.parameters.items()} for f in found.findings}
    same = answers["torch"].keys() == answers["c"].keys() and all(
        np.allclose(list(answers["torch"][key].values()), list(answers["c"][key].values()), rtol=1e-4)
        for key in answers["c"]
    )
    return [
        Figure("diagnosis of 8 × 400 rows, fused rollouts", seconds["c"], "s", "<= 5"),
        Figure("diagnosis of 8 × 400 rows, torch", seconds["torch"], "s"),
        Figure("the same answer", float(same), "", ">= 1"),
    ]


def with_samples(subject: Subject, samples: int) -> Subject:
    """The subject with another number of samples."""
    settings = replace(subject.robot.mppi, samples=samples)
    return replace(subject, robot=replace(subject.robot, mppi=settings))
