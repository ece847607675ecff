"""Methods of values whose work stands in a room above their own, looked up by name when they are called.

Imports point down (``tests/test_rooms.py``). What a user expects as a method of equations, a log or an answer and needs
more than its own room has is listed here, and nowhere else.
"""

from collections.abc import Callable
from importlib import import_module
from typing import Any

OWNERS = {
    "predict": "sym2real.diagnosis.errors.simulating",
    "simulate": "sym2real.diagnosis.errors.simulating",
    "score": "sym2real.diagnosis.errors.simulating",
    "log_of_frame": "sym2real.logs.frames",
    "frame_of_log": "sym2real.logs.frames",
    "log_plot": "sym2real.report.notebook",
    "adaptation_plot": "sym2real.report.notebook",
    "comparison_plot": "sym2real.report.notebook",
    "ladder_plot": "sym2real.report.notebook",
    "write_diagnosis_page": "sym2real.report.html.pages",
    "comparison_html": "sym2real.report.notebook",
    "diagnosis_html": "sym2real.report.notebook",
    "diagnosis_text": "sym2real.report.notebook",
    "tried_html": "sym2real.report.notebook",
    "plan_html": "sym2real.report.notebook",
}


def upward(name: str) -> Callable[..., Any]:
    """The function of that name in the room that owns it."""
    function: Callable[..., Any] = getattr(import_module(OWNERS[name]), name)
    return function
