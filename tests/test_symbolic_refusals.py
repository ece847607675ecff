"""What rollouts refuse, and that compiled C refuses what torch does: which of them runs is nobody's choice."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import torch
from torch import Tensor

from sym2real.errors import ShapeError
from sym2real.layout import Layout, Layouts
from sym2real.native import find_compiler
from sym2real.robots import MUSHR
from sym2real.symbolic import Equations, compile_model, native_choice, rollout
from sym2real.symbolic.native_rollout import NativeRollout

NOMINAL = MUSHR.nominal()
MODELS: dict[str, Callable[..., Tensor]] = {
    "compiled": compile_model(NOMINAL),
    "plain": lambda state, action: state,
}
needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("shape", [(2,), (0, 2), (3, 0, 2)])
def test_no_action_is_no_rollout(model: str, shape: tuple[int, ...]) -> None:
    with pytest.raises(ShapeError, match="at least one step"):
        rollout(MODELS[model], torch.zeros(7), torch.zeros(shape))


@pytest.mark.parametrize("many", [False, pytest.param(True, marks=needs_compiler)])
def test_operands_of_a_compiled_model_that_do_not_fit(many: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if many:  # the first rollout is compiled
        monkeypatch.setattr(native_choice, "MANY", 0)
    model, state, actions = compile_model(NOMINAL), torch.zeros(7), torch.zeros(3, 4, 2)
    with pytest.raises(ShapeError, match="expected the state columns x y"):
        rollout(model, state[:6], actions)
    with pytest.raises(ShapeError, match="expected the action columns steer speed, found 3 columns"):
        rollout(model, state, torch.zeros(3, 4, 3))
    with pytest.raises(ShapeError, match=r"batches that broadcast, found \(2,\), \(3,\)"):
        rollout(model, state.expand(2, 7), actions)
    with pytest.raises(ShapeError, match="expected the input columns fx fy tz, found 2 columns"):
        rollout(model, state, actions, torch.zeros(2))
    with pytest.raises(ShapeError, match="inputs for 4 steps, found 5"):
        rollout(model, state, actions, torch.zeros(3, 5, 3))
    with pytest.raises(ShapeError, match="expected the parameter columns"):
        rollout(model, state, actions, parameters=torch.zeros(2))
    assert rollout(model, state, torch.zeros(0, 4, 2)).shape == (0, 4, 7)


@needs_compiler
def test_the_kernel_reads_no_memory_that_is_elsewhere() -> None:
    """It reads by address what it has laid out itself."""
    kernel = NativeRollout(NOMINAL, torch.float32)
    state, actions = torch.zeros(7), torch.zeros(4, 2)
    with pytest.raises((RuntimeError, NotImplementedError)):
        kernel(state.to("meta"), actions)
    with pytest.raises(ShapeError, match="batches that broadcast"):
        kernel(state.expand(2, 7), actions.expand(3, 4, 2))


@needs_compiler
def test_parameters_that_live_elsewhere_leave_a_rollout_to_torch(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(native_choice, "MANY", 0)
    model, state, actions = compile_model(NOMINAL), torch.zeros(7), torch.zeros(3, 4, 2)
    assert native_choice.native_rollout(model, state, actions, ()) is not None
    assert native_choice.native_rollout(model.to("meta"), state, actions, ()) is None


@pytest.mark.parametrize("many", [False, pytest.param(True, marks=needs_compiler)])
def test_what_is_measured_is_not_taken_for_zero(many: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if many:
        monkeypatch.setattr(native_choice, "MANY", 0)
    layouts = Layouts(Layout.of(("vx",)), Layout.of(("speed",)), Layout.of(("vbat", "fx")))
    equations = Equations.parse(layouts, {"vx": "vx + 0.1*speed*vbat + fx"}, 0.1)
    model, state, actions = compile_model(equations), torch.zeros(1), torch.ones(2, 1)
    with pytest.raises(ShapeError, match="need their inputs: vbat"):
        rollout(model, state, actions)
    assert rollout(model, state, actions, torch.tensor([4.0, 0.0]))[-1, 0] == pytest.approx(0.8)
