"""Data for the regression tests: polynomial systems, and a rigid body integrated here, by no code of the package."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import sympy

from sym2real.dataset import Transitions
from sym2real.layout import Layout, Layouts

QUADROTOR = Layouts(
    Layout.of(["x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz"]),
    Layout.of(["thrust", "wx_cmd", "wy_cmd", "wz_cmd"]),
    Layout.of(["fx", "fy", "fz", "tx", "ty", "tz"]),
)
MASS, GRAVITY, DT = 0.027, 9.81, 0.02
INERTIA = np.array([1.66e-5, 1.67e-5, 2.93e-5])
GAINS = np.array([50.0, 50.0, 20.0])
PUSH = np.array([0.08, 0.08, 0.08, 1e-3, 1e-3, 5e-4])


def evaluate(expression: sympy.Expr, columns: Mapping[str, np.ndarray]) -> np.ndarray:
    """Values of an expression over columns ``# (rows,)``, by SymPy's own printer."""
    names = sorted(used.name for used in expression.free_symbols)
    function = sympy.lambdify([sympy.Symbol(name, real=True) for name in names], expression, "numpy")
    return np.broadcast_to(function(*(columns[name] for name in names)), len(next(iter(columns.values()))))


def transitions_of(layouts: Layouts, dt: float, *arrays: np.ndarray) -> Transitions:
    """Transitions from state, action, inputs and next state ``# (trajectories, steps, columns)``."""
    trajectories, steps = arrays[0].shape[:2]
    flat = [values.reshape(trajectories * steps, values.shape[-1]) for values in arrays]
    number, step = np.divmod(np.arange(trajectories * steps), steps)
    return Transitions(*flat, layouts=layouts, dt=dt, trajectory=number, step=step)


def concatenated(*parts: Transitions) -> Transitions:
    """Transitions one after the other, their trajectories numbered on."""
    firsts = np.cumsum([0, *(part.trajectory.max() + 1 for part in parts)])
    arrays = [
        np.concatenate([getattr(part, name) for part in parts]) for name in ("state", "action", "inputs", "next_state")
    ]
    number = np.concatenate([part.trajectory + first for part, first in zip(parts, firsts, strict=False)])
    return Transitions(*arrays, parts[0].layouts, parts[0].dt, number, np.concatenate([part.step for part in parts]))


def drawn(
    columns: Sequence[str],
    actions: Sequence[str],
    step: Callable[[dict[str, np.ndarray]], dict[str, np.ndarray]],
    rows: int = 300,
    *,
    seed: int = 0,
    size: float = 2.0,
) -> Transitions:
    """Independent rows of a system: ``step`` gives every column's increment from all columns."""
    rng = np.random.default_rng(seed)
    layouts = Layouts(Layout.of(columns), Layout.of(actions))
    state, action = rng.uniform(-size, size, (1, rows, len(columns))), rng.uniform(-1.5, 1.5, (1, rows, len(actions)))
    names = dict(zip([*columns, *actions], np.concatenate([state, action], axis=-1)[0].T, strict=True))
    increments = step(names)
    moved = np.stack([np.broadcast_to(increments[column], rows) for column in columns], axis=-1)
    return transitions_of(layouts, 0.1, state, action, np.zeros((1, rows, 0)), state + moved)


def _cross_quaternions(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    aw, av, bw, bv = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    return np.concatenate([aw * bw - (av * bv).sum(-1, keepdims=True), aw * bv + bw * av + np.cross(av, bv)], axis=-1)


def _body_z(q: np.ndarray) -> np.ndarray:
    w, x, y, z = np.moveaxis(q, -1, 0)
    return np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=-1)


def fly(state: np.ndarray, action: np.ndarray, wrench: np.ndarray) -> np.ndarray:
    """One control period of a rigid body with a proportional rate loop, at 500 Hz; arrays ``# (..., columns)``."""
    p, q, v, w = state[..., :3], state[..., 3:7], state[..., 7:10], state[..., 10:]
    for _ in range(10):
        force = _body_z(q) * action[..., :1] + wrench[..., :3]
        torque = INERTIA * GAINS * (action[..., 1:] - w) + wrench[..., 3:]
        v = v + 0.002 * (force / MASS - np.array([0.0, 0.0, GRAVITY]))
        w = w + 0.002 * (torque - np.cross(w, INERTIA * w)) / INERTIA
        angle = np.linalg.norm(w, axis=-1, keepdims=True) * 0.002
        turn = np.concatenate([np.cos(angle / 2), 0.001 * w * np.sinc(angle / 2 / np.pi)], axis=-1)
        q = _cross_quaternions(q, turn)
        p = p + 0.002 * v
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return np.concatenate([p, q, v, w], axis=-1)


def flights(seed: int, count: int = 6, steps: int = 150, pushed: bool = False, wild: float = 1.0) -> Transitions:
    """Flights with random commands held for 0.1 s, levelled so that they stay up."""
    rng = np.random.default_rng(seed)
    state = np.zeros((count, 13))
    state[:, 3] = 1.0
    tilt = 0.2 * wild * rng.standard_normal((count, 3))
    state[:, 3:7] = np.concatenate([np.ones((count, 1)), tilt], axis=1)
    state[:, 3:7] /= np.linalg.norm(state[:, 3:7], axis=1, keepdims=True)
    phases, speeds = rng.uniform(0, 6.3, (count, 6)), rng.uniform(2, 8, (count, 6))
    rows: list[tuple[np.ndarray, ...]] = []
    for step in range(steps):
        if step % 5 == 0:
            thrust = MASS * GRAVITY * (1 + 0.3 * wild * rng.uniform(-1, 1, (count, 1)))
            rates = wild * rng.uniform(-3, 3, (count, 3))
        level = -6.0 * state[:, 4:7] * np.sign(state[:, 3:4]) / wild
        action = np.concatenate([thrust, rates + level], axis=1)
        wrench = PUSH * np.sin(phases + speeds * DT * step) * pushed
        following = fly(state, action, wrench)
        rows.append((state, action, wrench, following))
        state = following
    arrays = [np.stack(values, axis=1) for values in zip(*rows, strict=True)]
    return transitions_of(QUADROTOR, DT, *arrays)
