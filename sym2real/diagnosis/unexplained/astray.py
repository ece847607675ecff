"""A model that is surely worse than that nothing changes, although disturbances explain every residual."""

from __future__ import annotations

from dataclasses import replace

from sym2real.diagnosis.errors.floor import Floor, floor_of_explained
from sym2real.diagnosis.errors.rungs import Stage
from sym2real.diagnosis.errors.sensor_noise import SensorNoise
from sym2real.diagnosis.score.scoring import Scored
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.leftover import MISFIT, Leftover


def worse_than_nothing(scored: Scored) -> tuple[Leftover, ...]:
    """Predictions that are worse than none, held against the noise that the logs themselves show."""
    nearest = min(scored.horizons, default=0.0)
    if not scored.stages or not scored.stages[-1].worse.get(nearest):
        return ()
    prepared, values = scored.result.prepared, scored.result.selection.fit.values
    still = replace(prepared.whitening, disturbances=dict.fromkeys(prepared.whitening.disturbances, 0.0))
    own = SensorNoise.of(prepared.scored)
    noise = floor_of_explained(prepared.library, prepared.scored, values, still, (nearest,), noise=own)
    return find_astray(scored.stages[-1], noise[0]) if noise else ()


def find_astray(stage: Stage, noise: Floor) -> tuple[Leftover, ...]:
    """What is left of a model that is surely worse than that nothing changes, and not by the sensors' noise.

    Disturbances that are as large as all that a model gets wrong explain every residual, and hide what is wrong.

    Args:
        stage: errors on held-out logs.
        noise: the floor that the sensors' noise alone makes, at the shortest horizon: there disturbances did least.
    """
    found, nearest = list[tuple[float, str]](), stage.nearest(noise.horizon)
    for channel in stage.worse.get(nearest, ()):
        error, (lowest, _) = stage.horizons[nearest][channel], noise.errors[channel]
        if error.low > SETTINGS.floor_known * lowest:
            found.append((error.value / max(lowest, 1e-12), channel))
    words = f"{noise.horizon:g} s ahead, which is worse than if nothing changed"
    return tuple(Leftover(MISFIT, channel, 1.0 - times**-2, words) for times, channel in sorted(found)[-1:])
