"""The firmware's Kalman filter, begun anew where motion capture sees the robot stand.

It has run since the robot was switched on, and what happened to the robot since then may have led it astray. cflib's
own ``reset_estimator`` does the same, but it prints, and it waits for ever where no log comes.
"""

import time
from collections import deque

from hardware.crazyflie.connection import Connection
from sym2real.trajectory import Array

KALMAN = {"stabilizer.estimator": 2}  # of the firmware's estimators the one that takes positions
RESET = "kalman.resetEstimation"
HELD = 0.1  # s, as in cflib
VARIANCES = {f"kalman.var{axis}": "float" for axis in "XYZ"}
PERIOD_MS, IN_A_ROW = 100, 10
SETTLED = 1e-3  # m²: 3 cm; cflib lets variances change by as much
SETTLING = 10.0  # s


def begin_anew(connection: Connection, place: Array) -> None:
    """Reset the filter of a robot that stands at a place ``# (3,)`` in m with its front along x, until it has settled.

    Raises:
        LinkError: for firmware without the filter, or where it does not settle in time.
    """
    start = dict(zip(("kalman.initialX", "kalman.initialY", "kalman.initialZ"), place.tolist(), strict=True))
    connection.set_parameters(KALMAN | start | {"kalman.initialYaw": 0.0, RESET: 1})
    time.sleep(HELD)
    connection.set_parameters({RESET: 0})
    seen: deque[float] = deque(maxlen=IN_A_ROW)
    end = connection.log(VARIANCES, PERIOD_MS, lambda _, values: seen.append(max(values.values())))
    connection.wait(
        lambda: len(seen) == IN_A_ROW and max(seen) < SETTLED, SETTLING, "settled estimate of its own position"
    )
    end()
