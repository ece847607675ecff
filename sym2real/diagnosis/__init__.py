"""Compare a model with measurements, and name the physical effect that it misses."""

from sym2real.diagnosis.compare import ChannelError, Comparison, HorizonErrors, compare
from sym2real.diagnosis.diagnose import Diagnosis, diagnose
from sym2real.diagnosis.findings import Estimate, Finding
from sym2real.diagnosis.start import ROWS
from sym2real.diagnosis.windows import Windows, predict_windows

__all__ = [
    "ROWS",
    "ChannelError",
    "Comparison",
    "Diagnosis",
    "Estimate",
    "Finding",
    "HorizonErrors",
    "Windows",
    "compare",
    "diagnose",
    "predict_windows",
]
