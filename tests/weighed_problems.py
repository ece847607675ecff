"""Problems of a diagnosis whose residuals are weighed by the sensors' noise and by disturbances of variance one."""

from __future__ import annotations

import torch

from sym2real.dataset import Dataset
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.estimate.whitening import Spread
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem


def weighed_problems(library: Library, data: Dataset) -> Problems:
    problem = Problem(library, data)
    spread = Spread.of(problem, library.null)
    variances = torch.as_tensor(problem.segments.noise).square(), torch.ones(len(spread.names), dtype=torch.float64)
    return Problems(problem, spread.whitening(*variances))
