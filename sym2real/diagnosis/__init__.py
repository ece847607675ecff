"""Compare a model with measurements, and name the physical effect that it misses."""

from sym2real.diagnosis.adding import add as add, try_effect as try_effect
from sym2real.diagnosis.answer import Diagnosis as Diagnosis
from sym2real.diagnosis.data.start import ROWS as ROWS
from sym2real.diagnosis.data.windows import Windows as Windows, predict_windows as predict_windows
from sym2real.diagnosis.design.detectable import plan as plan
from sym2real.diagnosis.design.visible import AssumedNoise as AssumedNoise, Plan as Plan, Visible as Visible
from sym2real.diagnosis.errors.comparison import Comparison as Comparison, compare as compare
from sym2real.diagnosis.errors.floor import Floor as Floor
from sym2real.diagnosis.errors.regions import Segment as Segment, Where as Where, locate as locate
from sym2real.diagnosis.faults.fault import Fault as Fault
from sym2real.diagnosis.faults.report import data_report as data_report
from sym2real.diagnosis.pipeline import diagnose as diagnose
from sym2real.diagnosis.score.finding import Finding as Finding
from sym2real.diagnosis.score.held_out import Fall as Fall, Gate as Gate
from sym2real.diagnosis.score.hypothesis_test import HypothesisTest as HypothesisTest
from sym2real.diagnosis.search.intervals import Estimate as Estimate
from sym2real.diagnosis.unexplained.term import Term as Term
from sym2real.effects.written_term import add_term as add_term
