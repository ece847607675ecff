"""`add` and `show`: effects go into a model once, visibly, and never over the model that they came from."""

from pathlib import Path

import numpy as np
import pytest
from cli_results import result_of

from sym2real.cli import main
from sym2real.plants import MujocoPlant, load_plant
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.symbolic import save_model


def test_an_effect_in_the_model_explains_a_log_that_has_it(tmp_path: Path) -> None:
    plain, windy = tmp_path / "plain", tmp_path / "windy"
    main(["nominal", "quadrotor", "--mass", "0.027", "--out", str(plain)])
    added = result_of(["add", str(plain), "wind", "fx=0.02", "--out", str(windy)], tmp_path)
    assert added["effects"] == [{"effect": "wind", "values": {"fx": 0.02}}]
    errors = {}
    for blown, options in ((False, []), (True, ["--effects", "wind", "fx=0.02"])):
        log = str(tmp_path / f"{blown}.csv")
        main(["simulate", "crazyflie", "hover", "--seconds", "4", "--out", log, *options])
        for model in (plain, windy):
            compared = result_of(["compare", str(model), log, "--start", "measured"], tmp_path)
            errors[model, blown] = compared["horizons"][3]["errors"]["position"]["value"]
    # Half of F/m times the horizon squared.
    assert errors[plain, True] == pytest.approx(0.5 * 0.02 / 0.027 * 0.8**2, rel=0.1)
    assert errors[plain, False] < 0.02 * errors[plain, True]
    assert errors[windy, True] < 0.05 * errors[plain, True]


def test_a_value_beyond_the_bounds_is_warned_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["nominal", "quadrotor", "--mass", "0.027", "--out", str(tmp_path / "plain")])
    warned = {}
    for value in ("4", "0.004"):
        capsys.readouterr()
        main(["add", str(tmp_path / "plain"), "added_mass", f"value={value}", "--out", str(tmp_path / value)])
        warned[value] = " ".join(line.strip() for line in capsys.readouterr().out.splitlines())
    assert "warning: added_mass value=4 is outside what is likely here: in kg, from -0.018 to 0.108" in warned["4"]
    assert "warning" not in warned["0.004"]


def test_a_delay_in_the_model_delays_its_predictions(tmp_path: Path) -> None:
    model = tmp_path / "plain"
    main(["nominal", "quadrotor", "--mass", "0.027", "--out", str(model)])
    main(["add", str(model), "delay", "value=0.06", "--out", str(tmp_path / "late")])
    log = tmp_path / "log.csv"
    main(["simulate", "crazyflie", "circle", "--seconds", "3", "--controller", "random", "--out", str(log)])
    on_time, late = (
        result_of(["compare", str(folder), str(log), "--start", "measured"], tmp_path)["horizons"][0]["errors"]["rate"]
        for folder in (model, tmp_path / "late")
    )
    assert late["value"] > 5 * on_time["value"]
    page = result_of(["effects", "delay", "--robot", "crazyflie"], tmp_path)
    assert page["parameters"][0]["unit"] == "s"
    listed = result_of(["effects", "--robot", str(model)], tmp_path)["effects"]  # of numbers alone, too
    assert {"delay", "linear_drag"} <= {one["name"] for one in listed}
    assert "tyre_slip" not in {one["name"] for one in listed}


def test_a_model_tells_the_effects_that_were_put_into_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plain, heavy, late = (tmp_path / name for name in ("plain", "heavy", "late"))
    main(["nominal", "quadrotor", "--mass", "0.027", "--out", str(plain)])
    capsys.readouterr()
    main(["add", str(plain), "added_mass", "value=0.004", "--out", str(heavy)])
    said = capsys.readouterr().out
    assert "changed equations: x, y, z, vx, vy, vz" in " ".join(said.split())
    assert len(said.splitlines()) < 10
    main(["add", str(heavy), "delay", "value=0.06", "gain:thrust", "value=0.9", "--out", str(late)])
    capsys.readouterr()
    shown = result_of(["show", str(late)], tmp_path)
    assert shown["effects"] == ["added_mass value=0.004 kg", "gain:thrust value=0.9", "delay value=0.06 s"]
    said = " ".join(capsys.readouterr().out.split())
    assert said.startswith("physical effects put into it: added_mass value=0.004 kg; gain:thrust value=0.9; delay")
    assert said.count("added_mass") == 1
    assert result_of(["show", str(plain)], tmp_path)["effects"] == []


def test_the_simulator_has_all_effects_of_the_model(tmp_path: Path) -> None:
    save_model(MUSHR.nominal(), tmp_path / "plain")
    main(["add", str(tmp_path / "plain"), "offset:steer", "value=0.05", "--out", str(tmp_path / "trimmed")])
    main(["add", str(tmp_path / "trimmed"), "offset:steer", "value=0.01", "--out", str(tmp_path / "more")])
    assert result_of(["show", str(tmp_path / "more")], tmp_path)["effects"] == [
        "offset:steer value=0.05 rad",
        "offset:steer value=0.01 rad",
    ]
    # From rest at x = 0, straight ahead: an offset of 0.06 rad turns the car by that.
    rates = []
    for plant in (load_plant(tmp_path / "more" / "simulator"), MujocoPlant(MUSHR)):
        sent = np.array([0.06 if plant.changes == () else 0.0, 1.0])
        plant.reset()
        rates.append([plant.step(sent) for _ in range(40)][-1][-1])
    assert rates[0] == pytest.approx(rates[1], rel=1e-3)
    assert rates[0] > 0.1


def test_a_term_of_ones_own_has_no_simulator(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    save_model(CRAZYFLIE.nominal(), tmp_path / "plain")
    main(["add", str(tmp_path / "plain"), "term:fz=0.01*vz", "added_mass", "value=0.002", "--out", str(tmp_path / "t")])
    said = " ".join(capsys.readouterr().out.split())
    assert "no simulator was written: a term of one's own has no counterpart there (fz)" in said
    assert not (tmp_path / "t" / "simulator").exists()


def test_a_page_is_found_by_the_name_in_the_catalogue(tmp_path: Path) -> None:
    """Those that need a column stand there with a colon."""
    assert result_of(["effects", "dead_band:"], tmp_path) == result_of(["effects", "dead_band"], tmp_path)
