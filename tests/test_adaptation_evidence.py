"""What an adaptation takes as evidence: which models may fly, which logs it learns from, and what a crash says."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from adaptation_runs import windy
from numpy.typing import NDArray
from tracked import episode

from sym2real.adaptation import Adapting, Improvement, adapt
from sym2real.adaptation.fine_tuning import FineTuning
from sym2real.adaptation.model_limits import beyond_limits
from sym2real.adaptation.predictions import horizon_errors, one_step_error
from sym2real.adaptation.progress import silent
from sym2real.adaptation.round_report import Learned, RoundReport
from sym2real.adaptation.target import Flights
from sym2real.adaptation.training import Training, digest_of
from sym2real.control import geometric_controller
from sym2real.dataset import Dataset, Transitions
from sym2real.effects import compose, effect
from sym2real.effects.voltage import with_voltage
from sym2real.errors import ModelError, ShapeError
from sym2real.experiments.informing import informing
from sym2real.experiments.learners import NoResidual
from sym2real.layout import Layout, Layouts
from sym2real.neural import (
    Composed,
    Descent,
    Ensemble,
    EnsembleTraining,
    ResidualMLP,
    ResidualTraining,
    SymbolicResidual,
)
from sym2real.neural.composed import Base
from sym2real.neural.model_folder import Model, open_model, save_model
from sym2real.plants import MujocoPlant
from sym2real.protocols import Controller
from sym2real.robots import CRAZYFLIE, Robot
from sym2real.symbolic import Equations, parse_expression
from sym2real.tasks import Task, make_task
from sym2real.trajectory import Array, Trajectory

BASE = CRAZYFLIE.nominal()
ONE = Adapting(rounds=1)


@pytest.fixture(scope="module")
def flights() -> list[Trajectory]:
    return [episode(MujocoPlant(CRAZYFLIE), steps=80, seed=seed, name=f"flight {seed}") for seed in range(2)]


def four_times_the_thrust(logs: Dataset, equations: Equations) -> Equations:
    return compose(equations, [(effect("gain:thrust", equations), {"value": 4.0})])


def test_informed_equations_that_leave_the_robots_limits_do_not_fly(flights: list[Trajectory]) -> None:
    """Held against themselves they are never beyond what is sound."""
    found = adapt(BASE, flights, None, NoResidual(), ONE, robot=CRAZYFLIE, inform=four_times_the_thrust)
    assert "of its predictions have a" in found.reports[1].learned.refused
    assert found.models[1] is BASE


def test_logs_shorter_than_the_horizon_tell_of_limits_too(flights: list[Trajectory]) -> None:
    """As when every episode has crashed at once."""
    short = [log.rows(0, 9) for log in flights]
    assert len(short[0]) < CRAZYFLIE.mppi.horizon / CRAZYFLIE.dt
    wild = compose(BASE, [(effect("gain:thrust", BASE), {"value": 400.0})])
    assert "of its predictions have a" in beyond_limits(wild, BASE, short, CRAZYFLIE, 0)
    assert not beyond_limits(BASE, BASE, short, CRAZYFLIE, 0)
    assert "no log has two rows" in beyond_limits(BASE, BASE, [flights[0].rows(0, 1)], CRAZYFLIE, 0)


def test_a_residual_is_learned_beside_an_effect_of_the_logged_voltage(flights: list[Trajectory]) -> None:
    """Logs hold the battery's voltage as a further column; equations with its effect have it as an input."""

    def inform(logs: Dataset, equations: Equations) -> Equations:
        return with_voltage(equations, 4.2)

    logs = [replace(log, extra={**log.extra, "vbat": np.linspace(4.2, 4.0, len(log))}) for log in flights]
    learner = FineTuning(steps=2, passes=1, penalties=(1.0,))
    found = adapt(BASE, logs, None, learner, ONE, robot=CRAZYFLIE, inform=inform)
    assert found.models[1].layouts.inputs.columns[-1] == "vbat"
    assert math.isfinite(found.reports[1].one_step)


def test_a_second_without_noise_ends_no_adaptation() -> None:
    """Rounding leaves the curvature of so few exact rows indefinite by far more than a prior takes up."""
    log = episode(windy(), steps=200, seed=1, name="windy").rows(0, 60)
    assert informing(None)(Dataset([log]), BASE).layouts.state == BASE.layouts.state


def test_logs_of_another_time_step_are_refused_by_learners_and_networks(flights: list[Trajectory]) -> None:
    """Every other row: what moves in two steps is no step of the model."""
    half = Dataset([every(log, np.arange(0, len(log), 2)) for log in flights])
    slow = half.transitions()
    layouts = Layouts(BASE.layouts.state, BASE.layouts.action)
    network = Ensemble(layouts, 2, (4,), dt=BASE.dt)
    narrow = EnsembleTraining(members=2, widths=(4,), descent=Descent(steps=2))
    for refused in (
        lambda: FineTuning().fit(slow, BASE),
        lambda: ResidualTraining(widths=(4,)).fit(slow, BASE),
        lambda: narrow.fit(slow, network),
        lambda: one_step_error(network, half),
        lambda: one_step_error(
            Composed(network, SymbolicResidual(layouts, {})), [every(flights[0], np.arange(0, 80, 2))]
        ),
    ):
        with pytest.raises(ShapeError, match=r"the model's time step is 0.02 s, the logs' is 0.04 s"):
            refused()
    assert math.isfinite(one_step_error(network, flights))
    assert math.isfinite(one_step_error(Ensemble(layouts, 2, (4,)), flights))  # nobody says its time step


def every(log: Trajectory, rows: NDArray[np.int64]) -> Trajectory:
    """Some rows of a log, as if no others had been measured."""
    return Trajectory(*(values[rows] for values in (log.time, log.state, log.action, log.inputs)), log.layouts)


def test_errors_of_logs_with_another_order_of_columns_are_the_same(flights: list[Trajectory]) -> None:
    layouts = BASE.layouts
    turned = Layout((*layouts.state.fields[::-1],))
    log = flights[0]
    other = replace(log, state=log.state[:, layouts.state.indices(turned)], layouts=replace(log.layouts, state=turned))
    assert one_step_error(BASE, [other]) == pytest.approx(one_step_error(BASE, [log]))
    np.testing.assert_allclose(horizon_errors(BASE, [other], 10), horizon_errors(BASE, [log], 10))


class Recorder:
    """Returns the base, and keeps what training was to go on from."""

    def fit(self, transitions: Transitions, base: Base, start: Model | None = None) -> Base:
        self.start = start
        return base


def test_what_was_learned_elsewhere_is_not_gone_on_from_when_its_folder_is_opened_again(
    flights: list[Trajectory],
) -> None:
    layouts = Layouts(BASE.layouts.state, BASE.layouts.action)
    given, opened = (Composed(BASE, ResidualMLP(layouts, (4,))) for _ in range(2))
    opened.residual.load_state_dict(given.residual.state_dict())
    learner, none = Recorder(), Improvement()
    reports = [
        RoundReport(
            number=number, log="log", rows=80, flown=False, crashed=False, horizon=0.8, best_before=0, gain=none,
            tracking=none, learned=Learned(base=digest_of(BASE)),
        )
        for number in range(2)
    ]  # fmt: skip
    training = Training(learner, None, None, 0, silent)
    training.learn(given, [given, opened], reports, [Dataset(flights)])
    assert learner.start is None


def test_a_digest_tells_whatever_the_folder_of_a_model_does(tmp_path: Path) -> None:
    layouts = Layouts(BASE.layouts.state, BASE.layouts.action)
    network = Ensemble(layouts, 2, (4,), dt=0.02)
    slower = Ensemble(layouts, 2, (4,), dt=0.04)
    texts: list[dict[str, str]] = [{}, {"vx": "0.1*thrust"}, {"vx": "0.2*thrust"}]
    residuals = [SymbolicResidual(layouts, {c: parse_expression(text) for c, text in each.items()}) for each in texts]
    models = [BASE, network, slower, *(Composed(network, residual) for residual in residuals)]
    assert len({digest_of(model) for model in models}) == len(models)
    for number, model in enumerate(models):
        assert digest_of(open_model(save_model(model, tmp_path / str(number)))) == digest_of(model)


def test_a_value_that_is_no_number_is_refused_and_named(flights: list[Trajectory]) -> None:
    torn = replace(flights[0], state=flights[0].state.copy())
    torn.state[50, 2] = np.nan
    with pytest.raises(ShapeError, match="found nan in column z, row 51 of flight 0"):
        adapt(BASE, [flights[1], torn], None, NoResidual(), ONE, robot=CRAZYFLIE)


def test_single_rows_between_gaps_are_left_out(flights: list[Trajectory]) -> None:
    rows = np.r_[0:30, 50:51, 70:80]
    found = adapt(BASE, [every(log, rows) for log in flights], None, NoResidual(), ONE, robot=CRAZYFLIE)
    assert [[len(piece) for piece in log] for log in found.logs] == [[30, 10]] * 2
    assert all(math.isfinite(report.one_step) for report in found.reports)


def test_a_recording_of_one_row_teaches_nothing(flights: list[Trajectory]) -> None:
    single = flights[0].rows(0, 1)
    found = adapt(BASE, [single, flights[1]], None, NoResidual(), ONE, robot=CRAZYFLIE)
    assert math.isnan(found.reports[0].one_step)
    assert found.reports[1].learned.refused == "no log has two rows to learn from"
    with pytest.raises(ModelError, match="at least two rows"):
        adapt(BASE, [single, single], None, NoResidual(), ONE, robot=CRAZYFLIE)


class Fallen(MujocoPlant):
    """Has crashed with its first step."""

    @property
    def crashed(self) -> bool:
        return True


def flown(model: Model, robot: Robot, task: Task, *, samples: int | None, seed: int) -> Controller:
    return geometric_controller(robot, task.reference)


def test_a_crash_in_the_first_step_ends_nothing() -> None:
    plant, task = Fallen(CRAZYFLIE), make_task("hover", CRAZYFLIE)
    found = adapt(BASE, plant, task, NoResidual(), Adapting(rounds=1, steps=80), controller=flown)
    assert [report.rows for report in found.reports] == [1, 1]
    assert all(report.crashed for report in found.reports)


@pytest.mark.parametrize("lost", [(40,), (80,), (78, 79, 80)])
def test_an_episode_whose_last_poses_are_missing_has_not_crashed(lost: tuple[int, ...]) -> None:
    """The last known state goes on, as others go on between known ones."""

    class Lost(MujocoPlant):
        def reset(self, *given: Any, **named: Any) -> Array:
            self.steps = 0
            return super().reset(*given, **named)

        def step(self, action: Array) -> Array:
            self.steps, state = self.steps + 1, super().step(action)
            return np.full_like(state, np.nan) if self.steps + 1 in lost else state

    plant, task = Lost(CRAZYFLIE), make_task("circle", CRAZYFLIE)
    flights = Flights(plant, CRAZYFLIE, task, 80, None, 0, silent, lambda *_, **__: Resting())
    log = flights.log(0, BASE)
    assert log.rows == 80
    assert np.isfinite(log[0].state).all()
    assert not flights.judged(log)[0]


class Resting:
    """Sends what keeps the robot where it is, whatever is seen."""

    def reset(self) -> None: ...

    def remember(self, action: Array) -> None: ...

    def act(self, state: Array, step: int, inputs: Array | None = None) -> Array:
        return np.asarray(CRAZYFLIE.rest)
