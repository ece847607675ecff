"""Verbs read models with networks whole; those that work on equations take what lies below a residual, and say so."""

from pathlib import Path

import numpy as np
import pytest
import torch
from cli_results import Refused, result_of

from sym2real.cli import main
from sym2real.control import RandomCommands
from sym2real.experiments.models import open_model
from sym2real.logs import write_log
from sym2real.neural import Composed, Ensemble, ResidualMLP, save_model
from sym2real.plants import ModelPlant, run_episode
from sym2real.robots import MUSHR
from sym2real.symbolic import load_model, rollout

# Left out to keep the test short: the note stands there whatever is found.
EXCLUDED = (
    *("gain*", "offset*", "limit*", "delay*", "lag*", "wind"),
    *("slope", "understeer", "tyre_*", "sensor_*", "time_*"),
)


def slower(rate: float) -> ResidualMLP:
    """What brakes along x: r = -rate in every state, of vx alone."""
    residual = ResidualMLP(MUSHR.layouts, (4,), commands=1)
    with torch.no_grad():
        residual.linears[-1].bias[4] = -rate
        residual.output_scale.copy_(torch.eye(7)[4])
    return residual


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a car that brakes, and a log of it."""
    folder = tmp_path_factory.mktemp("learned")
    model = Composed(MUSHR.nominal(), slower(0.02), torch.float64)
    log = run_episode(ModelPlant(model, MUSHR), RandomCommands(MUSHR, seed=1), None, steps=120, name="braked")
    write_log(log, folder / "braked.csv")
    save_model(model, folder / "model")
    save_model(model.below, folder / "below")
    save_model(Ensemble(MUSHR.layouts, 2, (4,), dt=MUSHR.dt, robot="mushr"), folder / "networks")
    return folder


def test_compare_predicts_with_the_whole(folder: Path) -> None:
    errors = {}
    for name in ("model", "below", "networks"):
        result = result_of(["compare", str(folder / name), str(folder / "braked.csv"), "--start", "measured"], folder)
        errors[name] = result["free_run"]["errors"]["position"]["value"]
    assert errors["model"] < 1e-4 < 1e-2 * errors["below"]
    assert np.isfinite(errors["networks"])


def test_run_flies_the_whole(folder: Path) -> None:
    """In itself as the plant, the brake is there: the car that knows of it stays nearer than the one that does not."""
    flown = {}
    for name in ("model", "networks"):
        options = ["--seconds", "0.5", "--samples", "32", "--plant", "model", "--out", str(folder / name / "flown")]
        flown[name] = result_of(["run", str(folder / name), "circle", *options], folder)
    assert all(np.isfinite(result["tracking"]) and result["log"] for result in flown.values())


@pytest.mark.slow
def test_show_and_export_have_the_whole(folder: Path, tmp_path: Path) -> None:
    shown = result_of(["show", str(folder / "model")], tmp_path)
    assert "over states and actions, 1 past commands and 0 past states, of vx" in shown["learned"]["residual"]
    assert shown["equations"]
    assert "an ensemble of 2 networks" in result_of(["show", str(folder / "networks")], tmp_path)["learned"]["base"]
    state, actions = torch.tensor(MUSHR.start).float().expand(3, -1), torch.rand(3, 4, 2)
    for name in ("model", "networks"):
        model = open_model(str(folder / name))
        main(["export", str(folder / name), "torchscript", "--out", str(tmp_path / "model.pt")])
        exported = torch.jit.load(str(tmp_path / "model.pt"))
        torch.testing.assert_close(exported.rollout(state, actions), rollout(model, state, actions))
        main(["export", str(folder / name), "torch-export", "--out", str(tmp_path / "model.pt2")])
        program = torch.export.load(str(tmp_path / "model.pt2")).module()
        given = {"inputs": torch.zeros(3, 3), "past": actions[:, 0]} if name == "model" else {}
        torch.testing.assert_close(
            program(state=state, action=actions[:, 0], **given), rollout(model, state, actions)[:, 0]
        )


def test_equations_alone_are_exported_as_text(folder: Path, refused: Refused, tmp_path: Path) -> None:
    said = refused(f"export {folder}/model latex --out {tmp_path}/model.tex")
    assert "a model with networks is exported as torchscript or torch-export" in said
    assert not (tmp_path / "model.tex").exists()


def test_what_works_on_equations_says_that_it_leaves_the_residual_out(
    folder: Path, refused: Refused, tmp_path: Path
) -> None:
    said = "this is about the equations below, without it"
    new = str(tmp_path / "new")
    added = result_of(["add", str(folder / "model"), "wheelbase", "value=1.1", "--out", new], tmp_path)
    assert any(said in note for note in added["notes"])
    assert load_model(new).effects
    planned = result_of(["plan", str(folder / "model"), "circle", "--seconds", "4"], tmp_path)
    assert any(said in note for note in planned["notes"])
    error = refused(f"diagnose {folder}/networks {folder}/braked.csv")
    assert "expected a model of equations, found an ensemble of networks" in error


def test_diagnose_leaves_the_residual_out_and_says_so(folder: Path) -> None:
    options = ["--no-calibrate", "--exclude", *EXCLUDED, "--horizon", "0.5"]
    result = result_of(["diagnose", str(folder / "model"), str(folder / "braked.csv"), *options], folder)
    assert any("without it" in note for note in result["notes"])
