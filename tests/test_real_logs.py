"""Measured logs, through the bench's own figures: one flight of each quick kind, and three drives."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from real_logs import SCORES, Options, bases
from real_scores import Answer, battery_figures, mean_residual, wind_figures

from sym2real.diagnosis import diagnose
from sym2real.logs import SPECS, read_logs


def answers(name: str, paths: list[Path]) -> Iterator[Answer]:
    for base, equations, plant in bases(name, paths):
        data = read_logs(paths, spec=name, layouts=equations.layouts, dt=equations.dt)
        yield Answer(paths[0].stem, base, diagnose(equations, data, plant), data, equations)


def answer(folder: Path, name: str, stem: str) -> Answer:
    (found,) = answers(name, [folder / name / f"{stem}.csv"])
    return found


@pytest.mark.slow
@pytest.mark.parametrize("stem", ["baseline_35wind", "baseline_nowind"])
def test_wind_is_a_force_and_its_absence_a_thrust_curve(shared_data: Path, stem: str) -> None:
    one = answer(shared_data, "quadrotor_wind", stem)
    figures = wind_figures([one])
    assert len(figures) == 3
    assert [figure.name for figure in figures if not figure.holds] == []
    assert (abs(mean_residual(one.data[0])[0]) > 1.0) == ("35" in stem)


@pytest.mark.slow
def test_drag_and_sag_are_named_from_motors_and_voltage(shared_data: Path) -> None:
    figures = battery_figures([answer(shared_data, "crazyflie_battery_drag", "B7_oval_fast_rep2")])
    assert [figure.name for figure in figures if figure.holds is False] == []
    assert 0.2 < figures[-1].value < 0.5


def fastest(findings: dict[str, dict[str, float]]) -> float:
    """The speed in m/s at which a car stops to follow its command; three drives may give a part of it to a gain."""
    return findings["limit:speed"]["upper"] * findings.get("gain:speed", {}).get("value", 1.0)


@pytest.mark.slow
def test_a_speed_limit_and_a_steering_offset_are_named_from_the_learned_base(shared_data: Path) -> None:
    name = "mushr_steering_offset"
    one = next(answers(name, sorted((shared_data / name).glob("*.csv"))[:3]))
    assert one.base == "learned"
    findings = {finding.effect: finding.values for finding in one.found.findings}
    assert 0.8 < fastest(findings) < 0.95
    assert 0.05 < findings["offset:steer"]["value"] < 0.15
    first, *_, last = one.found.ladder
    before, after = (stage.horizons[stage.nearest(0.8)]["position"].value for stage in (first, last))
    assert after < 0.2 * before


def test_the_bench_knows_every_set(shared_data: Path) -> None:
    """Every folder of logs beside the checkout has its specification and scores, and is diagnosed by default."""
    measured = {folder.name for folder in shared_data.iterdir() if any(folder.glob("*.csv"))}
    assert measured == set(Options().sets) == set(SCORES) == set(SPECS)
