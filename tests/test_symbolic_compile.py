"""Compiled models against SymPy's own evaluation, finite differences and each other."""

from __future__ import annotations

import numpy as np
import sympy
import torch

from sym2real.layout import Layout, Layouts
from sym2real.symbolic import Equations, compile_model, rollout, symbol

STATE = ("x", "qw", "qx", "qy", "qz", "vx")
LAYOUTS = Layouts(Layout.of(STATE), Layout.of(["thrust", "wx_cmd"]), Layout.of(["fx", "t"]))
EQUATIONS = Equations.parse(
    LAYOUTS,
    {
        "x": "x + 0.02*vx + sin(0.3*t)*0.1",
        "qw": "qw - 0.01*qx*wx_cmd",
        "qx": "qx + 0.01*qw*wx_cmd*gain",
        "qy": "qy",
        "qz": "0.1",
        "vx": "vx + 0.02*(2*(qx*qz + qw*qy)*thrust + fx)/mass - 0.001*vx**2*gain",
    },
    0.02,
    parameters={"mass": 0.03, "gain": 1.5},
)


def reference_step(equations: Equations, state, action, inputs, parameters):
    layouts = equations.layouts
    names = [*layouts.state, *layouts.action, *layouts.inputs, *equations.parameters]
    function = sympy.lambdify([symbol(name) for name in names], list(equations.next.values()), "numpy")
    columns = [*np.moveaxis(state, -1, 0), *np.moveaxis(action, -1, 0), *np.moveaxis(inputs, -1, 0), *parameters]
    raw = np.stack(np.broadcast_arrays(*function(*columns)), -1)
    return layouts.state.normalise(torch.as_tensor(raw)).numpy()


def random(seed: int, *shape: int) -> torch.Tensor:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


def test_step_is_what_sympy_says() -> None:
    model = compile_model(EQUATIONS, dtype=torch.float64)
    state, action, inputs = random(0, 7, 6), random(1, 7, 2), random(2, 7, 2)
    expected = reference_step(EQUATIONS, state.numpy(), action.numpy(), inputs.numpy(), EQUATIONS.parameters.values())
    np.testing.assert_allclose(model(state, action, inputs).numpy(), expected, rtol=1e-12, atol=1e-12)


def test_rollout_is_stepping() -> None:
    model = compile_model(EQUATIONS, dtype=torch.float64)
    state, actions, inputs = random(0, 7, 6), random(1, 7, 5, 2), random(2, 7, 2)
    found = rollout(model, state, actions, inputs)
    for step in range(5):
        now = inputs.clone()
        now[:, 1] += step * 0.02
        state = model(state, actions[:, step], now)
        torch.testing.assert_close(found[:, step], state, rtol=1e-12, atol=1e-12)
