"""MPPI's back ends beside other libraries, in one run: interleaved rounds, medians and p99, ratios, a figure.

Every contestant's rollout is compared with float64 torch before anything is timed. Pin the run to free cores:

    taskset -c 0 .venv/bin/python tools/bench/mppi.py --equations ../shared/reference_equations.json \\
        --json docs/figures/mppi.json --figure docs/figures/mppi.png

The extra ``bench`` brings JAX and sympytorch; what is not installed is left out and said so. ``--device cuda`` (extra
``gpu``) times the kernel and torch there, alone.
"""

import gc
import os
import time
from dataclasses import dataclass
from pathlib import Path

import torch
import tyro
from figures import Figure, report
from mppi_contestants import CONSOLE, LIMIT, Contestant, contestants, on_device
from mppi_figure import draw
from mppi_limit import SLOTS, multiply_adds
from mppi_live import diagnosis, first_calls, held, import_time, with_samples
from mppi_models import HORIZON, subject
from mppi_table import markdown

from sym2real.control.backend import device_of

SAMPLES = (256, 1024, 4096, 16384)
MAIN = 1024
SAMPLES_ON_A_GPU = (1024, 16384, 131072, 1 << 20)
BUDGET = 3.0  # s a round may take of the slow ones


@dataclass(frozen=True)
class Options:
    """Compare MPPI with other libraries.

    Args:
        equations: the fixed equations.
        robots: robots of that file.
        samples: numbers of samples; by default 256 to 16384, or 1024 to 1048576 on another device than the processor.
        device: where to plan; on another than the processor the kernel and torch are timed, and nothing else.
        rounds: rounds, in each of which every contestant runs at least once.
        seconds: length of each control loop.
        quick: 1024 samples, few rounds, short loops.
        live: control loops, first calls, import, diagnosis.
        json: write the figures to this file (- is standard output).
        figure: draw the times to this file.
    """

    equations: Path = Path("../shared/reference_equations.json")
    robots: tuple[str, ...] = ("crazyflie", "mushr")
    samples: tuple[int, ...] = ()
    device: str = "cpu"
    rounds: int = 40
    seconds: float = 60.0
    quick: bool = False
    live: bool = True
    json: Path | None = None
    figure: Path | None = None


def run(found: list[Contestant], rounds: int) -> None:
    """Interleaved rounds: whatever disturbs the machine disturbs everybody."""
    with torch.no_grad():
        for contestant in found:
            for _ in range(3):
                contestant.step()
        gc.disable()
        for _ in range(rounds):
            for contestant in found:
                if sum(contestant.seconds) > BUDGET and len(contestant.seconds) > 10:
                    continue
                for _ in range(contestant.repeats):
                    started = time.perf_counter()
                    contestant.step()
                    contestant.seconds.append(time.perf_counter() - started)
        gc.enable()


def main(options: Options) -> None:
    """Measure, print, write."""
    device_of(options.device)
    torch.set_num_threads(1)
    if hasattr(os, "sched_getaffinity"):
        CONSOLE.print(f"on cores {sorted(os.sched_getaffinity(0))}")
    here = options.device == "cpu"
    samples = (MAIN,) if options.quick else options.samples or (SAMPLES if here else SAMPLES_ON_A_GPU)
    rounds = 8 if options.quick else options.rounds
    figures: list[Figure] = []
    for name in options.robots:
        one = subject(name, options.equations)
        for count in samples:
            CONSOLE.print(f"{name}, {count} samples")
            found = contestants(one, count, others=count == MAIN) if here else on_device(one, count, options.device)
            run(found, rounds)
            figures += times(name, count, [one for one in found if one.name != LIMIT])
            if count == MAIN and here:
                figures += [*(shares(found, count) if name == "crazyflie" else []), *ratios(name, found)]
    if options.live and here:
        one = with_samples(subject("crazyflie", options.equations), MAIN)
        figures += [*first_calls(options.equations), *held(one, 5.0 if options.quick else options.seconds)]
        figures += [import_time(), *diagnosis()]
    report("MPPI, one step over 40 periods", figures, [0], options.json)
    CONSOLE.print(markdown(figures), markup=False, soft_wrap=True)
    if options.figure is not None:
        draw(figures, options.figure)


def times(name: str, count: int, found: list[Contestant]) -> list[Figure]:
    """Medians and p99."""
    figures = []
    for one in found:
        most = one.name == "c" and count in (max(SAMPLES), max(SAMPLES_ON_A_GPU)) and name == "crazyflie"
        bar = "< 20" if most else ""
        label = f"{name}, N = {count}: {one.name}"
        figures.append(Figure(label, 1e3 * one.median, "ms"))
        figures.append(Figure(f"{label}, p99", 1e3 * one.p99, "ms", bar))
    return figures


def shares(found: list[Contestant], count: int) -> list[Figure]:
    """The arithmetic limit over the kernel's time: of medians, and of the least times, which nobody disturbed."""
    slots = SLOTS * count * HORIZON / multiply_adds()
    limit, ours = (next(one for one in found if one.name == name) for name in (LIMIT, "c"))
    return [
        Figure("arithmetic limit of the reference equations", 1e3 * slots * limit.median, "ms"),
        Figure("share of the arithmetic limit", 100 * slots * limit.median / ours.median, "%"),
        Figure("arithmetic limit, least", 1e3 * slots * min(limit.seconds), "ms"),
        Figure("share of the arithmetic limit, least times", 100 * slots * min(limit.seconds) / min(ours.seconds), "%"),
    ]


def ratios(name: str, found: list[Contestant]) -> list[Figure]:
    """The bars of the issue; those of the quadrotor count."""
    by_name = {one.name: one.median for one in found}
    counted, memory = name == "crazyflie", "residual 2×64, 10 past commands"
    pairs = (
        ("pytorch-mppi over ours", "pytorch-mppi", "c", ">= 50"),
        ("pytorch-mppi compiled over ours", "pytorch-mppi compiled", "c", ">= 30"),
        ("JAX scan over ours", "JAX scan", "c", ">= 35"),
        ("pytorch-mppi over TorchScript alone", "pytorch-mppi", "torch", ">= 1.6"),
        ("residual 2×64: pytorch-mppi over ours", "pytorch-mppi, residual 2×64", "c, residual 2×64", ">= 10"),
        (f"{memory}: pytorch-mppi over ours", f"pytorch-mppi, {memory}", f"c, {memory}", ">= 8"),
    )
    over = {label: (by_name[above] / by_name[below], bar) for label, above, below, bar in pairs if above in by_name}
    networks = [value for key, value in by_name.items() if key.startswith("ensemble")]
    over["fastest ensemble over SR"] = min(networks) / by_name["c"], ">= 100"
    return [Figure(f"{name}: {label}", value, "×", bar if counted else "") for label, (value, bar) in over.items()]


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
