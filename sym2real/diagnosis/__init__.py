"""Compare a model with measurements."""

from sym2real.diagnosis.compare import ChannelError, Comparison, HorizonErrors, compare
from sym2real.diagnosis.start import ROWS
from sym2real.diagnosis.windows import Windows, predict_windows

__all__ = ["ROWS", "ChannelError", "Comparison", "HorizonErrors", "Windows", "compare", "predict_windows"]
