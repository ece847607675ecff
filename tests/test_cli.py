"""The command line as a user types it: results, files, and errors that help."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import torch
from cli_results import Refused, result_of
from quick_engines import Given

from sym2real.cli import main
from sym2real.data import example_flight
from sym2real.layout import Layouts
from sym2real.logs import read_log
from sym2real.regression import ENGINES
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic import Equations, load_model

LEARN = ["learn", "mushr", "--episodes", "2", "--steps", "150", "--samples", "64", "--no-wrench"]


@pytest.fixture(scope="module")
def bicycle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bicycle")
    main(["nominal", "car", "--wheelbase", "0.2955", "--out", str(folder / "model")])
    return folder / "model"


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("learned") / "model"
    main([*LEARN, "--out", str(folder)])
    return folder


def test_a_learned_model_shows_flies_and_exports(learned: Path, tmp_path: Path) -> None:
    shown = result_of(["show", str(learned)], tmp_path)
    assert max(shown["nodes"].values()) <= 85
    assert {row["action"] for row in shown["dependence"]} == {"steer", "speed"}
    flown = result_of(
        ["run", str(learned), "circle", "--samples", "128", "--seconds", "4", "--out", str(tmp_path)], tmp_path
    )
    assert flown["tracking"] < 0.3
    log = read_log(Path(flown["log"]))
    assert len(log) == 80
    assert "ref_x" in log.extra
    result_of(["export", str(learned), "torchscript", "--out", str(tmp_path / "model.pt")], tmp_path)
    module = torch.jit.load(str(tmp_path / "model.pt"))
    after = module(torch.as_tensor(log.state[10]).float(), torch.as_tensor(log.action[10]).float())
    np.testing.assert_allclose(after.numpy()[:2], log.state[11, :2], atol=0.01)


def test_an_interrupted_run_goes_on_and_another_is_refused(learned: Path, refused: Refused) -> None:
    episode = learned / "episodes" / "episode_001.parquet"
    before = episode.stat().st_mtime_ns
    main([*LEARN, "--out", str(learned)])
    assert episode.stat().st_mtime_ns == before
    assert "seed: 0 there, 3 now" in refused([*LEARN, "--out", str(learned), "--seed", "3"])


def test_simulated_drive_against_first_principles(bicycle: Path, tmp_path: Path) -> None:
    log = tmp_path / "drive.csv"
    simulated = result_of(["simulate", "mushr", "circle", "--out", str(log), "--seconds", "8"], tmp_path)
    assert simulated["rows"] == 160
    compared = result_of(["compare", str(bicycle), str(log)], tmp_path)
    errors = {entry["horizon"]: entry["errors"] for entry in compared["horizons"]}
    assert errors[0.8]["position"]["value"] < 0.1 * errors[0.8]["position"]["hold"]
    assert errors[0.8]["yaw"]["unit"] == "rad"


def test_inspect_names_a_rate_whose_sign_is_reversed(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    flipped = ["--effects", "sensor_sign:wy", "value=-1"]
    main(["simulate", "crazyflie", "circle", "--seconds", "8", *flipped, "--out", str(log)])
    assert result_of(["inspect", str(log)], tmp_path)["suspected_flips"] == ["wy"]


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("comparre", "did you mean 'compare'"),
        ("learn crazyfly --out unused", "did you mean 'crazyflie'"),
        ("run no-such-folder hover", "neither a folder nor a robot"),
        ("plan arm.xml log.csv", "arm.xml is a robot's description: `sym2real nominal mjcf arm.xml --out FOLDER`"),
        ("compare {model} missing.csv", "missing.csv"),
        ("compare {model} {flight}", "column"),
        ("run {model} circle", "the model of a robot that has a description, found one of numbers or logs alone"),
        ("run {model} circle", "`sym2real learn crazyflie --out FOLDER` makes a model that `run` flies"),
        ("effects offset:steer --robot crazyflie", "crazyflie has no effect offset:steer"),
        ("effects offset:stear", "unknown effect 'offset:stear'"),
        ("effects steer", "or 'offset:steer'"),
        ("effects zzz", "(known: added_mass, armature, attitude_gain,"),
        ("effects crazyflie", "`sym2real effects --robot crazyflie` lists what that robot may have"),
        ("diagnose {model} missing.csv --exclude wnd", "did you mean 'wind'"),
        ("add {model} wind --fit missing.csv --exclude wnd --out unused", "'wind'"),
        ("plan mushr circle --exclude wnd", "did you mean 'wind'"),
        ("plan mushr circle --exclude gain", "gain:*"),
        ("plan mushr circle 1", "expected `circle OPTION=1`"),
        ("plan mushr circle size=-1", "size > 0"),
        ("plan crazyflie hover height=0.1 swing=0.2", "height above"),
        ("compare {model} {flight} --spec none.toml", "nothing of that name"),
        ("nominal quadrotor --inertia 1 1 5 --out unused", "none above the sum"),
        ("simulate mushr hover --out unused.csv", "attitude"),
        ("simulate crazyflie hover --out unused.csv --seconds 0.001", "--seconds: expected"),
        ("simulate crazyflie hover --out unused.csv --effects added_mass 0.004", "expected `added_mass value=0.004`"),
        ("simulate crazyflie hover --out unused.csv --effects slope gx=1", "effect of a car"),
        ("simulate crazyflie hover --out unused.csv --effects wind fx=nan", "'nan'"),
        ("simulate crazyflie hover --out unused.csv --effects wind", "fx=… in N"),
        ("simulate mushr circle --out {model}/../model/parameters.safetensors", "safetensors is a part of a model"),
        ("add {model} gain:speed value=0.9 --out {model}/equations.json", "found a file"),
        ("add {model} gain:speed --out unused", "value=… without unit, from 0.2 to 3), or --fit LOG"),
        ("diagnose {model} {flight} --out {model}/..", "which would be lost"),
        ("show {model} --json {model}", "found a folder"),
        ("export {model} torchscript --out {model}/module.pt", "expected another place for --out"),
    ],
)
def test_bad_input_gets_one_clear_error(  # noqa: PLR0917 — pytest's fixtures
    command: str, message: str, bicycle: Path, refused: Refused, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert message in refused(command.format(model=bicycle, flight=example_flight()))
    assert not list(tmp_path.iterdir())


def test_a_broken_record_of_the_training_is_one_clear_error(bicycle: Path, refused: Refused, tmp_path: Path) -> None:
    model = tmp_path / "model"
    shutil.copytree(bicycle, model)
    (model / "training.json").write_text("{broken")
    assert "training.json: expected what a model was learned from" in refused(f"show {model}")


def test_equations_that_lost_the_dependence_are_kept_and_said_to_fly_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As noisy logs make them."""
    layouts = Layouts(CRAZYFLIE.layouts.state, CRAZYFLIE.layouts.action)
    still = Equations.parse(layouts, {column: column for column in layouts.state}, CRAZYFLIE.dt)
    monkeypatch.setitem(ENGINES._entries, "beam", Given(still))
    log = tmp_path / "hover.csv"
    main(["simulate", "crazyflie", "circle", "--seconds", "4", "--out", str(log)])
    with pytest.raises(SystemExit) as stopped:
        main(["learn", "crazyflie", "--data", str(log), "--out", str(tmp_path / "model")])
    assert stopped.value.code == 2
    assert "cannot fly" in capsys.readouterr().err
    assert load_model(tmp_path / "model").layouts.action.columns[0] == "thrust"
