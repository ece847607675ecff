"""What a model predicts of a step: the work of its method of this name."""

from dataclasses import replace
from functools import lru_cache

import torch
from torch import Tensor

from sym2real.effects.along_logs import precision_of
from sym2real.effects.sensors import MeasuredModel
from sym2real.effects.visible import visible_state
from sym2real.protocols import DynamicsModel, WholeModel
from sym2real.symbolic import Equations, equations_of
from sym2real.symbolic.predicting import Values, tensor_of
from sym2real.trajectory import check_columns

_measured = lru_cache(maxsize=32)(MeasuredModel)


def predict(whole: Equations | WholeModel, state: Values, action: Values, inputs: Values | None = None) -> Values:
    """See :meth:`~sym2real.Equations.predict`."""
    if isinstance(state, Tensor):
        layouts = replace(whole.layouts, state=visible_state(whole))
        none = state.new_zeros((*state.shape[:-1], layouts.inputs.size))
        given = (state, _like(state, action), none if inputs is None else _like(state, inputs))
        for (name, layout), values in zip(layouts.groups.items(), given, strict=True):
            check_columns(name, values.shape, layout)
        model = _model_of(whole)
        precision = precision_of(model)
        # What a network has learned asks for no derivative of a prediction: a tensor that does says so.
        with torch.set_grad_enabled(torch.is_grad_enabled() and any(values.requires_grad for values in given)):
            return model(*(values.to(precision) for values in given)).to(state)
    given = [tensor_of(values) for values in (state, action)] + ([] if inputs is None else [tensor_of(inputs)])
    with torch.no_grad():
        return predict(whole, *given).numpy()


def _model_of(whole: Equations | WholeModel) -> DynamicsModel:
    if isinstance(whole, Equations):
        return _measured(whole)
    equations = equations_of(whole)
    return whole if equations is None else MeasuredModel(equations, whole)


def _like(state: Tensor, values: Values) -> Tensor:
    return values if isinstance(values, Tensor) else tensor_of(values).to(state)
