"""How well a model predicts: the work of its method of this name."""

from sym2real.dataset import Logs
from sym2real.diagnosis.data.preparation import long_enough
from sym2real.diagnosis.data.windows import rows_ahead
from sym2real.diagnosis.errors.skill import prediction_errors
from sym2real.effects.along_logs import prepared
from sym2real.protocols import DynamicsModel
from sym2real.symbolic import Equations


def score(whole: Equations | DynamicsModel, data: Logs, horizon: float) -> dict[str, float]:
    """See :meth:`~sym2real.Equations.score`."""
    model, logs = prepared(whole, long_enough(data, whole))
    (errors,) = prediction_errors(model, logs, [rows_ahead(horizon, logs.dt)], "smoothed", ())
    return {channel: error.fit for channel, error in errors.errors.items()}
