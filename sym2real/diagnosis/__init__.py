"""Compare a model with measurements, and name the physical effect that it misses."""

from sym2real.diagnosis.adding import add, try_effect
from sym2real.diagnosis.answer import Diagnosis
from sym2real.diagnosis.data.start import ROWS
from sym2real.diagnosis.data.windows import Windows, predict_windows
from sym2real.diagnosis.design.detectable import plan
from sym2real.diagnosis.design.visible import AssumedNoise, Plan, Visible
from sym2real.diagnosis.errors.by_window import WindowErrors, window_errors
from sym2real.diagnosis.errors.comparison import Comparison, compare
from sym2real.diagnosis.errors.floor import Floor
from sym2real.diagnosis.errors.one_step import one_step_residuals
from sym2real.diagnosis.errors.regions import Segment, Where, locate, training_region, where_of, worst_segments
from sym2real.diagnosis.errors.residuals import Residuals
from sym2real.diagnosis.errors.skill import ChannelError, HorizonErrors
from sym2real.diagnosis.faults.fault import Fault
from sym2real.diagnosis.faults.report import DataReport, data_report
from sym2real.diagnosis.pipeline import diagnose
from sym2real.diagnosis.score.finding import Finding
from sym2real.diagnosis.score.held_out import Fall, Gate
from sym2real.diagnosis.score.intervals import Estimate
from sym2real.diagnosis.score.tried import Rival, Tried
from sym2real.diagnosis.unexplained.term import Term, add_term

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
