"""The recording for a viewer that verbs write with ``--rerun``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console

if TYPE_CHECKING:
    from sym2real.neural.model_folder import Model
    from sym2real.report.html.variants import Predicting
    from sym2real.trajectory import Dataset


def write_recording(file: Path, data: Dataset, models: Mapping[str, Predicting], of: Model, console: Console) -> Path:
    """Write what was measured and what models predict, with the robot of a model where it is known; say where it is."""
    from sym2real.plants import MujocoPlant
    from sym2real.plants.geometry import geometries
    from sym2real.report.rerun_file import write_rerun
    from sym2real.robots import ROBOTS

    name = getattr(of, "robot", "")
    write_rerun(file, data, models, geometries(MujocoPlant(ROBOTS[name])) if name in ROBOTS else ())
    console.print(f"recording in {file}: rerun {file}", markup=False)
    return file
