"""What networks and expressions a model has beside its equations, in words."""

from sym2real.neural.composed import Composed
from sym2real.neural.ensemble import Ensemble
from sym2real.neural.model_folder import Model
from sym2real.neural.residual_mlp import ResidualMLP
from sym2real.symbolic import text


def described(model: Model) -> dict[str, str]:
    """A line for the residual and one for an ensemble, where the model has them, by "residual" and "base"."""
    lines = {}
    below = model.below if isinstance(model, Composed) else model
    if isinstance(below, Ensemble):
        kind = "probabilistic networks" if below.probabilistic else "networks"
        lines["base"] = f"base: an ensemble of {below.networks.count} {kind}, {_sizes(below.widths)}, and no equations"
    if isinstance(model, Composed):
        lines["residual"] = f"residual: {_residual(model)}"
    return lines


def _residual(model: Composed) -> str:
    residual = model.residual
    if not isinstance(residual, ResidualMLP):
        given = {column: text(expression) for column, expression in residual.expressions.items() if expression != 0}
        return "; ".join(f"{column}' + {written}" for column, written in given.items()) or "zero"
    on = [c for c, size in zip(model.layouts.state, residual.output_scale.tolist(), strict=True) if size]
    past = f", {residual.commands} past commands and {residual.states} past states" if any(model.past_rows) else ""
    return f"a network, {_sizes(residual.widths)}, over states and actions{past}, of {' '.join(on) or 'no column'}"


def _sizes(widths: tuple[int, ...]) -> str:
    return " × ".join(map(str, widths))
