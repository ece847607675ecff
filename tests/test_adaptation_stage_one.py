"""Stage I: what an episode is, when the loop stops, and that an interrupted run loses nothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from quick_engines import Given

from sym2real.adaptation import BaseModel, EpisodeReport, Progress, StageOne, episode_error, stage_one, tracking_error
from sym2real.adaptation.episode_report import settled
from sym2real.adaptation.predictions import one_step_error
from sym2real.dataset import Transitions
from sym2real.errors import DataError, ModelError
from sym2real.experiments.learning import training_tasks
from sym2real.plants import MujocoPlant
from sym2real.regression import BeamSearch
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.symbolic import Equations, symbol

# Equations that somebody found already, for what does not depend on the search.
FLIES, DRIVES = Given(CRAZYFLIE.nominal()), Given(MUSHR.nominal())
QUICK = StageOne(episodes=2, steps=80, samples=32, pushed=False, until_settled=False, seed=3)


def report(number: int, *, tracking: float, prediction: float = 1e-4, crashes: int = 0) -> EpisodeReport:
    return EpisodeReport(number, "circle", 400, crashes, tracking, prediction, 1e-4, 1.0)


def test_the_first_episode_is_random_and_uses_up_its_steps() -> None:
    settings = StageOne(episodes=1, steps=200, pushed=False, seed=1)
    base = stage_one(MujocoPlant(CRAZYFLIE), training_tasks(CRAZYFLIE), FLIES, settings)
    assert 190 <= sum(len(trajectory) for trajectory in base.episodes) <= 200
    used_up = base.reports[0].rows == settings.steps
    assert base.reports[0].crashes == len(base.episodes) - used_up >= 3
    assert np.isnan(base.reports[0].tracking)
    for trajectory in base.episodes:
        np.testing.assert_allclose(trajectory.state[0], CRAZYFLIE.start, atol=1e-12)
        # Held for 0.2 s, within the range of random commands.
        assert (np.diff(trajectory.action[:10], axis=0) == 0).all()
        assert (trajectory.action >= CRAZYFLIE.limits.random_low).all()
        assert (trajectory.action <= CRAZYFLIE.limits.random_high).all()
    first = [trajectory.action[0] for trajectory in base.episodes]
    assert len(np.unique(np.round(first, 9), axis=0)) == len(first)


def test_an_interrupted_run_continues_to_the_same_equations(tmp_path: Path) -> None:
    def stop_after_the_first(progress: Progress) -> None:
        if progress.report is not None:
            raise KeyboardInterrupt

    def run(folder: Path | None, **callback: object) -> Equations:
        plant, tasks = MujocoPlant(MUSHR), training_tasks(MUSHR)
        engine = BeamSearch(angles=MUSHR.recipe.angles, degree=2)
        return stage_one(plant, tasks, engine, QUICK, folder=folder, **callback).equations  # type: ignore[arg-type]

    with pytest.raises(KeyboardInterrupt):
        run(tmp_path, on_progress=stop_after_the_first)
    kept = (tmp_path / "episode_000_00.parquet").stat().st_mtime_ns
    continued = run(tmp_path)
    assert (tmp_path / "episode_000_00.parquet").stat().st_mtime_ns == kept
    assert continued.to_json() == run(None).to_json()
    assert continued.robot == "mushr"


def test_a_run_goes_on_whoever_is_told_of_the_search(tmp_path: Path) -> None:
    """Functions have other addresses in every process: with them in the settings, `learn` went on with nothing."""

    def run(tell: Callable[[str], None]) -> str:
        plant, tasks = MujocoPlant(MUSHR), training_tasks(MUSHR)
        engine = BeamSearch(angles=MUSHR.recipe.angles, degree=2, on_column=tell)
        return stage_one(plant, tasks, engine, replace(QUICK, episodes=1), folder=tmp_path).equations.to_json()

    told: list[str] = []
    first = run(lambda _: None)
    assert run(told.append) == first
    assert not told


@pytest.mark.slow
def test_with_more_episodes_a_run_ends_as_if_it_had_them_from_the_beginning(tmp_path: Path) -> None:
    class Counting:
        """Equations that go a little faster with every row that they were fitted to."""

        def __repr__(self) -> str:
            return "Counting()"

        def fit(self, transitions: Transitions, start: Equations | None = None) -> Equations:
            del start
            nominal = MUSHR.nominal()
            return replace(nominal, next={**nominal.next, "vx": nominal.next["vx"] * (1.0 + 1e-4 * len(transitions))})

    def run(episodes: int, folder: Path | None) -> BaseModel:
        settings = replace(QUICK, episodes=episodes, pushed=True)
        return stage_one(MujocoPlant(MUSHR), training_tasks(MUSHR), Counting(), settings, folder=folder)

    for episodes in (2, 3, 2):
        continued, fresh = run(episodes, tmp_path), run(episodes, None)
        assert continued.equations.to_json() == fresh.equations.to_json()
        for ours, theirs in zip(continued.pushed, fresh.pushed, strict=True):
            np.testing.assert_array_equal(ours.state, theirs.state)


def test_a_folder_of_another_run_is_refused(tmp_path: Path) -> None:
    plant, tasks, engine = MujocoPlant(MUSHR), training_tasks(MUSHR), DRIVES
    settings = replace(QUICK, episodes=1)
    stage_one(plant, tasks, engine, settings, folder=tmp_path)
    with pytest.raises(ModelError, match="steps: 80 there, 90 now"):
        stage_one(plant, tasks, engine, replace(settings, steps=90), folder=tmp_path)


def test_a_run_that_cannot_be_is_refused_before_it_begins(tmp_path: Path) -> None:
    for settings in ({"episodes": 0}, {"steps": 5}):
        with pytest.raises(ModelError, match="at least one episode of 10 steps"):
            StageOne(**settings)
    plant, engine = MujocoPlant(MUSHR), BeamSearch(angles=MUSHR.recipe.angles)
    with pytest.raises(ModelError, match="at least one task"):
        stage_one(plant, [], engine, QUICK)
    (tmp_path / "settings.json").write_text("{")
    with pytest.raises(DataError, match="the settings of a run"):
        stage_one(plant, training_tasks(MUSHR), engine, QUICK, folder=tmp_path)


def test_only_what_ends_on_the_ground_is_a_crash() -> None:
    """A car under random commands stays on its wheels; its one try ends because the steps are used up."""
    base = stage_one(MujocoPlant(MUSHR), training_tasks(MUSHR), DRIVES, replace(QUICK, episodes=1))
    assert [(report.rows, report.crashes) for report in base.reports] == [(QUICK.steps, 0)]


def test_equations_without_thrust_are_refused_loudly() -> None:
    class Blind:
        def fit(self, transitions: Transitions, start: Equations | None = None) -> Equations:
            names = {column: column for column in transitions.layouts.state}
            return Equations.parse(transitions.layouts, names, transitions.dt)

    settings = StageOne(episodes=1, steps=60, pushed=False)
    with pytest.raises(ModelError, match="thrust → vz"):
        stage_one(MujocoPlant(CRAZYFLIE), training_tasks(CRAZYFLIE), Blind(), settings)


@pytest.mark.slow
def test_pushed_episodes_teach_the_wrench() -> None:
    settings = StageOne(episodes=1, steps=400, seed=2)
    base = stage_one(MujocoPlant(CRAZYFLIE), training_tasks(CRAZYFLIE), BeamSearch(), settings)
    assert all(np.abs(trajectory.inputs).max() > 0 for trajectory in base.pushed)
    assert all(not trajectory.inputs.any() for trajectory in base.episodes)
    at_rest = {symbol(name): value for name, value in zip(CRAZYFLIE.layouts.state, CRAZYFLIE.start, strict=True)}
    at_rest |= {symbol(name): value for name, value in zip(CRAZYFLIE.layouts.action, CRAZYFLIE.rest, strict=True)}
    for column, force in (("vx", "fx"), ("vy", "fy"), ("vz", "fz")):
        slope = base.equations.next[column].diff(symbol(force)).subs(at_rest)
        slope = slope.subs({symbol(name): 0 for name in CRAZYFLIE.layouts.inputs})
        assert float(slope) == pytest.approx(CRAZYFLIE.dt / CRAZYFLIE.mass, rel=0.02)


def test_the_loop_stops_when_nothing_gets_better() -> None:
    fine = [report(number, tracking=0.02) for number in range(4)]
    assert settled(fine)
    assert not settled(fine[:2])
    assert not settled([*fine[:3], report(3, tracking=0.05)])
    assert not settled([*fine[:3], report(3, tracking=0.02, prediction=3e-4)])
    assert not settled([*fine[:3], report(3, tracking=0.02, crashes=1)])


def test_errors_of_an_episode() -> None:
    settings = StageOne(episodes=1, steps=60, pushed=False)
    base = stage_one(MujocoPlant(MUSHR), training_tasks(MUSHR), DRIVES, settings)
    episode = base.episodes[0]
    moved = replace(episode, extra={**episode.extra, "ref_x": episode.column("x") + 3.0, "ref_y": episode.column("y")})
    assert tracking_error(moved) == episode_error(moved, MUSHR, len(moved)) == pytest.approx(3.0)
    # A crash after a quarter of the way: the other three quarters count as off the workspace.
    assert episode_error(moved, MUSHR, 4 * len(moved)) == pytest.approx(0.25 * 3.0 + 0.75 * MUSHR.limits.workspace)
    still = Equations.parse(episode.layouts, {column: column for column in episode.layouts.state}, episode.dt)
    # Predicting no motion is wrong by all the motion there is.
    assert one_step_error(still, [episode]) == pytest.approx(1.0)
