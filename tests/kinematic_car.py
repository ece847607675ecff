"""A car without physics, for logs whose numbers are known."""

import numpy as np

from sym2real.trajectory import Array


def car(rows: int = 600, step: float = 0.05) -> tuple[Array, Array, Array, Array, Array]:
    """Kinematic bicycle (wheel base 0.3 m) whose steering answers 3 steps late: time, x y, yaw, speed, steer."""
    time = step * np.arange(rows)
    steer, speed = 0.3 * np.sin(0.9 * time), 1.0 + 0.4 * np.sin(0.37 * time)
    yaw = np.cumsum(np.concatenate([[0.0], speed * np.tan(np.roll(steer, 3)) / 0.3 * step])[:-1])
    x = np.cumsum(speed * np.cos(yaw) * step)
    y = np.cumsum(speed * np.sin(yaw) * step)
    return time, np.stack([x, y], axis=1), yaw, speed, steer


def drive(**more: Array) -> dict[str, Array]:
    """Columns ``t``, ``x`` and ``y`` of that car's log, and more."""
    time, position, *_ = car()
    return {"t": time, "x": position[:, 0], "y": position[:, 1], **more}
