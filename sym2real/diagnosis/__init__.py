"""Compare a model with measurements, and name the physical effect that it misses."""

from sym2real.diagnosis.adding import add, try_effect
from sym2real.diagnosis.compare import Comparison, compare
from sym2real.diagnosis.data_report import DataReport, data_report
from sym2real.diagnosis.diagnose import Diagnosis, diagnose
from sym2real.diagnosis.findings import Estimate, Finding
from sym2real.diagnosis.floor import Floor
from sym2real.diagnosis.held_out import Fall, Gate
from sym2real.diagnosis.locate import (
    Segment,
    Where,
    locate,
    training_region,
    where_of,
    worst_segments,
)
from sym2real.diagnosis.one_step import one_step_residuals
from sym2real.diagnosis.plan import plan
from sym2real.diagnosis.prediction_errors import ChannelError, HorizonErrors
from sym2real.diagnosis.residuals import Residuals
from sym2real.diagnosis.sanity import Fault
from sym2real.diagnosis.start import ROWS
from sym2real.diagnosis.term import Term, add_term
from sym2real.diagnosis.tried import Rival, Tried
from sym2real.diagnosis.visible import AssumedNoise, Plan, Visible
from sym2real.diagnosis.window_errors import WindowErrors, window_errors
from sym2real.diagnosis.windows import Windows, predict_windows

__all__ = [
    "ROWS",
    "AssumedNoise",
    "ChannelError",
    "Comparison",
    "DataReport",
    "Diagnosis",
    "Estimate",
    "Fall",
    "Fault",
    "Finding",
    "Floor",
    "Gate",
    "HorizonErrors",
    "Plan",
    "Residuals",
    "Rival",
    "Segment",
    "Term",
    "Tried",
    "Visible",
    "Where",
    "WindowErrors",
    "Windows",
    "add",
    "add_term",
    "compare",
    "data_report",
    "diagnose",
    "locate",
    "one_step_residuals",
    "plan",
    "predict_windows",
    "training_region",
    "try_effect",
    "where_of",
    "window_errors",
    "worst_segments",
]
