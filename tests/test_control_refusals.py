"""What MPPI and its kernels refuse, in one clear error: the kernel reads memory as it lies, so nothing may pass."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch

from sym2real.control import MPPI
from sym2real.errors import ShapeError, Sym2RealError, UnknownNameError
from sym2real.layout import Layout, Layouts
from sym2real.native import find_compiler
from sym2real.robots import CRAZYFLIE, Limits, MPPISettings
from sym2real.symbolic import Equations, compile_model, symbol
from sym2real.tasks import make_task

BACKENDS = ["torch", pytest.param("c", marks=pytest.mark.skipif(find_compiler() is None, reason="no C compiler"))]
MODEL = compile_model(CRAZYFLIE.nominal())
SETTINGS = replace(CRAZYFLIE.mppi, samples=32)


def mppi(backend: str, **options: Any) -> MPPI:
    return MPPI(
        MODEL, CRAZYFLIE, make_task("hover", CRAZYFLIE), **{"settings": SETTINGS, "backend": backend, **options}
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"samples": 0}, "at least 1 sample and at most 1048576, found 0"),
        ({"samples": 10**11}, "at most 1048576, found 100000000000"),
        ({"samples": "many"}, "found 'many'"),
        ({"horizon": 0.0}, "horizon > 0"),
        ({"horizon": float("nan")}, "horizon > 0"),
        ({"temperature": 0.0}, "temperature > 0"),
        ({"correlation": -1.0}, "correlation >= 0"),
    ],
)
def test_settings_that_sample_nothing(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ShapeError, match=message):
        MPPISettings(**options)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("noise", [(), (1.0,), (1.0,) * 5, (float("nan"),) * 4, np.eye(3), np.ones((2, 4)), 3.0])
def test_noise_of_other_actions(backend: str, noise: Any) -> None:
    """The robot's own settings may have none at all: what the kernel then read was somebody else's memory."""
    with pytest.raises(ShapeError, match="for 4 actions"):
        mppi(backend, settings=replace(SETTINGS, noise=noise))


def test_periods() -> None:
    for period in (0.0, -0.02, float("nan")):
        with pytest.raises(ShapeError, match="period > 0"):
            mppi("torch", period=period)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"device": "gpu"}, r"device: expected one that torch has here \(cpu.*found 'gpu'"),
        ({"device": "cuda:99"}, "found 'cuda:99'"),
    ],
)
def test_devices_that_there_are_not(options: dict[str, Any], message: str) -> None:
    with pytest.raises(Sym2RealError, match=message):
        mppi("auto", **options)


@pytest.mark.parametrize("backend", ["cuda", "C", None, ""])
def test_a_backend_that_does_not_exist_is_not_taken_for_any(backend: Any) -> None:
    with pytest.raises(UnknownNameError, match=r"backend.*auto, c, torch"):
        mppi(backend)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("state", ["abc", [[1.0], [1.0, 2.0]], {"x": 1.0}])
def test_a_state_that_is_no_numbers(backend: str, state: Any) -> None:
    with pytest.raises(ShapeError, match="expected numbers, found"):
        mppi(backend).act(state, 0)


@pytest.mark.parametrize("backend", BACKENDS)
def test_states_inputs_and_noise_of_other_shapes(backend: str) -> None:
    controller, start = mppi(backend), CRAZYFLIE.start
    for state in (start[:5], start[None]):
        with pytest.raises(ShapeError, match="state: expected"):
            controller.act(state, 0)
    with pytest.raises(ShapeError, match="inputs: expected"):
        controller.act(start, 0, np.zeros(2))
    for shape in ((32, 3, 4), (32, 40), (0, 40, 4)):
        with pytest.raises(ShapeError, match="noise: expected"):
            controller.improve(start, 0, torch.zeros(shape))
    assert np.isfinite(controller.act(start, 0)).all()  # none of it left a trace


@pytest.mark.parametrize("backend", BACKENDS)
def test_inputs_that_the_equations_use_are_asked_for(backend: str) -> None:
    """Nobody may take a battery's voltage for zero; the wrench may be, and where nothing is planned yet, so may it."""
    layouts = Layouts(Layout.of(("x", "vx")), Layout.of(("push",)), Layout.of(("vbat", "fx")))
    equations = Equations.parse(layouts, {"x": "x + 0.1*vx", "vx": "vx + 0.1*push*vbat + fx"}, 0.1)
    one = np.ones(1)
    described = replace(CRAZYFLIE.description, rest=0 * one, start=np.ones(2))
    cart = replace(CRAZYFLIE, layouts=layouts, dt=0.1, limits=Limits(-one, one), description=described)
    task = replace(make_task("hover", CRAZYFLIE), cost=symbol("x") ** 2, reference=lambda at: torch.zeros(*at.shape, 2))
    settings = replace(SETTINGS, noise=(0.5,))
    controller = MPPI(compile_model(equations), cart, task, settings=settings, backend=backend, period=10.0)
    with pytest.raises(ShapeError, match="needs its inputs vbat fx: vbat"):
        controller.act(cart.start, 0)
    assert controller.act(cart.start, 0, np.array([4.0, 0.0])) < 0.0


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_plan_is_told_of_the_state_as_it_was(backend: str) -> None:
    """A simulator hands out the memory in which its state goes on; in the precision planned with, nothing converts."""
    double = backend == "torch"  # the kernel has single precision alone
    controller = mppi(backend, dtype=torch.float64 if double else torch.float32)
    state = CRAZYFLIE.start.astype(np.float64 if double else np.float32)
    controller.act(state, 0)
    state += 100.0
    assert float(controller.plan.states[:, 0, 0].abs().max()) < 1.0
