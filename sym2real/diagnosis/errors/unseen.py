"""How well a feature predicts what groups show that an estimator has not seen."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sym2real.trajectory import Array


def unseen_r2(estimator: Any, features: Array, targets: Array, groups: NDArray[np.int64], folds: int) -> Array:
    """R² of each target ``# (pieces, D)`` on groups left out, by an estimator of scikit-learn ``# (D,)``."""
    from sklearn.metrics import r2_score  # noqa: PLC0415 — heavy, and only needed at the end
    from sklearn.model_selection import GroupKFold, cross_val_predict  # noqa: PLC0415

    apart = GroupKFold(min(folds, len(np.unique(groups))))
    predicted = cross_val_predict(estimator, features, targets.squeeze(), groups=groups, cv=apart)
    shares: Array = r2_score(targets, predicted.reshape(targets.shape), multioutput="raw_values")
    return shares
