"""Values that predict best: where an effect has not the right form, and nowhere else."""

from __future__ import annotations

import io
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import torch
from noisy_flights import LEFT_OUT, flights
from rich.console import Console
from torch import Tensor

from sym2real.cli.results import write_diagnosis
from sym2real.dataset import Dataset, Logs
from sym2real.diagnosis import Diagnosis, add, compare, diagnose
from sym2real.diagnosis.answer import conclude
from sym2real.diagnosis.data.segments import Segments
from sym2real.diagnosis.data.windows import channel_errors, predict_windows
from sym2real.diagnosis.errors.rungs import Rung, RungError, windows_of
from sym2real.diagnosis.pipeline import prepare
from sym2real.diagnosis.question import Question
from sym2real.diagnosis.score.finding import Scored, score
from sym2real.diagnosis.score.prediction_refit import PredictionRefit, Scale, refit_for_prediction
from sym2real.diagnosis.search.beam import search
from sym2real.effects import applicable
from sym2real.effects.along_logs import prepared
from sym2real.experiments.noisy_runs import noisy_runs
from sym2real.report.diagnosis import prediction_lines
from sym2real.report.html.sentences import plain
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.stages import Stages
from sym2real.symbolic import Equations, load_model
from sym2real.tasks import make_task
from sym2real.trajectory import Array, Trajectory

HORIZON, SLOW_MOTOR, DELAY, LAG = 0.8, ("lag:speed", {"value": 0.3}), "delay:speed", "lag:steer"
TASKS = [make_task(name, MUSHR) for name in ("circle", "reverse_circle")]


@cache
def drives(seed: int, count: int) -> Dataset:
    return noisy_runs(MUSHR, TASKS, [SLOW_MOTOR], count=count, rows=300, seed=seed)


def scored_alone(effect: str, logs: Logs, horizon: float | None = None) -> Scored:
    """What an effect alone makes of logs whose effect has another form, were nothing left beside it."""
    others = [known.key for known in applicable(MUSHR.nominal()) if known.key != effect]
    question, stages = Question(MUSHR.nominal(), logs, exclude=others, horizon=horizon), Stages(lambda _: None)
    return score(search(prepare(question, stages), stages))


def in_place_of_others(effect: str, logs: Logs) -> Diagnosis:
    """The same with the values that predict best."""
    scored = scored_alone(effect, logs)
    return replace(conclude(scored, (), None), prediction=refit_for_prediction(scored))


@cache
def found() -> Diagnosis:
    return in_place_of_others(DELAY, drives(3, 6))


def refitted(answer: Diagnosis) -> float:
    """The value of the only parameter of the only finding."""
    assert answer.prediction is not None
    (values,) = answer.prediction.values
    return values["value"]


def missed(model: Equations, logs: Dataset) -> float:
    """Mean over logs of the mean error of position over what that changes by, by another part of the package."""
    errors = [compare(model, log, (HORIZON,)).at(HORIZON).errors["position"] for log in logs]
    return float(np.mean([error.mean / error.hold for error in errors]))


@pytest.mark.slow
def test_a_delay_in_place_of_a_lag_predicts_drives_better_that_nobody_has_seen() -> None:
    base, refit = MUSHR.nominal(), found().prediction
    assert refit is not None
    assert refit.kept
    assert refit.horizon == pytest.approx(HORIZON)
    assert refitted(found()) > 1.3 * found().findings[0].values["value"]
    physical, predicting = (found().apply(base, for_prediction=choice) for choice in (False, True))
    ratio = missed(predicting, drives(4, 3)) / missed(physical, drives(4, 3))
    assert ratio < 0.9
    assert refit.change[0] < 0.9  # as logs predicted that its fits left out
    assert "delay:speed value" in prediction_lines(found())[0]
    assert "its interval is wide: delay:speed value" in plain(prediction_lines(found())[1])
    beside = replace(refit, values=tuple(finding.values for finding in found().findings))
    assert len(prediction_lines(replace(found(), prediction=beside))) == 1


@pytest.mark.slow
def test_no_value_nearby_predicts_the_logs_better() -> None:
    """By the loss as it is written, from windows one by one: position and heading over what they change by.

    A servo of limited speed, taken for a lag: of that the loss has one valley, of a delay one at every row.
    """
    model, steps = MUSHR.nominal(), round(HORIZON / MUSHR.dt)
    logs = noisy_runs(MUSHR, TASKS, [("rate_limit:steer", {"value": 1.0})], count=6, rows=300, seed=3)

    def lengths(log: Trajectory, value: float | None) -> dict[str, Array]:
        """Norm of what is missed, or of what changes, in every row of every window ``# (windows, steps)``."""
        known, (ready,) = prepared(model if value is None else add(model, LAG, {"value": value}), Dataset([log]))
        windows = predict_windows(known, ready, steps)
        start = windows.start[:, None].expand_as(windows.measured)
        return channel_errors(windows.layout, start if value is None else windows.predicted, windows.measured)

    changes = [lengths(log, None) for log in logs]
    units = {name: np.mean([np.square(change[name]).mean() for change in changes]) for name in ("position", "yaw")}

    def norm(of: dict[str, Array]) -> float:
        return float(np.sqrt(np.mean([np.square(of[name]) / units[name] for name in units], axis=(0, 2))).mean())

    def loss(value: float) -> float:
        return float(np.mean([norm(lengths(log, value)) / norm(own) for log, own in zip(logs, changes, strict=True)]))

    answer = in_place_of_others(LAG, logs)
    physical, best = answer.findings[0].values["value"], refitted(answer)
    assert best > 1.1 * physical
    losses = {factor: loss(factor * best) for factor in (physical / best, 0.9, 1.0, 1.1)}
    assert min(losses, key=losses.__getitem__) == 1.0


@pytest.mark.slow
def test_the_order_of_logs_is_nothing_to_it() -> None:
    turned = in_place_of_others(DELAY, Dataset([*drives(3, 6)][::-1]))
    assert turned.predicts_better
    assert refitted(turned) == pytest.approx(refitted(found()), rel=1e-3)


@pytest.mark.slow
def test_values_of_the_right_form_stay() -> None:
    others = [*LEFT_OUT, "rotor*", "rate*", "com_offset", "mounting_tilt", "sensor*", "*_drag"]
    answer = diagnose(CRAZYFLIE.nominal(), flights("added_mass", value=0.004), exclude=others)
    assert answer.verdict == "EFFECT"
    assert not answer.predicts_better
    assert refitted(answer) == pytest.approx(0.004, rel=0.1)
    assert "not kept" in prediction_lines(answer)[0]
    models = [answer.apply(CRAZYFLIE.nominal(), for_prediction=choice) for choice in (False, True)]
    assert models[0].effects == models[1].effects


@pytest.mark.slow
def test_a_single_log_is_judged_by_its_last_third() -> None:
    answer = in_place_of_others(DELAY, noisy_runs(MUSHR, TASKS, [SLOW_MOTOR], count=1, rows=900, seed=5))
    assert answer.predicts_better
    assert refitted(answer) == pytest.approx(refitted(found()), rel=0.15)


@pytest.mark.parametrize(("spread", "kept"), [(0.0, False), (0.01, True), (0.3, False)])
def test_a_fall_counts_where_blocks_agree_and_are_more_than_one(spread: float, kept: bool) -> None:
    """A single block is drawn over and over: its interval has no width."""
    drawn = np.random.default_rng(0).normal(0.0, spread, 200)

    def stage(size: float, scatter: Array) -> Rung:
        resampled = size * np.exp(scatter)
        low, high = np.quantile(resampled, (0.025, 0.975))
        return Rung("", {HORIZON: {"position": RungError(size, size, float(low), float(high), "m", resampled)}})

    assert PredictionRefit(HORIZON, (), stage(1.0, np.zeros(200)), stage(0.9, drawn)).kept is kept


@pytest.mark.parametrize(("count", "rows"), [(3, 150), (1, 400)], ids=["three drives", "one drive"])
def test_few_short_drives_show_which_value_predicts_best(count: int, rows: int) -> None:
    logs = noisy_runs(MUSHR, TASKS, [SLOW_MOTOR], count=count, rows=rows, seed=3)
    answer = in_place_of_others(DELAY, logs)
    assert answer.prediction is not None
    assert answer.predicts_better
    physical = answer.findings[0].values["value"]
    assert refitted(answer) > 1.3 * physical
    losses = [missed(add(MUSHR.nominal(), DELAY, {"value": value}), logs) for value in (physical, refitted(answer))]
    factor, low, high = answer.prediction.change
    assert low < factor < high < 0.9
    assert factor == pytest.approx(losses[1] / losses[0], abs=0.15)


def test_a_value_of_the_right_form_stays_and_one_in_doubt_is_not_asked_for() -> None:
    key, value = SLOW_MOTOR[0], SLOW_MOTOR[1]["value"]
    logs = noisy_runs(MUSHR, TASKS, [SLOW_MOTOR], count=3, rows=150, seed=3)
    scored = scored_alone(key, logs, horizon=0.4)
    refit = refit_for_prediction(scored)
    assert refit is not None
    assert refit.horizon == pytest.approx(0.4)
    assert not refit.kept
    assert refit.values[0]["value"] == pytest.approx(value, rel=0.15)  # windows are hardly longer than it
    in_doubt = tuple(replace(finding, doubtful=True) for finding in scored.findings)
    assert refit_for_prediction(replace(scored, findings=in_doubt)) is None


@pytest.fixture(scope="module")
def windows() -> Segments:
    """Drives of three logs in windows of which place and heading are compared; the last log hardly moves."""
    logs = [noisy_runs(MUSHR, TASKS, [], count=1, rows=90, seed=seed)[0] for seed in range(3)]
    still = replace(logs[2], state=logs[2].state[:1] + 0.001 * (logs[2].state - logs[2].state[:1]))
    found = windows_of(Dataset([*logs[:2], still]), 20, fields=["position", "heading"])
    assert found is not None
    return found


def test_every_log_weighs_one_where_nothing_is_predicted_to_change(windows: Segments) -> None:
    """But one that hardly moves, of which noise would decide."""
    held = Scale.of(windows).mean(unchanged(windows))
    moving = windows.of(torch.as_tensor(windows.log < 2))
    assert Scale.of(moving).mean(unchanged(moving)) == pytest.approx(2.0)
    assert 2.0 < held < 2.2


def unchanged(windows: Segments) -> Tensor:
    """Residuals when nothing changes: the first row less every row ``# (S, R)``."""
    measured, places = windows.measured, windows.layout.indices(["x", "y"])
    turned = torch.atan2(measured[..., windows.layout.index("sin_yaw")], measured[..., windows.layout.index("cos_yaw")])
    angle = turned[:, :1] - turned
    moved = torch.cat(
        [measured[:, :1, places] - measured[..., places], (torch.pi + angle)[..., None] % (2 * torch.pi)], -1
    )
    moved[..., 2] -= torch.pi
    return moved.flatten(1)


def test_least_squares_go_down_where_the_mean_of_norms_does(windows: Segments) -> None:
    """Reweighted least squares: at what is missed both have one value and, but for two, one slope."""
    scale, rng = Scale.of(windows), torch.Generator().manual_seed(0)
    missed = torch.randn(unchanged(windows).shape, generator=rng, dtype=torch.float64)
    weights = scale.whitening(missed)
    assert float(weights.loss(missed[None]).sum()) == pytest.approx(scale.mean(missed))
    way = torch.randn(missed.shape, generator=rng, dtype=torch.float64)
    ahead, back = (scale.mean(missed + step * way) for step in (1e-5, -1e-5))
    slope = weights.products(torch.stack([missed, way], dim=-1))[:, 0, 1].sum()
    assert (ahead - back) / 2e-5 == pytest.approx(float(slope), rel=1e-4)


def test_what_is_missed_by_nothing_does_not_decide_least_squares(windows: Segments) -> None:
    scale, missed = Scale.of(windows), unchanged(windows).clone()
    missed[0] = 0.0
    trust = scale.whitening(missed).trust * scale.window
    others = (missed[1:].square().reshape(len(missed) - 1, -1, 3) @ scale.row).sum(1).sqrt()
    assert float(trust[0]) == pytest.approx(10.0 * len(missed) / float(others.sum()))  # a tenth of the mean norm


@pytest.mark.slow
def test_both_models_are_written(tmp_path: Path) -> None:
    written, _ = write_diagnosis(MUSHR.nominal(), drives(3, 6), found(), tmp_path, Console(file=io.StringIO()))
    folders = [tmp_path / name for name in ("model", "model_prediction")]
    physical, predicting = (missed(load_model(folder), drives(4, 3)) for folder in folders)
    assert predicting < 0.9 * physical
    assert written["prediction"]["kept"]
    assert written["prediction"]["values"] == [{"value": refitted(found())}]
    assert "model_prediction/equations.json" in written["files"]
    assert "other values predict better" in (tmp_path / "report.html").read_text().lower()
