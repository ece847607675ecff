"""The process that Operon lives in: its estimators cannot be pickled, so models leave it as text.

``python -m sym2real.regression.operon_worker`` answers on standard output (:mod:`sym2real.regression.worker_loop`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pyoperon.sklearn import SymbolicRegressor

from sym2real.regression.worker_loop import decode, serve


def fit(
    values: dict[str, Any], target: dict[str, Any], names: list[str], scales: list[float], settings: dict[str, Any]
) -> list[list[Any]]:
    """Search one equation; the models that none other beats in both error and length, as [error, text].

    Args:
        values: values of the variables divided by their scales ``# (rows, variables)``.
        target: ``# (rows,)``.
        names: what to write for each variable.
        scales: what each variable was divided by.
        settings: of pyoperon's ``SymbolicRegressor``.
    """
    regressor = SymbolicRegressor(**settings)
    regressor.fit(decode(values), decode(target))
    factors = {key: (name, scale) for key, name, scale in zip(regressor.variables_, names, scales, strict=True)}
    return [
        [float(model["mean_squared_error"]) ** 0.5, tree_text(model["tree"].Nodes, factors)]
        for model in regressor.pareto_front_
    ]


def tree_text(nodes: Sequence[Any], variables: dict[int, tuple[str, float]]) -> str:
    """A tree in postfix order as text with every operation in parentheses and every digit of its numbers.

    Operon's own formatter writes a fixed number of decimals, which cuts small coefficients short. The operands of a
    node stand before it, the first one last.
    """
    stack: list[str] = []
    for node in nodes:
        kind = node.Type.name
        if kind == "Constant":
            stack.append(f"({float(node.Value)!r})")
        elif kind == "Variable":
            name, scale = variables[node.HashValue]
            stack.append(f"({float(node.Value) / scale!r} * {name})")
        else:
            operands = [stack.pop() for _ in range(node.Arity)]
            stack.append("(" + {"Add": " + ", "Sub": " - ", "Mul": " * "}[kind].join(operands) + ")")
    (text,) = stack
    return text


if __name__ == "__main__":
    serve({"fit": fit})
