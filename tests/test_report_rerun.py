"""A recording for the Rerun viewer, read back by Rerun's own command."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from shutil import which

import numpy as np
import pytest
from cli_results import result_of
from report_pages import BASE, logs
from scipy.spatial.transform import Rotation

from sym2real.cli import main
from sym2real.diagnosis.data.preparation import prepared
from sym2real.logs import write_log
from sym2real.plants import MujocoPlant
from sym2real.plants.geometry import geometries
from sym2real.report.html.predictions import Starts
from sym2real.robots import MUSHR
from sym2real.symbolic import save_model

needs_rerun = pytest.mark.skipif(which("rerun") is None, reason="rerun-sdk is not installed (extra rerun)")


def chunks(file: Path) -> dict[str, int]:
    """Rows by entity, as Rerun's own command reads them; those of the longest chunk."""
    read = subprocess.run(["rerun", "rrd", "print", str(file)], capture_output=True, text=True, check=True, timeout=120)
    found = re.findall(r"with (\d+) rows .*? - (/.*?) - data", read.stdout)
    return {entity: max(int(rows) for rows, other in found if other == entity) for _, entity in found}


@needs_rerun
def test_compare_records_measured_and_predicted_motion(tmp_path: Path) -> None:
    model = save_model(BASE, tmp_path / "base")
    write_log(logs()[0], tmp_path / "a flight.csv")
    file = tmp_path / "flight.rrd"
    result = result_of(["compare", str(model), str(tmp_path / "a flight.csv"), "--rerun", str(file)], tmp_path)
    assert result["rerun"] == str(file)
    there, rows = chunks(file), len(logs()[0])
    for entity in ("signals/x", "signals/roll", "world"):
        for who in ("measured", "model"):
            assert there[f"/a\\ flight/{entity}/{who}"] == rows
    assert "/a\\ flight/world/model/hull" in there


def test_pieces_along_a_log_start_anew_from_what_was_measured() -> None:
    model, data = prepared(BASE, logs())
    starts = Starts.of(data, 40)
    predicted = starts.predicted(model, data)
    for number, states in enumerate(starts.along(predicted)):
        gaps = np.flatnonzero(np.isnan(states[:, 0]))
        inner = gaps[gaps > starts.row[starts.log == number][0]]
        assert inner.size  # there are several pieces
        assert (np.diff(inner)[::2] == 1).all()  # two rows between pieces
        first = starts.row[starts.log == number][0]
        window = np.flatnonzero((starts.log == number) & (starts.row == first))[0]
        assert np.array_equal(states[first + 1 : first + 30], predicted[window, :29].numpy())


def test_a_robot_is_drawn_as_its_description_says() -> None:
    car = {part.name: part for part in geometries(MujocoPlant(MUSHR))}
    chassis, wheel = car["chassis"], car["front_left"]
    assert chassis.half_sizes == pytest.approx([0.19, 0.09, 0.03])
    assert wheel.shape == "ellipsoid"
    assert sorted(wheel.half_sizes) == pytest.approx([0.02, 0.05, 0.05])
    axle = Rotation.from_quat(wheel.attitude, scalar_first=True).as_matrix()[:, np.argmin(wheel.half_sizes)]
    assert abs(axle[1]) == pytest.approx(1.0)  # it rolls along x
    assert car["front_right"].centre == pytest.approx(wheel.centre * [1, -1, 1])


def test_without_the_library_an_error_names_the_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    model = save_model(BASE, tmp_path / "base")
    write_log(logs()[0], tmp_path / "flight.csv")
    with pytest.raises(SystemExit) as ended:
        main(["compare", str(model), str(tmp_path / "flight.csv"), "--rerun", str(tmp_path / "flight.rrd")])
    assert ended.value.code == 2
    assert "sym2real[rerun]" in capsys.readouterr().err
    assert not (tmp_path / "flight.rrd").exists()
