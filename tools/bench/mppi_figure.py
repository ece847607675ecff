"""The times of the comparison as bars on a logarithmic axis."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
from figures import Figure

MARK = "crazyflie, N = 1024: "


def draw(figures: Sequence[Figure], file: Path) -> None:
    """Medians of the quadrotor at 1024 samples, fastest first."""
    mpl.use("Agg")
    from matplotlib import pyplot as plt

    rows = [(f.name.removeprefix(MARK), f.value) for f in figures if f.name.startswith(MARK) and "p99" not in f.name]
    limit = next((f.value for f in figures if f.name.startswith("arithmetic limit")), None)
    rows.sort(key=lambda row: row[1], reverse=True)
    plot, axes = plt.subplots(figsize=(8, 0.32 * len(rows) + 1.2), layout="constrained")
    bars = axes.barh([name for name, _ in rows], [value for _, value in rows], color="tab:blue")
    axes.bar_label(bars, labels=[f"{value:.3g}" for _, value in rows], padding=3)
    if limit is not None:
        axes.axvline(limit, color="black", linestyle=":", label="arithmetic limit")
        axes.legend(loc="lower right")
    axes.set(xscale="log", xlabel="one step of MPPI, ms (1024 samples, 40 periods, one core)")
    axes.margins(x=0.15)
    file.parent.mkdir(parents=True, exist_ok=True)
    plot.savefig(file, dpi=150)
    plt.close(plot)
