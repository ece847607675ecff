"""A model folder as its format says opens, and means what it meant."""

from __future__ import annotations

import hashlib
from pathlib import Path

import torch
from safetensors.torch import save_file

from sym2real.experiments.models import open_model
from sym2real.symbolic import compile_model

# As its `save_model` wrote it, but for spaces: hidden state, quantity, filter, effect, sensor and time.
EQUATIONS = """{"format": "sym2real equations 1", "robot": "buggy", "dt": 0.1,
"layouts": {"state": [
 {"name": "position", "columns": ["x"], "unit": "m", "frame": "world", "kind": "vector", "hidden": false},
 {"name": "velocity", "columns": ["vx"], "unit": "m/s", "frame": "world", "kind": "vector", "hidden": false},
 {"name": "lagged", "columns": ["lagged"], "unit": "m/s", "frame": "world", "kind": "vector", "hidden": true}],
"action": [{"name": "speed", "columns": ["speed"], "unit": "m/s", "frame": "body", "kind": "vector", "hidden": false}],
"inputs": [{"name": "force", "columns": ["fx"], "unit": "N", "frame": "world", "kind": "vector", "hidden": false},
 {"name": "time", "columns": ["t"], "unit": "s", "frame": "", "kind": "vector", "hidden": false}]},
"next": {"x": "0.1*vx + x", "vx": "0.1*fx + 0.1*k*push*cos(t) + vx", "lagged": "0.5*lagged + 0.5*speed"},
"output": {"x": "x + 0.01"}, "quantities": {"push": "lagged - vx"}, "parameters": {"k": 1.5}, "notes": ["a note"],
"numbers": {"mass": 3.0}, "filters": [{"effect": "lag:speed", "values": {"value": "0.1"}}],
"start": {"lagged": "speed"}, "effects": [{"effect": "lag:speed", "values": {"value": 0.1}}]}
"""


def test_equations_open_and_predict_what_they_did(tmp_path: Path) -> None:
    (tmp_path / "equations.json").write_text(EQUATIONS)
    about = {"equations": hashlib.sha256(EQUATIONS.encode()).hexdigest()}
    save_file({"parameters": torch.tensor([2.5], dtype=torch.float64)}, tmp_path / "parameters.safetensors", about)
    equations = open_model(str(tmp_path))
    state, action, inputs = torch.tensor([1.0, 2.0, 3.0]), torch.tensor([5.0]), torch.tensor([0.7, 0.0])
    found = compile_model(equations)(state, action, inputs)
    torch.testing.assert_close(found, torch.tensor([1.2, 2.0 + 0.07 + 0.1 * 2.5 * (3.0 - 2.0), 4.0]))
    assert (equations.robot, equations.notes, equations.numbers) == ("buggy", ("a note",), {"mass": 3.0})
    assert equations.filters[0][0] == equations.effects[0][0] == "lag:speed"
