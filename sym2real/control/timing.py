"""How many samples a machine can roll out within a control period, measured beforehand."""

import logging
import time
from collections.abc import Callable

LOGGER = logging.getLogger(__name__)

# Of the period. One action in a thousand takes twice its usual time where other machines share the processor, and the
# link, the filter and the log need a part too. With 0.7, 2 of 3000 periods were missed without a compiler.
SHARE = 0.45
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


def usual_seconds(solve: Callable[[int], object], samples: int) -> float:
    """Duration in s that ``solve(samples)`` exceeds only once in a dozen times, when it is warm."""
    durations = []
    for _ in range(WARM_UP + REPEATS):
        start = time.perf_counter()
        solve(samples)
        durations.append(time.perf_counter() - start)
    return sorted(durations[WARM_UP:])[-2]
