"""MPPI's back ends beside other libraries, in one run: interleaved rounds, medians and p99, ratios, a figure.

Every contestant's rollout is compared with float64 torch before anything is timed. Pin the run to free cores:

    taskset -c 0 .venv/bin/python tools/bench/mppi.py --equations ../shared/reference_equations.json \\
        --json docs/figures/mppi.json --figure docs/figures/mppi.png

The extra ``bench`` brings JAX and sympytorch; what is not installed is left out and said so.
"""

from __future__ import annotations

import gc
import importlib.util
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import torch
import tyro
from figures import Figure, report
from mppi_figure import draw
from mppi_limit import SLOTS, slots_per_second
from mppi_live import diagnosis, first_calls, held, import_time, one_thread, quieter
from mppi_models import HORIZON, Subject, residual, subject
from mppi_rivals import (
    Rollout,
    Step,
    own_module,
    plain_module,
    stepped,
    sympytorch_dynamics,
    with_jax,
    with_pytorch_mppi,
)
from rich.console import Console

from sym2real.control import MPPI
from sym2real.neural import Composed, Ensemble
from sym2real.symbolic import compile_model, rollout

CONSOLE = Console(stderr=True)
SAMPLES = (256, 1024, 4096, 16384)
MAIN = 1024
TOLERANCE = {"states": 1e-3}  # of float32 rivals, relative to the largest state, over 40 steps
BUDGET = 3.0  # s a round may take of the slow ones


@dataclass(frozen=True)
class Options:
    """Compare MPPI with other libraries."""

    equations: Path = Path("../shared/reference_equations.json")
    """The fixed equations."""
    robots: tuple[str, ...] = ("crazyflie", "mushr")
    """Robots of that file."""
    samples: tuple[int, ...] = SAMPLES
    """Numbers of samples."""
    rounds: int = 40
    """Rounds, in each of which every contestant runs at least once."""
    seconds: float = 60.0
    """Length of each control loop."""
    quick: bool = False
    """1024 samples, few rounds, short loops."""
    live: bool = True
    """Control loops, first calls, import, diagnosis."""
    json: Path | None = None
    """Write the figures to this file (- is standard output)."""
    figure: Path | None = None
    """Draw the times to this file."""


@dataclass
class Contestant:
    """One way to take a step of MPPI.

    Args:
        name: shown.
        step: takes it.
        repeats: calls a round.
    """

    name: str
    step: Step
    repeats: int = 1
    seconds: list[float] = field(default_factory=list)

    @property
    def median(self) -> float:
        return float(np.median(self.seconds))

    @property
    def p99(self) -> float:
        return float(np.quantile(self.seconds, 0.99))


def has(package: str) -> bool:
    """Whether a package is installed; said where it is not."""
    found = importlib.util.find_spec(package) is not None
    if not found:
        CONSOLE.print(f"{package} is not installed (extra bench): left out")
    return found


def checked(one: Subject, name: str, roll: Rollout, exact: Rollout) -> None:
    """Stop where a contestant does not compute what float64 torch does."""
    generator = torch.Generator().manual_seed(0)
    robot = one.robot
    start = torch.from_numpy(one.start).float().repeat(64, 1)
    noise = torch.randn(64, HORIZON, len(robot.rest), generator=generator) * torch.tensor(robot.mppi.noise)
    actions = (torch.tensor(robot.rest) + noise).clamp(torch.tensor(robot.low), torch.tensor(robot.high)).float()
    with torch.no_grad():
        expected = exact(start.double(), actions.double())
        error = float((roll(start, actions).double() - expected).abs().max() / expected.abs().max())
    if not error < TOLERANCE["states"]:
        raise SystemExit(f"{name} computes something else: states differ by {error:.1e} after {HORIZON} steps")
    CONSOLE.print(f"  {name}: states differ by {error:.1e} of the largest")


def ours(one: Subject, model: object, **options: object) -> Step:
    """Our controller's ``act``, at one step after another."""
    mppi = MPPI(model, one.robot, one.task, **options)
    steps = iter(range(1 << 30))
    return lambda: mppi.act(one.start, next(steps))


def contestants(one: Subject, samples: int, others: bool) -> list[Contestant]:
    """Everybody for one robot and number of samples; slow ones only where ``others`` are asked for."""
    here, module = quieter(one, samples), own_module(one)
    exact = compile_model(one.equations, dtype=torch.float64)
    found = [
        Contestant("c", ours(here, module, backend="c", threads=1), 20),
        Contestant("c, 2 threads", ours(here, module, backend="c", threads=2), 20),
        Contestant("torch", ours(here, module, backend="torch"), 2),
    ]
    small = Composed(one.equations, residual(one.robot, (64, 64)))
    found += [Contestant("c, residual 2×64", ours(here, small, backend="c", threads=1), 5)]
    if not others:
        return found
    reference: Rollout = lambda state, actions: rollout(exact, state, actions)  # noqa: E731
    checked(one, "torch", lambda state, actions: rollout(module, state, actions), reference)
    checked(one, "pytorch-mppi", stepped(module), reference)
    found.append(Contestant("pytorch-mppi", with_pytorch_mppi(here, module, samples)))
    found.append(
        Contestant("pytorch-mppi compiled", with_pytorch_mppi(here, plain_module(one), samples, compiled=True))
    )
    if has("sympytorch"):
        dynamics = sympytorch_dynamics(one)
        checked(one, "sympytorch", stepped(dynamics), reference)
        found.append(Contestant("pytorch-mppi, sympytorch", with_pytorch_mppi(here, dynamics, samples)))
    if has("jax"):
        _, roll = with_jax(one, 64)
        checked(one, "JAX scan", roll, reference)
        found.append(Contestant("JAX scan", with_jax(here, samples)[0]))
    return [*found, *_networks(here, samples, small)]


def _networks(here: Subject, samples: int, small: Composed) -> list[Contestant]:
    """Ensembles instead of equations, and residuals on top of them."""
    ensemble = Ensemble(here.robot.layouts).eval()
    wide = Composed(here.equations, residual(here.robot, (200,) * 4))
    checked(here, "residual 2×64", small.rollout, _in_double(here, (64, 64)))
    found = [
        Contestant("torch, residual 2×64", ours(here, small, backend="torch")),
        Contestant("pytorch-mppi, residual 2×64", with_pytorch_mppi(here, small, samples)),
        Contestant("c, residual 4×200", ours(here, wide, backend="c", threads=1)),
        Contestant("torch, residual 4×200", ours(here, wide, backend="torch")),
        Contestant("ensemble, torch", ours(here, ensemble, backend="torch")),
        Contestant("ensemble, oneDNN", ours(here, _one_dnn(ensemble, here), backend="torch")),
    ]
    if has("jax"):
        found.append(Contestant("ensemble, JAX", with_jax(here, samples, ensemble)[0]))
    return found


def _in_double(one: Subject, widths: tuple[int, ...]) -> Rollout:
    return Composed(one.equations, residual(one.robot, widths), dtype=torch.float64).rollout


def _one_dnn(ensemble: Ensemble, one: Subject) -> Callable[..., torch.Tensor]:
    """The ensemble through oneDNN's linear layers, weights laid out for it beforehand."""
    members = [
        [
            (w[m].T.contiguous().to_mkldnn(), b[m, 0].to_mkldnn())
            for w, b in zip(ensemble.weights.parameters(), ensemble.biases.parameters(), strict=True)
        ]
        for m in range(len(ensemble.weights[0]))
    ]

    def model(state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        both = torch.cat([state, action], dim=-1).to_mkldnn()
        total = 0
        for layers in members:
            values = both
            for place, (weight, bias) in enumerate(layers):
                values = torch._C._nn.mkldnn_linear(values.relu() if place else values, weight, bias)
            total = total + values.to_dense()
        return one.robot.layouts.state.normalise(state + total / len(members))

    return model


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
    one_thread()
    if hasattr(os, "sched_getaffinity"):
        CONSOLE.print(f"on cores {sorted(os.sched_getaffinity(0))}")
    samples = (MAIN,) if options.quick else options.samples
    rounds = 8 if options.quick else options.rounds
    figures: list[Figure] = []
    for name in options.robots:
        one = subject(name, options.equations)
        for count in samples:
            CONSOLE.print(f"{name}, {count} samples")
            found = contestants(one, count, others=count == MAIN)
            throughput = [slots_per_second() for _ in range(5)]
            run(found, rounds)
            throughput += [slots_per_second() for _ in range(5)]
            figures += times(name, count, found)
            if count == MAIN:
                figures += ratios(name, found, SLOTS * count * HORIZON / max(throughput))
    if options.live:
        one = quieter(subject("crazyflie", options.equations), MAIN)
        figures += [*first_calls(options.equations), *held(one, 5.0 if options.quick else options.seconds)]
        figures += [import_time(), *diagnosis()]
    report("MPPI, one step over 40 periods", figures, [0], options.json)
    if options.figure is not None:
        draw(figures, options.figure)


def times(name: str, count: int, found: list[Contestant]) -> list[Figure]:
    """Medians and p99."""
    figures = []
    for one in found:
        bar = "< 20" if one.name == "c" and count == max(SAMPLES) and name == "crazyflie" else ""
        label = f"{name}, N = {count}: {one.name}"
        figures.append(Figure(label, 1e3 * one.median, "ms"))
        figures.append(Figure(f"{label}, p99", 1e3 * one.p99, "ms", bar))
    return figures


def ratios(name: str, found: list[Contestant], limit: float) -> list[Figure]:
    """The bars of the issue; those of the quadrotor count."""
    by_name = {one.name: one.median for one in found}
    counted = name == "crazyflie"

    def ratio(label: str, above: str, below: str, bar: str) -> list[Figure]:
        if above not in by_name:
            return []
        return [Figure(f"{name}: {label}", by_name[above] / by_name[below], "×", bar if counted else "")]

    figures = []
    if counted:
        figures.append(Figure("arithmetic limit of the reference equations", 1e3 * limit, "ms"))
        figures.append(Figure("share of the arithmetic limit", 100 * limit / by_name["c"], "%", ">= 70"))
    figures += ratio("pytorch-mppi over ours", "pytorch-mppi", "c", ">= 50")
    figures += ratio("pytorch-mppi compiled over ours", "pytorch-mppi compiled", "c", ">= 30")
    figures += ratio("JAX scan over ours", "JAX scan", "c", ">= 35")
    figures += ratio("pytorch-mppi over TorchScript alone", "pytorch-mppi", "torch", ">= 1.6")
    figures += ratio(
        "residual 2×64: pytorch-mppi over ours", "pytorch-mppi, residual 2×64", "c, residual 2×64", ">= 10"
    )
    networks = [value for key, value in by_name.items() if key.startswith("ensemble")]
    figures.append(
        Figure(f"{name}: fastest ensemble over SR", min(networks) / by_name["c"], "×", ">= 100" if counted else "")
    )
    return figures


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
