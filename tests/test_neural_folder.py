"""Model folders of every kind: what comes back is what went in, other programs open it, and mixtures are refused."""

from __future__ import annotations

import json
import subprocess
import sys
from hashlib import sha256
from pathlib import Path

import pytest
import torch
from reference_models import motor_lagged

from sym2real.errors import DataError, ModelError
from sym2real.field import Field
from sym2real.layout import Layout, Layouts
from sym2real.neural import Composed, Ensemble, Model, ResidualMLP, SymbolicResidual, open_model, save_model
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic import Equations, compile_model, load_model, rollout, symbol
from sym2real.symbolic.storage import NEURAL, is_part_of_model

LAYOUTS = CRAZYFLIE.layouts


def residual(seed: int = 1, **past: int) -> ResidualMLP:
    made = ResidualMLP(LAYOUTS, (8, 8), seed, **past)
    with torch.no_grad():
        made.linears[-1].weight.normal_(0.0, 0.01, generator=torch.Generator().manual_seed(seed))
    return made


def expressions() -> SymbolicResidual:
    return SymbolicResidual(LAYOUTS, {"vx": 0.01 * symbol("vx") * symbol("thrust"), "wz": 0.1 * symbol("wz_cmd")})


def ensemble(*, probabilistic: bool = False) -> Ensemble:
    return Ensemble(LAYOUTS, 2, (8, 8), seed=3, probabilistic=probabilistic, dt=0.02, robot="crazyflie")


MODELS = {
    "equations": CRAZYFLIE.nominal,
    "equations and network": lambda: Composed(CRAZYFLIE.nominal(), residual()),
    "hidden states and a network that remembers": lambda: Composed(motor_lagged(), residual(commands=2, states=1)),
    "ensemble": ensemble,
    "probabilistic ensemble": lambda: ensemble(probabilistic=True),
    "ensemble and network": lambda: Composed(ensemble(), residual()),
    "ensemble and expressions": lambda: Composed(ensemble(), expressions()),
}


def predicted(model: Model) -> torch.Tensor:
    generator = torch.Generator().manual_seed(0)
    state = LAYOUTS.state.normalise(
        torch.tensor(CRAZYFLIE.start).float() + 0.1 * torch.randn(5, 13, generator=generator)
    )
    actions = torch.tensor(CRAZYFLIE.rest).float() + 0.1 * torch.randn(5, 4, 4, generator=generator)
    with torch.no_grad():
        return rollout(compile_model(model) if isinstance(model, Equations) else model, state, actions)


@pytest.mark.parametrize("kind", MODELS)
def test_a_folder_gives_back_what_it_was_given(kind: str, tmp_path: Path) -> None:
    model = MODELS[kind]()
    again = open_model(save_model(model, tmp_path / "model"))
    assert type(again) is type(model)
    torch.testing.assert_close(predicted(again), predicted(model), rtol=0, atol=0)
    assert all(is_part_of_model(file) for file in (tmp_path / "model").iterdir())
    if isinstance(model, Composed):
        assert again.past_rows == model.past_rows
    if isinstance(model, Ensemble):
        assert (again.dt, again.robot) == (0.02, "crazyflie")


def test_an_ensemble_keeps_fields_that_no_vocabulary_knows(tmp_path: Path) -> None:
    turned = Layout((Field("angle", ("s1", "c1"), kind="circle"), Field("rate", ("w1",), "rad/s")))
    before = Ensemble(Layouts(turned, Layout((Field("torque", ("u1",), "N m"),))), 2, (8,))
    opened = open_model(save_model(before, tmp_path))
    assert isinstance(opened, Ensemble)
    assert opened.layouts == before.layouts
    state, action = torch.tensor([0.6, 0.8, 1.0]), torch.tensor([0.3])
    torch.testing.assert_close(opened(state, action), before(state, action))


@pytest.mark.slow
def test_other_programs_fly_the_whole(tmp_path: Path) -> None:
    """Base and residual, in a process without this package."""
    kinds = [kind for kind in MODELS if "hidden" not in kind]
    for kind in kinds:
        model = MODELS[kind]()
        save_model(model, tmp_path / kind)
        torch.save({"found": predicted(model)}, tmp_path / kind / "expected.pt")
    code = f"""
import torch, sys
from pathlib import Path
sys.modules["sym2real"] = None
generator = torch.Generator().manual_seed(0)
state = torch.tensor({CRAZYFLIE.start.tolist()}).float() + 0.1 * torch.randn(5, 13, generator=generator)
state[:, 3:7] /= state[:, 3:7].norm(dim=-1, keepdim=True)
actions = torch.tensor({CRAZYFLIE.rest.tolist()}).float() + 0.1 * torch.randn(5, 4, 4, generator=generator)
for kind in {kinds!r}:
    folder = Path({str(tmp_path)!r}) / kind
    module, expected = torch.jit.load(str(folder / "module.pt")), torch.load(folder / "expected.pt")["found"]
    with torch.no_grad():
        torch.testing.assert_close(module.rollout(state, actions), expected, msg=lambda text: kind + ": " + text)
"""
    done = subprocess.run([sys.executable, "-W", "ignore", "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_one_model_leaves_nothing_of_another(tmp_path: Path) -> None:
    for kind in [*MODELS, *reversed(MODELS)]:
        model = MODELS[kind]()
        (tmp_path / "notes.txt").write_text("kept")
        again = open_model(save_model(model, tmp_path))
        torch.testing.assert_close(predicted(again), predicted(model), rtol=0, atol=0)
    assert not {file.name for file in tmp_path.iterdir()} & {*NEURAL}
    assert (tmp_path / "notes.txt").read_text() == "kept"


def test_the_equations_below_are_never_flown_by_mistake(tmp_path: Path) -> None:
    base = CRAZYFLIE.nominal()
    save_model(Composed(base, residual()), tmp_path)
    with pytest.raises(ModelError, match=r"has a residual on its equations \(residual\.safetensors\)"):
        load_model(tmp_path)
    assert load_model(tmp_path, below=True).to_json() == base.to_json()


def test_what_does_not_belong_together_is_refused(tmp_path: Path) -> None:
    one, two = (save_model(Composed(CRAZYFLIE.nominal(), residual(seed)), tmp_path / str(seed)) for seed in (1, 2))
    (one / "residual.safetensors").replace(two / "residual.safetensors")
    with pytest.raises(ModelError, match=r"2/residual\.safetensors is not the file that model\.json"):
        open_model(two)
    with pytest.raises(DataError, match=r"1/residual\.safetensors"):
        open_model(one)
    (two / "model.json").unlink()
    with pytest.raises(ModelError, match=r"residual\.safetensors: no model\.json beside it"):
        open_model(two)
    for text in ('{"files": 3}', '{"files": {"../other": "0"}}', "nothing"):
        (one / "model.json").write_text(text)
        with pytest.raises(DataError, match=r"model\.json"):
            open_model(one)


def test_a_residual_from_elsewhere_runs_no_code(tmp_path: Path) -> None:
    save_model(Composed(ensemble(), expressions()), tmp_path)
    for text in ("__import__('os').getcwd()", "vx + nobody", "thrust +"):
        about = json.loads((tmp_path / "residual.json").read_text())
        about["residual"]["vx"] = text
        (tmp_path / "residual.json").write_text(json.dumps(about))
        listed = json.loads((tmp_path / "model.json").read_text())["files"]
        listed["residual.json"] = sha256((tmp_path / "residual.json").read_bytes()).hexdigest()
        (tmp_path / "model.json").write_text(json.dumps({"files": listed}))
        with pytest.raises(DataError, match=r"residual\.json: expected the expressions of a residual"):
            open_model(tmp_path)
