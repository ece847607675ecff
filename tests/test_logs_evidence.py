"""Long and fast logs: looked at whole, thinned to the rows that say something."""

from pathlib import Path

import numpy as np
from long_flight import flight, save

from sym2real.logs import inspect_logs, read_log
from sym2real.logs.evidence import RATE

MOST = 30_000


def test_what_happens_late_in_a_long_log_is_seen(tmp_path: Path) -> None:
    """Most of the recording on the ground, rates in degrees a second: the unit is still found."""
    columns = flight(3 * MOST, RATE)
    still = {name: np.r_[np.full(2 * MOST, v[0]), v[2 * MOST :]] for name, v in columns.items() if name != "timestamp"}
    turned = {name: np.degrees(v) if name.startswith("gyro") else v for name, v in still.items()}
    found = inspect_logs(save({"timestamp": columns["timestamp"], **turned}, tmp_path / "late.parquet"))
    assert found.spec.columns["wx"].unit == found.spec.columns["wz"].unit == "deg/s"


def test_a_fast_log_is_read_at_the_step_of_a_model(tmp_path: Path) -> None:
    columns = flight(50_000, 1000.0)
    path = save(columns, tmp_path / "fast.parquet")
    found = inspect_logs(path)
    log = read_log(path, found.spec, dt=0.02)
    assert len(log) == 2500
    np.testing.assert_allclose(log.column("x"), columns["pos_x"][::20], atol=1e-9)
