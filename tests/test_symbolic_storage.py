"""Saved and exported models: they open without this package, and a failure leaves what was there."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from cli_results import result_of
from sympy import besselj, latex

from sym2real.effects import compose, effect
from sym2real.effects.terms import with_time
from sym2real.errors import DataError, ModelError, UnknownNameError
from sym2real.layout import Layout, Layouts
from sym2real.neural import Composed, ResidualMLP
from sym2real.neural.exporting import export as export_whole
from sym2real.robots import MUSHR
from sym2real.symbolic import Equations, compile_model, export, load_model, rollout, save_model, symbol

LAYOUTS = Layouts(Layout.of(["x", "vx"]), Layout.of(["thrust"]), Layout.of(["fx"]))
EQUATIONS = Equations.parse(
    LAYOUTS,
    {"x": "x + 0.1*vx", "vx": "vx + 0.1*(thrust*cos(x) + fx)/mass"},
    0.1,
    parameters={"mass": 0.1 + 0.2},
)
STATE, ACTIONS, INPUTS = torch.tensor([[0.1, 0.2]] * 4), torch.ones(4, 5, 1), torch.full((4, 1), 0.3)

ELSEWHERE = """
import sys, torch
assert "sym2real" not in sys.modules
{body}
assert "sym2real" not in sys.modules
state, actions, inputs = torch.tensor([[0.1, 0.2]] * 4), torch.ones(4, 5, 1), torch.full((4, 1), 0.3)
print({result})
"""


def run_elsewhere(folder: Path, body: str, result: str) -> list[float]:
    code = ELSEWHERE.format(body=body, result=result)
    command = [sys.executable, "-W", "ignore", "-P", "-c", code]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return [float(value) for value in done.stdout.strip(" []\n").split(",")]


def test_saved_models_come_back_exactly(tmp_path: Path) -> None:
    again = load_model(save_model(EQUATIONS, tmp_path / "new" / "model"))
    assert again.to_json() == EQUATIONS.to_json()
    assert sorted(file.name for file in (tmp_path / "new" / "model").iterdir()) == [
        "equations.json",
        "module.pt",
        "parameters.safetensors",
    ]


def test_module_runs_without_this_package(tmp_path: Path) -> None:
    save_model(EQUATIONS, tmp_path)
    body = "import os; model = torch.jit.load('module.pt')"
    found = run_elsewhere(tmp_path, body, "model.rollout(state, actions, inputs).flatten().tolist()")
    expected = rollout(compile_model(EQUATIONS), STATE, ACTIONS, INPUTS).flatten()
    torch.testing.assert_close(torch.tensor(found), expected, rtol=1e-6, atol=1e-6)


def test_python_source_runs_without_this_package(tmp_path: Path) -> None:
    export(EQUATIONS, "python", tmp_path / "dynamics.py")
    body = "sys.path.insert(0, '.'); import dynamics; model = dynamics.Dynamics()"
    found = run_elsewhere(tmp_path, body, "model(state, actions[:, 0], inputs).flatten().tolist()")
    expected = compile_model(EQUATIONS)(STATE, ACTIONS[:, 0], INPUTS).flatten()
    torch.testing.assert_close(torch.tensor(found), expected, rtol=1e-6, atol=1e-6)


def test_exported_program_takes_any_batch(tmp_path: Path) -> None:
    program = torch.export.load(export(EQUATIONS, "torch-export", tmp_path / "model.pt2"))
    expected = compile_model(EQUATIONS)(STATE[:3], ACTIONS[:3, 0], INPUTS[:3])
    torch.testing.assert_close(program.module()(STATE[:3], ACTIONS[:3, 0], INPUTS[:3]), expected)


def test_other_formats(tmp_path: Path) -> None:
    script = torch.jit.load(str(export(EQUATIONS, "torchscript", tmp_path / "model.pt")))
    torch.testing.assert_close(script(STATE, ACTIONS[:, 0]), compile_model(EQUATIONS)(STATE, ACTIONS[:, 0]))
    document = export(EQUATIONS, "latex", tmp_path / "model.tex").read_text()
    assert r"\cos" in document
    assert all(f"{latex(symbol(column))}' &=" in document for column in EQUATIONS.next)
    with pytest.raises(UnknownNameError, match="did you mean 'torchscript'"):
        export(EQUATIONS, "torchscrip", tmp_path / "model.pt")


def test_a_failed_save_leaves_the_earlier_model(tmp_path: Path) -> None:
    save_model(EQUATIONS, tmp_path)
    (tmp_path / "episode.csv").write_text("kept")
    bad = Equations({"x": besselj(0, 0.5 + symbol("x")), "vx": 0.0}, LAYOUTS, 0.1)
    with pytest.raises(ModelError, match="besselj"):
        save_model(bad, tmp_path)
    assert load_model(tmp_path).to_json() == EQUATIONS.to_json()
    assert len(list(tmp_path.iterdir())) == 4


def test_a_folder_above_models_proposes_them(tmp_path: Path) -> None:
    save_model(EQUATIONS, tmp_path / "runs" / "found" / "model")
    for folder in (tmp_path / "runs", tmp_path / "runs" / "found"):
        with pytest.raises(DataError, match=r"did you mean .*runs/found/model") as refused:
            load_model(folder)
        assert refused.value.expected == "a model folder, which holds equations.json"
    with pytest.raises(DataError, match=r"found no such folder$"):
        load_model(tmp_path / "elsewhere")


def test_broken_folders_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"equations\.json"):
        load_model(tmp_path)
    save_model(EQUATIONS, tmp_path / "one")
    save_model(EQUATIONS.at(mass=0.5), tmp_path / "two")
    weights = tmp_path / "one" / "parameters.safetensors"
    weights.replace(tmp_path / "two" / "parameters.safetensors")
    with pytest.raises(ModelError, match="found those of other equations; save the model again"):
        load_model(tmp_path / "two")
    with pytest.raises(DataError, match=r"parameters\.safetensors"):
        load_model(tmp_path / "one")
    weights.write_bytes(b"nonsense")
    with pytest.raises(DataError, match=r"parameters\.safetensors"):
        load_model(tmp_path / "one")
    (tmp_path / "one" / "equations.json").write_text("{}")
    with pytest.raises(ModelError, match=r"equations\.json.*format"):
        load_model(tmp_path / "one")


def test_an_unknown_symbol_names_the_file(tmp_path: Path) -> None:
    equations = Equations.parse(Layouts(Layout.of(("x",)), Layout.of(("u",))), {"x": "x + u"}, 0.1)
    file = save_model(equations, tmp_path) / "equations.json"
    file.write_text(file.read_text().replace("u + x", "u + y").replace("x + u", "y + u"))
    with pytest.raises(ModelError, match=r"equations\.json: .*'y'"):
        load_model(tmp_path)


@pytest.mark.parametrize("format", ["torchscript", "torch-export", "python", "latex"])
def test_what_acts_outside_a_step_is_beside_an_export_and_told(format: str, tmp_path: Path) -> None:
    """A filter's memory is the controller's and the time is an input: both were lost without a word."""
    base = MUSHR.nominal()
    timed, time = with_time(lagged(base))
    timed = replace(timed, next={**timed.next, "vx": timed.next["vx"] + 0.1 * time})
    save_model(timed, tmp_path / "model")
    file = tmp_path / "exported"
    result = result_of(["export", str(tmp_path / "model"), format, "--out", str(file)], tmp_path)
    about = json.loads((tmp_path / "exported.json").read_text())
    assert [one["effect"] for one in about["filters"]] == ["lag:steer"]
    assert float(about["filters"][0]["values"]["value"]) == 0.1
    assert [one["column"] for one in about["inputs"]] == list(timed.layouts.inputs)
    assert about["state"][0] == {"column": "x", "unit": "m"}
    assert any(note.startswith("lag:steer is not in it") for note in result["notes"])
    assert any(note.startswith("t must be given") for note in result["notes"])


@pytest.mark.slow
@pytest.mark.parametrize("format", ["torchscript", "torch-export"])
@pytest.mark.parametrize("memory", [None, 0, 3])
def test_an_export_is_called_as_it_says(format: str, memory: int | None, tmp_path: Path) -> None:
    base = MUSHR.nominal()
    model = base if memory is None else Composed(base, ResidualMLP(base.layouts, (8,), commands=memory))
    file = export_whole(model, format, tmp_path / "exported")
    call, _, said = json.loads((tmp_path / "exported.json").read_text())["call"].partition(":")
    assert "float32" in said
    sizes = {"state": 7, "action": 2, "inputs": 3, "past": 2 * (memory or 0)}
    known = {name: torch.rand(4, size) for name, size in sizes.items()}
    following = eval(call.replace("FILE", repr(str(file))), {"torch": torch}, known)
    given = [known[name] for name in sizes if name != "past" or memory]
    wanted = (compile_model(base) if memory is None else model)(*given)
    torch.testing.assert_close(following, wanted)


@pytest.mark.parametrize("format", ["torchscript", "torch-export"])
def test_without_inputs_an_export_is_called_without_them(format: str, tmp_path: Path) -> None:
    plain = Equations.parse(Layouts.of(["x", "vx", "speed"]), {"x": "x + 0.1*vx", "vx": "speed"}, 0.1)
    known = {"state": torch.rand(4, 2), "action": torch.rand(4, 1), "past": torch.rand(4, 2)}
    for number, model in enumerate((plain, Composed(plain, ResidualMLP(plain.layouts, (8,), commands=2)))):
        file = export_whole(model, format, tmp_path / str(number))
        call = json.loads((tmp_path / f"{number}.json").read_text())["call"].partition(":")[0]
        assert eval(call.replace("FILE", repr(str(file))), {"torch": torch}, known).shape == (4, 2)


def test_an_exported_python_module_is_called_as_it_says(tmp_path: Path) -> None:
    base = MUSHR.nominal()
    source = export(base, "python", tmp_path / "model.py").read_text()
    call = json.loads((tmp_path / "model.py.json").read_text())["call"].partition(" of")[0]
    known = {name: torch.rand(4, size) for name, size in (("state", 7), ("action", 2), ("inputs", 3))}
    exec(compile(source, "model.py", "exec"), module := {"__name__": "model"})
    torch.testing.assert_close(eval(call, module, known), compile_model(base)(*known.values()))


def test_the_time_is_an_input_of_an_exported_module(tmp_path: Path) -> None:
    timed, time = with_time(MUSHR.nominal())
    timed = replace(timed, next={**timed.next, "vx": timed.next["vx"] + time})
    script = torch.jit.load(str(export(timed, "torchscript", tmp_path / "model.pt")))
    state, action = torch.zeros(MUSHR.layouts.state.size), torch.zeros(2)
    inputs = torch.zeros(len(timed.layouts.inputs))
    later = inputs.clone()
    later[timed.layouts.inputs.index("t")] = 3.0
    moved = script(state, action, later) - script(state, action, inputs)
    assert float(moved[MUSHR.layouts.state.index("vx")]) == pytest.approx(3.0)


def test_what_is_written_beside_an_export_replaces_no_model(tmp_path: Path) -> None:
    save_model(EQUATIONS, tmp_path)
    before = (tmp_path / "equations.json").read_bytes()
    with pytest.raises(ModelError, match="part of a model"):
        export(EQUATIONS, "python", tmp_path / "equations")
    assert (tmp_path / "equations.json").read_bytes() == before


def lagged(base: Equations) -> Equations:
    return compose(base, [(effect("lag:steer", base), {"value": 0.1})])
