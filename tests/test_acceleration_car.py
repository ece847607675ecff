"""A car that is told its steering and its acceleration: from the columns of a log to the effect that its model lacks.

The drives are those of a rolling bicycle whose equations of motion (two ends on wheels, kinetic energy of mass and
turning, drag along the heading) are integrated by SciPy, which shares nothing with the equations that are diagnosed.
"""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

from sym2real.cli import main
from sym2real.logs import inspect_logs
from sym2real.trajectory import Array

STEP, ROWS, WHEELBASE, MASS = 0.05, 240, 0.32, 3.3
DRAG, GAIN = 0.35, 0.85  # 1/s; of the acceleration


def driven(seed: int, *, gain: float = 1.0, drag: float = 0.0) -> dict[str, Array]:
    """One drive as a driver with a pedal logs it: cm, degrees, a speed that is measured."""
    rng = np.random.default_rng(seed)
    time = STEP * np.arange(ROWS)
    phase, sway = rng.uniform(0, 2 * np.pi, 4), rng.uniform(0.7, 1.6, 4)
    steer = 0.12 * (np.sin(sway[0] * time + phase[0]) + np.sin(sway[1] * time + phase[1]))
    wanted = 1.4 + 0.4 * np.sin(sway[2] * time + phase[2])
    state, rows, told = np.array([0.0, 0.0, rng.uniform(-3, 3), 1.2]), [], []
    for row in range(ROWS):  # the driver answers what the tachometer says
        rows.append(state)
        pedal = 2.0 * (wanted[row] - state[3] + rng.normal(0, 0.05))
        told.append(pedal)

        def moved(_: float, now: Array, pedal: float = pedal, row: int = row) -> list[float]:
            turn = now[3] * np.tan(steer[row]) / WHEELBASE
            return [now[3] * np.cos(now[2]), now[3] * np.sin(now[2]), turn, gain * pedal - drag * now[3]]

        state = solve_ivp(moved, (0.0, STEP), state, rtol=1e-8).y[:, -1]
    x, y, yaw, speed = np.array(rows).T
    noise = {name: rng.normal(0, size, ROWS) for name, size in (("x", 0.1), ("y", 0.1), ("yaw", 0.3), ("v", 0.02))}
    return {
        "time_ms": 1e3 * time,
        "accel_cmd": np.array(told),
        "X_cm": 100 * x + noise["x"],
        "Y_cm": 100 * y + noise["y"],
        "heading_deg": np.degrees(yaw) + noise["yaw"],
        "v_long_mps": speed + noise["v"],
        "steering_deg": np.degrees(steer),
    }


def logs(folder: Path, **hidden: float) -> list[str]:
    folder.mkdir(exist_ok=True)
    paths = [folder / f"drive{seed}.csv" for seed in range(8)]
    for seed, path in enumerate(paths):
        pd.DataFrame(driven(seed, **hidden)).to_csv(path, index=False)
    return [str(path) for path in paths]


def test_beside_a_commanded_acceleration_a_speed_is_measured(tmp_path: Path) -> None:
    found = inspect_logs(logs(tmp_path))
    sources = {name: source.column for name, source in found.spec.columns.items()}
    assert (sources["acceleration"], sources["wheel_speed"]) == ("accel_cmd", "v_long_mps")
    assert "speed" not in sources


def test_of_a_throttle_the_path_says_what_a_unit_is_worth(tmp_path: Path) -> None:
    columns = driven(0)
    pd.DataFrame({**columns, "accel_cmd": columns["accel_cmd"] / 20.0}).to_csv(tmp_path / "a.csv", index=False)
    found = inspect_logs(tmp_path / "a.csv")
    assert "acceleration" not in found.spec.columns
    scale = float(found.toml().split("# acceleration")[1].split("scale = ")[1].split(" ")[0])
    assert scale == pytest.approx(20.0, rel=0.3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("hidden", "named"),
    [({}, {}), ({"gain": GAIN}, {"gain:acceleration": GAIN}), ({"drag": DRAG}, {"linear_drag": DRAG * MASS})],
    ids=["healthy", "gain", "drag"],
)
def test_what_the_car_lacks_is_found_by_the_commands_that_inspect_prints(
    hidden: dict[str, float], named: dict[str, float], tmp_path: Path
) -> None:
    files, spec, out = logs(tmp_path / "logs", **hidden), str(tmp_path / "drive.toml"), tmp_path / "found.json"
    main(["inspect", *files, "--out", spec, "--json", str(out)])
    words = shlex.split(json.loads(out.read_text())["nominal"]["command"])
    put = {"METRES": str(WHEELBASE), "runs/nominal": str(tmp_path / "model")}
    main([*(put.get(word, word) for word in words[1:]), "--mass", str(MASS)])
    main(["diagnose", str(tmp_path / "model"), *files, "--spec", spec, "--json", str(out)])
    answer = json.loads(out.read_text())
    assert answer["verdict"] == ("EFFECT" if named else "NOTHING_MISSING")
    found = {row["effect"]: next(iter(row["parameters"].values())) for row in answer["findings"]}
    assert list(found)[: len(named)] == list(named)
    for effect, value in named.items():
        assert found[effect]["low"] < value < found[effect]["high"]
