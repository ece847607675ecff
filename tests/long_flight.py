"""A quadrotor's flight of any length in formulas, with the columns that foreign logs have."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from scipy.spatial.transform import Rotation

from sym2real.trajectory import Array

GRAVITY, HOVER = 9.81, 0.5  # m/s²; command that carries the weight
# Widths in m, frequencies in rad/s and phases of x, y, z and, in rad, of yaw.
SIZE, PACE, PHASE = np.array([1.5, 1.0, 0.3]), np.array([0.5, 0.65, 0.35]), np.array([0.0, 0.3, 0.0])
YAW, YAW_PACE = 0.3, 0.2
# Command of each motor (front right, rear right, rear left, front left) per angular acceleration about x, y, z.
MIXED = 2e-3 * np.array([[-1.0, -1.0, -0.5], [-1.0, 1.0, 0.5], [1.0, 1.0, -0.5], [1.0, -1.0, 0.5]])


def flight(rows: int, hertz: float, seed: int = 0) -> dict[str, Array]:
    """Columns ``# (rows,)`` of a flat flight: it leans as its acceleration asks, velocity and gyro are noisy."""
    rng = np.random.default_rng(seed)
    time = np.arange(rows) / hertz
    angle = time[:, None] * PACE + PHASE
    position, velocity = SIZE * np.sin(angle), SIZE * PACE * np.cos(angle)
    force = -SIZE * PACE**2 * np.sin(angle) + [0.0, 0.0, GRAVITY]
    thrust = np.linalg.norm(force, axis=1)
    up = force / thrust[:, None]
    yaw = YAW * np.sin(YAW_PACE * time)
    left = np.cross(up, np.stack([np.cos(yaw), np.sin(yaw), np.zeros(rows)], axis=1))
    left /= np.linalg.norm(left, axis=1)[:, None]
    attitude = Rotation.from_matrix(np.stack([np.cross(left, up), left, up], axis=2))
    turns = (attitude[:-1].inv() * attitude[1:]).as_rotvec() * hertz
    rates = np.concatenate([turns, turns[-1:]])
    motors = HOVER * thrust[:, None] / GRAVITY + np.gradient(rates, 1.0 / hertz, axis=0) @ MIXED.T
    groups = {
        "pos_{}": (position, "xyz"),
        "vel_{}": (velocity + 0.002 * rng.standard_normal((rows, 3)), "xyz"),
        "q_{}": (attitude.as_quat(canonical=True)[:, [3, 0, 1, 2]], "wxyz"),
        "gyro_{}": (rates + 0.01 * rng.standard_normal((rows, 3)), "xyz"),
        "motor{}": (motors, "1234"),
    }
    parts = {
        name.format(key): part
        for name, (values, keys) in groups.items()
        for key, part in zip(keys, values.T, strict=True)
    }
    return {"timestamp": time, **parts}


def save(columns: dict[str, Array], path: Path) -> Path:
    """Write columns as Parquet."""
    pq.write_table(pa.table(columns), path)
    return path
