"""The measured sets and the project's own flight, through the specifications that ship with the project."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from sym2real.data import example_flight
from sym2real.dataset import Dataset
from sym2real.layout import Layout, Layouts
from sym2real.logs import SPECS, LogSpec, inspect_logs, read_log, read_logs

FLIER = ["x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz"]
STATE = dict.fromkeys(SPECS, FLIER) | {"mushr_steering_offset": ["x", "y", "sin_yaw", "cos_yaw", "vx", "vy", "wz"]}
ACTION = {
    "crazyflie_battery_drag": ["motor1", "motor2", "motor3", "motor4"],
    "crazyflie_two_pennies": ["thrust", "wx_cmd", "wy_cmd", "wz_cmd"],
    "mushr_steering_offset": ["steer", "speed"],
    "quadrotor_wind": ["thrust", "qw_cmd", "qx_cmd", "qy_cmd", "qz_cmd"],
}
STEP = {name: 0.05 if name == "mushr_steering_offset" else 0.02 for name in SPECS}


def read_set(folder: Path, name: str) -> Dataset:
    layouts = Layouts(Layout.of(STATE[name]), Layout.of(ACTION[name]))
    return read_logs(folder / name, name, layouts)


def essential(spec: LogSpec) -> LogSpec:
    """A specification without what is only said to people."""
    return dataclasses.replace(spec, name="", title="", columns=dict(spec.columns))


def proposed(spec: LogSpec, name: str) -> tuple[LogSpec, LogSpec]:
    """A proposal beside what ships, without motors whose order is not the model's: a diagnosis says that."""

    def kept(one: LogSpec) -> LogSpec:
        left = {k: v for k, v in one.columns.items() if name != "quadrotor_wind" or not k.startswith("motor")}
        return dataclasses.replace(one, columns=left)

    return kept(spec), kept(SPECS[name])


@pytest.mark.parametrize("name", SPECS)
def test_every_set_opens(shared_data: Path, name: str) -> None:
    logs = read_set(shared_data, name)
    assert len(logs) == len(list((shared_data / name).glob("*.csv")))
    for log in logs:
        assert np.allclose(np.diff(log.time), STEP[name], rtol=0.02)
        assert np.isfinite(log.state).all()
        assert len(log) > 300
        # Positions move as velocities say, in the world.
        for axis in "xy":
            way = log.column(axis)[20:] - log.column(axis)[:-20]
            integral = np.convolve(log.column(f"v{axis}"), np.ones(20), mode="valid")[:-1] * STEP[name]
            assert np.std(way - integral) < 0.1 * np.std(way) + 0.01
        assert {"ref_x", "ref_y"} <= log.extra.keys()


def test_signs_stay_as_recorded(shared_data: Path) -> None:
    log = read_set(shared_data, "crazyflie_two_pennies")[0]
    assert len(log.raw["wy"]) == len(log) + 1
    assert np.array_equal(log.column("wy"), log.raw["wy"][1:])


def test_thrust_per_unit_mass_is_that_of_one_kilogram(shared_data: Path) -> None:
    log = read_set(shared_data, "quadrotor_wind")[0]
    assert np.array_equal(log.column("thrust"), log.raw["thrust_cmd"])


@pytest.mark.parametrize("name", SPECS)
def test_inspection_proposes_the_shipped_specification(shared_data: Path, name: str) -> None:
    found = inspect_logs(shared_data / name)
    assert LogSpec.parse(found.toml()) == found.spec
    accepted, meant = map(essential, proposed(found.spec, name))
    assert accepted == meant
    flips = {"crazyflie_two_pennies": ("wy",)}.get(name, ())
    assert found.suspected_flips == flips
    assert found.spec.flip == ()
    assert ('# flip = ["wy"]' in found.toml()) == bool(flips)


@pytest.mark.parametrize("name", SPECS)
def test_each_log_alone_is_enough(shared_data: Path, name: str) -> None:
    for path in sorted((shared_data / name).glob("*.csv")):
        found = inspect_logs(path)
        accepted, meant = map(essential, proposed(found.spec, name))
        assert accepted == meant, path.name
        assert found.suspected_flips == (("wy",) if name == "crazyflie_two_pennies" else ()), path.name


def test_inspection_says_what_it_cannot_know(shared_data: Path) -> None:
    rows = {row.column: row for row in inspect_logs(shared_data / "quadrotor_wind" / "baseline_nowind.csv").rows}
    assert rows["motor1"].confidence == "unknown"
    assert "cannot be known" in rows["motor1"].evidence


def test_pennies_evidence_names_the_correlation(shared_data: Path) -> None:
    rows = inspect_logs(shared_data / "crazyflie_two_pennies").rows
    evidence = next(row.evidence for row in rows if row.meaning.startswith("sign suspected"))
    assert "correlation -0.99" in evidence


def test_the_committed_flight_opens_and_is_licensed() -> None:
    log = read_log(example_flight(), "crazyflie_battery_drag")
    assert len(log) == 829
    assert log.layouts.action.columns == ("motor1", "motor2", "motor3", "motor4")
    assert log.layouts.inputs.columns == ("vbat",)
    assert np.allclose(np.linalg.norm(log.state[:, log.layouts.state.slice("attitude")], axis=1), 1, atol=1e-12)
    assert "BSD 3-Clause" in (example_flight().parent / "NOTICE").read_text()


def test_the_committed_flight_fits_a_model_that_measures_attitude() -> None:
    layouts = Layouts(
        Layout.of(["x", "y", "z", "vx", "vy", "vz"]),
        Layout.of(["motor1", "motor2", "motor3", "motor4"]),
        Layout.of(["qw", "qx", "qy", "qz", "fx", "fy", "fz", "vbat", "t"]),
    )
    log = read_log(example_flight(), "crazyflie_battery_drag", layouts, dt=0.02)
    assert np.array_equal(log.inputs[:, 4:7], np.zeros((829, 3)))
    assert np.array_equal(log.inputs[:, 8], log.time)
    assert {"wx", "ref_x"} <= log.extra.keys()


def test_inspection_of_the_committed_flight() -> None:
    found = inspect_logs(example_flight())
    assert essential(found.spec) == essential(SPECS["crazyflie_battery_drag"])
    assert found.suspected_flips == ()
