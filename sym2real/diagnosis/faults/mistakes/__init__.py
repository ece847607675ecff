"""Mistakes of a user: what was done to a log without wishing to, as transformations that one test judges alike."""

from sym2real.diagnosis.faults.mistakes.judge import Undoing, mistakes
from sym2real.diagnosis.faults.mistakes.rows import BadRows, bad_rows

__all__ = ["BadRows", "Undoing", "bad_rows", "mistakes"]
