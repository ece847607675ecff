"""Measured logs, through the bench's own figures: one flight of each quick kind."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from sym2real.diagnosis import diagnose
from sym2real.logs import SPECS, read_logs

sys.path.insert(0, str(Path(__file__).parent.parent / "tools" / "bench"))

from real_logs import SCORES, TRUTH, Options, bases
from real_scores import Answer, battery_figures, mean_residual, wind_figures


def answer(folder: Path, name: str, stem: str) -> Answer:
    path = folder / name / f"{stem}.csv"
    ((base, equations, plant),) = bases(name, [path])
    data = read_logs([path], spec=name, layouts=equations.layouts, dt=equations.dt)
    return Answer(stem, base, diagnose(equations, data, plant), data, equations)


@pytest.mark.parametrize("stem", ["baseline_35wind", "baseline_nowind"])
def test_wind_is_a_force_and_its_absence_a_thrust_curve(shared_data: Path, stem: str) -> None:
    one = answer(shared_data, "quadrotor_wind", stem)
    figures = wind_figures([one])
    assert len(figures) == 3
    assert [figure.name for figure in figures if not figure.holds] == []
    assert (abs(mean_residual(one.data[0])[0]) > 1.0) == ("35" in stem)


def test_drag_and_sag_are_named_from_motors_and_voltage(shared_data: Path) -> None:
    figures = battery_figures([answer(shared_data, "crazyflie_battery_drag", "B7_oval_fast_rep2")])
    assert [figure.name for figure in figures if figure.holds is False] == []
    assert 0.2 < figures[-1].value < 0.5


def test_the_bench_knows_every_set(shared_data: Path) -> None:
    """Every folder of logs beside the checkout has its specification, truth and scores, and is diagnosed by default."""
    measured = {folder.name for folder in shared_data.iterdir() if any(folder.glob("*.csv"))}
    assert measured == set(Options().sets) == set(TRUTH) == set(SCORES) == set(SPECS)
