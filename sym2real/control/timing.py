"""How many samples a machine can roll out within a control period: tried beforehand, and watched while it runs."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

LOGGER = logging.getLogger(__name__)

# Of the period. One action in a thousand takes twice its usual time where other machines share the processor, and the
# link, the filter and the log need a part too. With 0.7, 2 of 3000 periods were missed without a compiler.
SHARE = 0.45
WAITING = 0.5  # of the period; an action that leaves less for waiting should work less once it has missed one
LEAST = 16  # samples below which a weighted mean of rollouts is no controller
WARM_UP, REPEATS = 3, 12  # TorchScript specialises during its first calls


def samples_within(period: float, samples: int, solve: Callable[[int], object]) -> int:
    """The most samples, by halving, for which ``solve(samples)`` takes less than a share of the period in s.

    What was lowered, or that even the least number does not hold the period, is said as a warning of the log.
    """
    wanted = samples
    seconds = usual_seconds(solve, samples)
    while seconds > SHARE * period and samples > LEAST:
        samples = max(LEAST, samples // 2)
        seconds = usual_seconds(solve, samples)
    if samples < wanted:
        LOGGER.warning(
            "MPPI: %d samples instead of %d, to act within a period of %.1f ms (%.1f ms an action)",
            samples, wanted, 1e3 * period, 1e3 * seconds,
        )  # fmt: skip
    if seconds > SHARE * period:
        LOGGER.warning("MPPI: the period of %.1f ms is not held: %.1f ms an action", 1e3 * period, 1e3 * seconds)
    return samples


def warm(samples: int, solve: Callable[[int], object]) -> None:
    """Solve with every number of samples that :func:`fewer` may come to, until it is as fast as it gets."""
    while samples > LEAST:
        samples = max(LEAST, samples // 2)
        for _ in range(WARM_UP):
            solve(samples)


def fewer(samples: int, worked: float, period: float) -> int:
    """Half the samples after a missed period, and a warning, where the action itself worked too long for it.

    Args:
        samples: of the action that missed its period.
        worked: s of processor time that it took; an action that waited for a processor gains nothing by fewer samples.
        period: s.
    """
    if worked <= WAITING * period or samples <= LEAST:
        return samples
    LOGGER.warning(
        "MPPI: %d samples from now on: an action worked %.1f ms of a period of %.1f ms, and missed it",
        max(LEAST, samples // 2), 1e3 * worked, 1e3 * period,
    )  # fmt: skip
    return max(LEAST, samples // 2)


def usual_seconds(solve: Callable[[int], object], samples: int) -> float:
    """Duration in s that ``solve(samples)`` exceeds only once in a dozen times, when it is warm."""
    durations = []
    for _ in range(WARM_UP + REPEATS):
        start = time.perf_counter()
        solve(samples)
        durations.append(time.perf_counter() - start)
    return sorted(durations[WARM_UP:])[-2]
