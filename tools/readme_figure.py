"""Draws docs/images/flight.svg: a real flight, predicted by first principles and with the effect that was found.

    python -m tools.readme_figure

The whole flight names the effect. Its numbers are then fitted to the first three quarters, and the rest is drawn and
scored, which took no part in the fit.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sym2real import Dataset, Equations, Trajectory, diagnose, example_flight, read_log, try_effect
from sym2real.diagnosis import HypothesisTest
from sym2real.diagnosis.data.windows import JUDGED_AT
from sym2real.experiments.thrust_of_log import thrust_of_log
from sym2real.logs import load_spec
from sym2real.report.style import INFORMED, LOOKS, MEASURED, PREDICTED, REFERENCE, legend_below
from sym2real.robots import Motors, quadrotor

SPEC = "crazyflie_battery_drag"
FITTED = 0.75  # of the flight
OUT = Path(__file__).resolve().parent.parent / "docs" / "images" / "flight.svg"


def main() -> None:
    """Diagnose, draw, and print what the README says in words."""
    motors = Motors(thrust=thrust_of_log(example_flight(), load_spec(SPEC)).per_mass)
    model = quadrotor(None, interface="motors", attitude="measured", motors=motors)
    log = read_log(example_flight(), SPEC, model.layouts, model.dt)
    cut = round(FITTED * len(log))
    kept = log.rows(cut, len(log))
    found = diagnose(model, log)
    print(found.verdict, found.summary)
    names = [one.effect for one in found.findings]
    fitted = try_effect(model, names, log.rows(0, cut), held_out=Dataset([kept]))
    mpl.rcParams.update({"font.size": 9, "svg.hashsalt": "sym2real", "svg.fonttype": "path"})
    figure = Figure(figsize=(9.0, 3.4), layout="constrained")
    path, horizons = figure.subplots(1, 2, width_ratios=(1.5, 1.0))
    draw_path(path, kept, {"first principles": model, f"+ {' + '.join(names)}": fitted.apply(model)})
    draw_errors(horizons, fitted)
    legend_below(figure)
    OUT.parent.mkdir(exist_ok=True)
    figure.savefig(OUT, metadata={"Date": None})
    print(f"{OUT.name}: {OUT.stat().st_size / 1000:.0f} kB")


def draw_path(axis: Axes, log: Trajectory, models: dict[str, Equations]) -> None:
    """The path from above: measured, and predicted from starts along it."""
    axis.plot(log.column("x"), log.column("y"), color=MEASURED, linewidth=3, alpha=0.35, label="measured")
    restart = np.arange(len(log)) % round(JUDGED_AT / log.dt) == 0
    for (label, model), style in zip(models.items(), (LOOKS["base"], LOOKS["model"]), strict=True):
        predicted = model.simulate(log, JUDGED_AT)
        x, y = (np.insert(predicted.column(name), np.flatnonzero(restart) + 1, np.nan) for name in "xy")
        axis.plot(x, y, **style, linewidth=1.4, label=label)
    axis.set(xlabel="x in m", ylabel="y in m", aspect="equal")
    axis.set_title(f"a real Crazyflie, predicted {JUDGED_AT:g} s ahead", fontsize=9)


def draw_errors(axis: Axes, found: HypothesisTest) -> None:
    """Position error over the horizon on what was held out, with 95 % bands, and the noise floor."""
    for stage, colour in zip((found.ladder[0], found.ladder[-1]), (PREDICTED, INFORMED), strict=True):
        horizons = sorted(stage.horizons)
        errors = [stage.horizons[one]["position"] for one in horizons]
        axis.plot(horizons, [one.value for one in errors], "o-", color=colour, markersize=3)
        axis.fill_between(
            horizons, [one.low for one in errors], [one.high for one in errors], color=colour, alpha=0.15, linewidth=0
        )
    floor = [(one.horizon, one.errors["position"][0]) for one in found.floor]
    axis.plot(*zip(*floor, strict=True), ":", color=REFERENCE, label="noise and disturbances")
    axis.set(xlabel="horizon in s", ylabel="position error in m, root mean square", ylim=(0.0, None))
    axis.set_title("on the last quarter, held out", fontsize=9)


if __name__ == "__main__":
    main()
