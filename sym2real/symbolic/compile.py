"""Equations → torch module: generated source, scripted by TorchScript, rolled out over a horizon in one call."""

import hashlib
import linecache
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from threading import RLock
from types import ModuleType

import torch
from sympy import Expr
from torch import Tensor, nn
from torch.jit._fuser import optimized_execution

from sym2real.errors import ModelError, ShapeError
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.expressions import canonical
from sym2real.symbolic.native_choice import native_rollout
from sym2real.symbolic.native_rollout import require_broadcast
from sym2real.symbolic.source import function_source, measured_inputs, model_source

# TorchScript knows classes by their names: two threads that make or script the same one would define it twice.
_ALONE = RLock()


def class_from_source(source: str, name: str) -> type[nn.Module]:
    """The class that a text defines, the same of the same text."""
    with _ALONE:
        return _class_of(source, name)


@lru_cache(maxsize=256)
def _class_of(source: str, name: str) -> type[nn.Module]:
    """TorchScript reads source through ``linecache``: no file is written."""
    label = f"sym2real_generated_{hashlib.sha256(source.encode()).hexdigest()[:16]}"
    file = f"<{label}>"
    linecache.cache[file] = (len(source), None, source.splitlines(keepends=True), file)
    module = sys.modules[label] = ModuleType(label)  # where torch.compile looks for it
    exec(compile(source, file, "exec"), module.__dict__)  # our own generated text
    module_class: type[nn.Module] = getattr(module, name)
    return module_class


def script(module: nn.Module) -> torch.jit.ScriptModule:
    """TorchScript of a module, without torch's warning that scripting is deprecated."""
    with _ALONE, warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        scripted: torch.jit.ScriptModule = torch.jit.script(module)
    return scripted


def build_module(equations: Equations) -> nn.Module:
    """Plain module of the equations, for ``torch.export`` and as the text's meaning; see :func:`compile_model`."""
    return class_from_source(model_source(equations), "Dynamics")()


def compile_model(
    equations: Equations, device: torch.device | str = "cpu", dtype: torch.dtype = torch.float32
) -> torch.jit.ScriptModule:
    """Scripted model of the equations.

    ``model(state, action, inputs=None, parameters=None)`` gives the next state ``# (..., n)``, on the manifold; all
    leading dimensions broadcast. ``model.rollout(state, actions, inputs=None, parameters=None)`` runs a horizon, see
    :func:`rollout`. Parameters ``# (..., P)`` stand in the order of ``equations.parameters`` and replace the values
    that the equations carry: the buffer ``model.values``, trainable after ``model.values.requires_grad_()``, and
    :func:`read_back` takes what came of that. Without inputs the wrench is zero and time starts at zero; other inputs
    that the equations use must be given.

    Args:
        equations: what to compile.
        device: where the parameters live; computation follows the state.
        dtype: of the parameters.

    Raises:
        ModelError: when a function is not supported, with its name; for what are no equations.

    Examples:
        >>> model = compile_model(car(wheelbase=0.3))
        >>> model(torch.zeros(8, 7), torch.zeros(8, 2)).shape
        torch.Size([8, 7])
    """
    if not isinstance(equations, Equations):
        actual = type(equations).__name__
        raise ModelError(f"expected equations to compile, found {actual}; a model with networks predicts as it is")
    model = script(build_module(equations).to(device=device, dtype=dtype))
    model.equations = equations  # for those who can do better than call it; not saved with it
    return model


def compile_function(
    expressions: Sequence[Expr], arguments: Sequence[Sequence[str]], definitions: Mapping[str, Expr] | None = None
) -> torch.jit.ScriptModule:
    """Scripted ``f(*tensors)``: values ``# (..., len(expressions))`` of expressions over named columns.

    Args:
        expressions: what to compute.
        arguments: names of the columns of each tensor argument ``# (..., k_i)``; leading dimensions broadcast.
        definitions: names that stand for expressions, as quantities do; putting them in would have SymPy simplify what
            comes of it, for minutes where it holds angles of roots.

    Raises:
        ModelError: when a function is not supported, with its name.
        UnknownNameError: when an expression uses a name that no argument has and nothing defines.
    """
    return script(build_function(expressions, arguments, definitions))


def build_function(
    expressions: Sequence[Expr], arguments: Sequence[Sequence[str]], definitions: Mapping[str, Expr] | None = None
) -> nn.Module:
    """Plain module of :func:`compile_function`, for ``torch.compile`` and ``torch.export``."""
    if not expressions or not all(len(columns) for columns in arguments) or not arguments:
        raise ModelError("expected at least one expression and one column per argument")
    source = function_source([canonical(expression) for expression in expressions], arguments, definitions)
    return class_from_source(source, "Function")()


def rollout(
    model: Callable[..., Tensor],
    state: Tensor,
    actions: Tensor,
    inputs: Tensor | None = None,
    parameters: Tensor | None = None,
    *,
    past: Tensor | None = None,
    normalise: Callable[[Tensor], Tensor] | None = None,
) -> Tensor:
    """States after each action ``# (..., H, n)``.

    Models that are rolled out often are compiled to C, see :mod:`sym2real.symbolic.native_choice`. On the processor
    TorchScript runs without the executor's profiling: it takes the first two calls of a model ten times as long and
    makes the later ones no faster. On a GPU it joins small kernels, in some seconds, and later calls are several
    times as fast.

    Args:
        model: compiled model, any dynamics model, or a plain ``(state, action)`` function.
        state: start ``# (..., n)``.
        actions: ``# (..., H, m)``.
        inputs: held over the horizon when they have fewer dimensions than the actions ``# (..., k)`` (a column ``t``
            advances, in compiled models), else one row per step ``# (..., H, k)``.
        parameters: parameter sets ``# (..., P)`` of a compiled model.
        past: of the start, for a model that sees one, as its rollout takes it.
        normalise: puts states back on the manifold after each step of a model that does not do it itself.

    Raises:
        ShapeError: where columns, steps or batches do not fit, and for parameters of a model that takes none.

    Examples:
        >>> state, actions = torch.tensor([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), torch.zeros(16, 2)
        >>> rollout(compile_model(car(wheelbase=0.3)), state, actions).shape
        torch.Size([16, 7])
    """
    _require_fit(model, state, actions, inputs, parameters)
    whole = getattr(model, "rollout", None)
    if whole is not None:
        native = native_rollout(model, state, actions, (inputs, parameters))
        if native is not None:
            values = model.values if parameters is None else parameters  # type: ignore[attr-defined]
            return native(state, actions, inputs, values)
        with optimized_execution(state.device.type != "cpu"):
            result: Tensor = whole(state, actions, inputs, parameters, *(() if past is None else (past,)))
        return result
    if parameters is not None:
        raise ShapeError("this model has no rollout of its own and takes no parameters")
    per_step, states = inputs is not None and inputs.dim() >= actions.dim(), []
    for step in range(actions.shape[-2]):
        given = () if inputs is None else (inputs[..., step, :] if per_step else inputs,)
        state = model(state, actions[..., step, :], *given)
        state = state if normalise is None else normalise(state)
        states.append(state)
    return torch.stack(states, dim=-2)


def _require_fit(
    model: object, state: Tensor, actions: Tensor, inputs: Tensor | None, parameters: Tensor | None
) -> None:
    if actions.dim() < 2 or not actions.shape[-2]:
        raise ShapeError(f"expected actions (..., H, m) of at least one step, found the shape {tuple(actions.shape)}")
    if inputs is not None and inputs.dim() >= actions.dim() and inputs.shape[-2] != actions.shape[-2]:
        raise ShapeError(f"expected inputs for {actions.shape[-2]} steps, found {inputs.shape[-2]}")
    equations = getattr(model, "equations", None)
    if isinstance(model, torch.jit.ScriptModule) and isinstance(equations, Equations):
        wanted = {group.removesuffix("s"): layout.columns for group, layout in equations.layouts.groups.items()}
        wanted["parameter"] = tuple(equations.parameters)
        for (name, columns), tensor in zip(wanted.items(), (state, actions, inputs, parameters), strict=True):
            if tensor is not None and tensor.shape[-1] != len(columns):
                raise ShapeError(f"expected the {name} columns {' '.join(columns)}, found {tensor.shape[-1]} columns")
        if inputs is None and measured_inputs(equations):
            raise ShapeError(f"the equations need their inputs: {', '.join(measured_inputs(equations))}")
        require_broadcast(state.shape[:-1], actions.shape[:-2])


def equations_of(model: object) -> Equations | None:
    """The equations that a model is, or was made of, with the values that it has now; None for other models.

    Raises:
        ModelError: for what is no model, such as the path of one.
    """
    equations = model if isinstance(model, Equations) else getattr(model, "equations", None)
    if not isinstance(equations, Equations):
        if not callable(model):
            raise ModelError(f"expected a model, found {model!r:.80}; load_model(folder) opens one that is kept")
        return None
    compiled = isinstance(model, torch.jit.ScriptModule) and bool(equations.parameters)
    return read_back(model, equations) if compiled else equations  # type: ignore[arg-type]


def read_back(module: nn.Module, equations: Equations) -> Equations:
    """The equations with the parameter values that a trained module has.

    Raises:
        ModelError: when the module has another number of parameters, or one is not finite.
    """
    values = module.state_dict()["values"].to("cpu", torch.float64)
    if values.shape != (len(equations.parameters),):
        raise ModelError(f"expected {len(equations.parameters)} parameter values, found shape {tuple(values.shape)}")
    if not bool(values.isfinite().all()):
        raise ModelError("training has left parameter values that are not finite")
    return replace(equations, parameters=dict(zip(equations.parameters, values.tolist(), strict=True)))
