"""Everybody who takes a step of MPPI in the comparison, held to float64 torch before anything is timed."""

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import torch
from mppi_limit import multiply_adds
from mppi_live import with_samples
from mppi_models import HORIZON, Subject, residual
from mppi_rivals import (
    Rollout,
    Step,
    remembering,
    stepped,
    sympytorch_dynamics,
    with_jax,
    with_pytorch_mppi,
)
from rich.console import Console

from sym2real.control import MPPI
from sym2real.neural import Composed, Ensemble
from sym2real.symbolic import build_module, compile_model, rollout

CONSOLE = Console(stderr=True)
TOLERANCE = 1e-3  # of float32 rivals, relative to the largest state, over 40 steps
LIMIT = "multiply-adds"
COMMANDS = 10  # past ones that a residual with memory sees


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
    if not error < TOLERANCE:
        raise SystemExit(f"{name} computes something else: states differ by {error:.1e} after {HORIZON} steps")
    CONSOLE.print(f"  {name}: states differ by {error:.1e} of the largest")


def ours(one: Subject, model: object, **options: object) -> Step:
    """Our controller's ``act``, at one step after another."""
    mppi = MPPI(model, one.robot, one.task, **options)
    mppi.remember(one.robot.rest)
    steps = iter(range(1 << 30))
    return lambda: mppi.act(one.start, next(steps))


def contestants(one: Subject, samples: int, others: bool) -> list[Contestant]:
    """Everybody for one robot and number of samples; slow ones only where ``others`` are asked for."""
    here, module = with_samples(one, samples), compile_model(one.equations)
    exact = compile_model(one.equations, dtype=torch.float64)
    found = [
        Contestant(LIMIT, multiply_adds, 20),
        Contestant("c", ours(here, module, backend="c"), 20),
        Contestant("torch", ours(here, module, backend="torch"), 2),
    ]
    small = Composed(one.equations, residual(one.robot, (64, 64)))
    late = Composed(one.equations, residual(one.robot, (64, 64), COMMANDS))
    found += [Contestant("c, residual 2×64", ours(here, small, backend="c"), 5)]
    found += [Contestant("c, residual 2×64, 10 past commands", ours(here, late, backend="c"), 5)]
    if not others:
        return found
    reference: Rollout = lambda state, actions: rollout(exact, state, actions)  # noqa: E731
    checked(one, "torch", lambda state, actions: rollout(module, state, actions), reference)
    checked(one, "pytorch-mppi", stepped(module), reference)
    found.append(Contestant("pytorch-mppi", with_pytorch_mppi(here, module, samples)))
    plain = build_module(one.equations).float()  # not scripted: torch.compile can see through it
    found.append(Contestant("pytorch-mppi compiled", with_pytorch_mppi(here, plain, samples, compiled=True)))
    if has("sympytorch"):
        dynamics = sympytorch_dynamics(one)
        checked(one, "sympytorch", stepped(dynamics), reference)
        found.append(Contestant("pytorch-mppi, sympytorch", with_pytorch_mppi(here, dynamics, samples)))
    if has("jax"):
        _, roll = with_jax(one, 64)
        checked(one, "JAX scan", roll, reference)
        found.append(Contestant("JAX scan", with_jax(here, samples)[0]))
    return [*found, *_networks(here, samples, small, late)]


def on_device(one: Subject, samples: int, device: str) -> list[Contestant]:
    """The kernel, with and without a residual, and who else plans on a device."""
    here, module = with_samples(one, samples), compile_model(one.equations, device=device)
    small = Composed(one.equations, residual(one.robot, (64, 64))).to(device)
    found = [
        Contestant("c", ours(here, module, backend="c", device=device), 5),
        Contestant("c, residual 2×64", ours(here, small, backend="c", device=device), 5),
        Contestant("torch", ours(here, module, backend="torch", device=device)),
        Contestant("pytorch-mppi", with_pytorch_mppi(here, module, samples, device=device)),
    ]
    if has("jax"):
        found.append(Contestant("JAX scan", with_jax(here, samples)[0]))
    return found


def _networks(here: Subject, samples: int, small: Composed, late: Composed) -> list[Contestant]:
    """Ensembles instead of equations, and residuals on top of them."""
    ensemble = Ensemble(here.robot.layouts).eval()
    wide = Composed(here.equations, residual(here.robot, (200,) * 4))
    checked(here, "residual 2×64", small.rollout, _in_double(here, (64, 64)))
    checked(here, "residual 2×64, 10 past commands", late.rollout, _in_double(here, (64, 64), COMMANDS))
    with_past = with_pytorch_mppi(here, remembering(late, here), samples, past=COMMANDS)
    found = [
        Contestant("torch, residual 2×64", ours(here, small, backend="torch")),
        Contestant("pytorch-mppi, residual 2×64", with_pytorch_mppi(here, small, samples)),
        Contestant("pytorch-mppi, residual 2×64, 10 past commands", with_past),
        Contestant("c, residual 4×200", ours(here, wide, backend="c")),
        Contestant("torch, residual 4×200", ours(here, wide, backend="torch")),
        Contestant("ensemble, torch", ours(here, ensemble, backend="torch")),
        Contestant("ensemble, oneDNN", ours(here, _one_dnn(ensemble, here), backend="torch")),
    ]
    if has("jax"):
        found.append(Contestant("ensemble, JAX", with_jax(here, samples, ensemble)[0]))
    return found


def _in_double(one: Subject, widths: tuple[int, ...], commands: int = 0) -> Rollout:
    return Composed(one.equations, residual(one.robot, widths, commands), dtype=torch.float64).rollout


def _one_dnn(ensemble: Ensemble, one: Subject) -> Callable[..., torch.Tensor]:
    """The ensemble through oneDNN's linear layers, weights laid out for it beforehand."""
    members = [
        [(w[m].T.contiguous().to_mkldnn(), b[m, 0].to_mkldnn()) for w, b in ensemble.networks.pairs()]
        for m in range(ensemble.networks.count)
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
