"""Methods of values whose work stands in a room above their own, looked up by name when they are called.

Imports point down (``tests/test_rooms.py``). What a user expects as a method of equations, a log or an answer and needs
more than its own room has is listed here, and nowhere else.
"""

from collections.abc import Callable
from importlib import import_module
from typing import TypeVar

Result = TypeVar("Result")  # as who calls it needs it
_OF = {
    "sym2real.diagnosis.data.windows": ("simulate",),
    "sym2real.diagnosis.errors.comparison": ("score",),
    "sym2real.effects.one_step": ("predict",),
    "sym2real.logs.frames": ("log_of_frame", "frame_of_log"),
    "sym2real.report.data": ("data_remarks",),
    "sym2real.report.html.pages": ("write_diagnosis_page",),
    "sym2real.report.hypothesis": ("hypothesis_summary",),
    "sym2real.report.residuals": ("residual_lines",),
    "sym2real.report.summary": ("summary",),
    "sym2real.report.notebook": (
        *("log_plot", "adaptation_plot", "comparison_plot", "ladder_plot"),
        *("comparison_html", "diagnosis_html", "diagnosis_text", "hypothesis_html", "plan_html"),
    ),
}
OWNERS = {name: module for module, names in _OF.items() for name in names}


def upward(name: str) -> Callable[..., Result]:
    """The function of that name in the room that owns it."""
    function: Callable[..., Result] = getattr(import_module(OWNERS[name]), name)
    return function
