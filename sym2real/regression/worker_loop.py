"""The worker's side of an engine that runs in a process of its own: one request a line, one answer a line, in JSON.

A request is ``{"command": …, further arguments}``, an answer ``{"result": …}`` or ``{"error": {"type", "message"}}``.
Nothing here imports torch, which must not share a process with Julia.
"""

from __future__ import annotations

import base64
import json
import os
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def encode(values: Array) -> dict[str, Any]:
    """An array of float64 as JSON, bit by bit."""
    exact = np.ascontiguousarray(values, dtype="<f8")
    return {"shape": list(exact.shape), "float64": base64.b64encode(exact.tobytes()).decode("ascii")}


def decode(packed: Mapping[str, Any]) -> Array:
    """The array that :func:`encode` packed."""
    return np.frombuffer(base64.b64decode(packed["float64"]), dtype="<f8").reshape(packed["shape"]).copy()


def serve(commands: Mapping[str, Callable[..., Any]]) -> None:
    """Answer requests until standard input ends.

    The two streams are kept for the protocol alone: what libraries print goes to standard error, and what they read
    from standard input is empty.
    """
    with os.fdopen(os.dup(0), encoding="utf-8") as requests, os.fdopen(os.dup(1), "w", encoding="utf-8") as answers:
        nothing = os.open(os.devnull, os.O_RDONLY)
        os.dup2(nothing, 0)
        os.dup2(2, 1)
        for line in requests:
            answers.write(json.dumps(_answer(json.loads(line), commands)) + "\n")
            answers.flush()


def _answer(request: dict[str, Any], commands: Mapping[str, Callable[..., Any]]) -> dict[str, Any]:
    try:
        return {"result": commands[request.pop("command")](**request)}
    # Whatever goes wrong in the engine is told to the process that asked; this one goes on.
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        return {"error": {"type": type(error).__name__, "message": str(error)}}
