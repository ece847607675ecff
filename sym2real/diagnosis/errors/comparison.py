"""How far a model's predictions are from a log: one step, k steps and free run, per channel, beside a floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isnan
from typing import TYPE_CHECKING, Any

from sym2real.dataset import Dataset, Logs
from sym2real.diagnosis.data.preparation import long_enough
from sym2real.diagnosis.data.start import ROWS, Start
from sym2real.diagnosis.data.windows import JUDGED_AT, free_run_seconds, horizons_in_rows, rows_ahead
from sym2real.diagnosis.errors.by_window import window_errors
from sym2real.diagnosis.errors.floor import Floor, floor_of_noise
from sym2real.diagnosis.errors.regions import Segment, Where, where_of, worst_segments
from sym2real.diagnosis.errors.residuals import Residuals, one_step_residuals
from sym2real.diagnosis.errors.skill import HorizonErrors, prediction_errors
from sym2real.diagnosis.faults.mistakes.lost_commands import with_lost_commands
from sym2real.diagnosis.faults.report import DataReport, data_report
from sym2real.effects.along_logs import prepared
from sym2real.json_objects import fields_of
from sym2real.logs.conditions import Region
from sym2real.protocols import DynamicsModel
from sym2real.robots.left_out import left_out_notes
from sym2real.symbolic import Equations, equations_of
from sym2real.threads import one_thread
from sym2real.upward import upward

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Comparison:
    """What :func:`compare` found.

    Args:
        one_step: errors one row ahead.
        horizons: errors at the horizons asked for that the logs are long enough for.
        free_run: errors after 2 s (car 5 s), or what the longest log allows.
        start: how start states were found.
        notes: what was done to the logs on the way in, and what was left out.
        where: regions in which the errors are larger.
        worst: stretches of logs whose errors stand out most from the noise of their channel.
        data: what the logs are fit for.
        floor: the part of the errors that the sensors' noise alone makes, at start and end.
        residuals: what one-step residuals remember of themselves and of the commands.
    """

    one_step: HorizonErrors
    horizons: tuple[HorizonErrors, ...]
    free_run: HorizonErrors
    start: Start
    notes: tuple[str, ...] = ()
    where: tuple[Where, ...] = ()
    worst: tuple[Segment, ...] = ()
    data: DataReport | None = None
    floor: tuple[Floor, ...] = ()
    residuals: Residuals | None = None

    def at(self, horizon: float) -> HorizonErrors:
        """Errors at the horizon nearest to ``horizon`` s; one step ahead where logs are too short for all."""
        return min(self.horizons or (self.one_step,), key=lambda errors: abs(errors.horizon - horizon))

    def __repr__(self) -> str:
        shown = self.at(JUDGED_AT)
        errors = ", ".join(f"{name} {error.value:.3g} {error.unit}" for name, error in shown.errors.items())
        return f"<Comparison: {shown.horizon:.3g} s ahead {errors}>"

    def plot(self) -> Figure:
        """Error of every channel over the horizon, beside "hold" and the sensors' noise: a figure of matplotlib."""
        return upward("comparison_plot")(self)

    def _repr_html_(self) -> str:
        return str(upward("comparison_html")(self))

    def to_dict(self) -> dict[str, Any]:
        """The object that ``--json`` prints (docs/method.md, "Answers as files")."""
        return fields_of(self)


@one_thread()
def compare(
    model: Equations | DynamicsModel,
    data: Logs,
    horizons: Sequence[float] | None = None,
    start: Start = "smoothed",
    region: Region | None = None,
) -> Comparison:
    """Compare a model's predictions with measured trajectories.

    Windows start every 0.1 s; errors are taken at their end; what was sent and what was known along the log drive
    the prediction.

    Args:
        model: equations, or a model that predicts in float64.
        data: logs with the model's columns and time step, or slower (``read_log(…, layouts=…, dt=…)``).
        horizons: in s, by default the usual ones; those longer than every log are left out, and ``notes`` says so.
        start: "smoothed" from the ten rows up to the start, or the "measured" row.
        region: range of every column in the model's training, to say whether it fails inside or outside.

    Raises:
        ShapeError: when columns or time steps differ, no log is long enough for a window, or a horizon is no step long.

    Examples:
        >>> robot = ROBOTS["mushr"]
        >>> model, task = robot.nominal(), make_task("circle", robot)
        >>> log = run_episode(MujocoPlant(robot), MPPI(compile_model(model), robot, task), task, steps=60)
        >>> compare(model, log).at(0.5).errors["position"].value < 0.05
        True
    """
    logs = long_enough(data, model)
    predictor, dataset = prepared(model, with_lost_commands(model, logs) if isinstance(model, Equations) else logs)
    horizons = horizons_in_rows(dataset.dt) if horizons is None else horizons
    rows = {horizon: rows_ahead(horizon, dataset.dt) for horizon in horizons}
    longest = max(len(trajectory) for trajectory in dataset) - ROWS
    free = min(round(free_run_seconds(dataset.layouts.state) / dataset.dt), longest)
    steps = sorted({1, free, *(count for count in rows.values() if count <= longest)})
    floor = floor_of_noise(predictor, dataset, steps, start)
    table = dict(zip(steps, prediction_errors(predictor, dataset, steps, start, floor), strict=True))
    about, missing = data_report(data, equations_of(model)), [s for s, count in rows.items() if count > longest]
    errors = window_errors(predictor, dataset)
    return Comparison(
        one_step=table[1],
        horizons=tuple(replace(table[count], horizon=horizon) for horizon, count in rows.items() if count <= longest),
        free_run=table[free],
        start=start,
        notes=(*_notes(dataset, missing, list(table.values())), *left_out_notes(equations_of(model), dataset)),
        where=where_of(errors, region),
        worst=worst_segments(errors),
        data=about,
        floor=floor,
        residuals=one_step_residuals(model, logs, [name for name, varied in about.commands.items() if varied.weak]),
    )


def score(whole: Equations | DynamicsModel, data: Logs, horizon: float) -> dict[str, float]:
    """See :meth:`~sym2real.Equations.score`."""
    model, logs = prepared(whole, long_enough(data, whole))
    (errors,) = prediction_errors(model, logs, [rows_ahead(horizon, logs.dt)], "smoothed", ())
    return {channel: error.fit for channel, error in errors.errors.items()}


def _notes(data: Dataset, left_out: Sequence[float], errors: Sequence[HorizonErrors]) -> tuple[str, ...]:
    pairs = [(note, log.name) for log in data for note in log.notes]
    logs_of = {note: [name for own, name in pairs if own == note] for note, _ in pairs}
    notes = [f"{'all logs' if len(own) == len(data) > 1 else ', '.join(own)}: {note}" for note, own in logs_of.items()]
    lost = {name: at.horizon for at in errors[::-1] for name, error in at.errors.items() if isnan(error.value)}
    if lost:
        channels = ", ".join(f"{name} {horizon:.3g} s ahead" for name, horizon in lost.items())
        notes.append(f"the model predicts no number of {channels}: check the units of its commands and its parameters")
    if left_out:
        notes.append(f"no log is long enough for horizons {left_out} s")
    without_fit = [at for at in errors if any(isnan(error.spread) for error in at.errors.values())]
    if few := [f"{at.windows} {at.horizon:.3g} s ahead" for at in without_fit]:
        notes.append(f"too few windows for fit or skill: {', '.join(few)}")
    return tuple(notes)
