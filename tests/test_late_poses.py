"""What is measured late: a whole pose beside a gyro, an attitude alone, a place beside an attitude that is on time."""

from __future__ import annotations

import numpy as np
import pytest
from noisy_flights import flights, flights_with
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.mistakes.transformation import Late
from sym2real.diagnosis.faults.sanity import check
from sym2real.logs.sources import AsRead
from sym2real.robots import CRAZYFLIE, ROBOTS
from sym2real.vocabulary import ATTITUDE, EULER_ANGLES, POSITION, VELOCITY

POSE = (*ATTITUDE.columns, *POSITION.columns, *VELOCITY.columns)


def behind(data: Dataset, columns: tuple[str, ...], rows: int) -> Dataset:
    """Logs in which these columns stand so many rows late."""
    early = Late("", columns, -rows, data.dt)
    return Dataset(early.undone(log).rows(rows, len(log)) for log in data)


@pytest.mark.parametrize("rows", [2, 3])
@pytest.mark.parametrize(("what", "columns"), [("attitude", ATTITUDE.columns), ("pose", POSE)])
def test_the_place_is_late_with_its_attitude_where_thrust_says_so(
    what: str, columns: tuple[str, ...], rows: int
) -> None:
    checked = check(CRAZYFLIE.nominal(), behind(flights(), columns, rows))
    (fault,) = checked.faults
    assert fault.evidence.startswith(f"{what} {rows} rows late ({' '.join(columns)} by {20 * rows} ms)")
    for log, right in zip(checked.data, flights(), strict=True):
        meant, ends = right.rows(rows, len(right) - rows), slice(1, -1)
        assert len(log) == len(meant)  # what was not measured yet when the log ended is not made up
        places = log.layouts.state.indices((*ATTITUDE.columns, *POSITION.columns))
        np.testing.assert_allclose(log.state[ends, places], meant.state[ends, places], atol=1e-9)


@pytest.mark.parametrize(("what", "columns"), [("attitude", ATTITUDE.columns), ("pose", POSE)])
def test_a_drag_that_the_model_lacks_hides_no_late_place_and_makes_none(what: str, columns: tuple[str, ...]) -> None:
    """On a circle drag moves the velocity ahead by as much as the place is late."""
    dragged = flights_with("linear_drag", {"cx": 0.02, "cy": 0.02, "cz": 0.02})
    (fault,) = check(CRAZYFLIE.nominal(), behind(dragged, columns, 3)).faults
    assert fault.evidence.startswith(f"{what} 3 rows late")


def test_a_place_that_its_velocity_tells_is_late_with_its_attitude() -> None:
    """The velocity is of another sensor, on time."""
    (fault,) = check(CRAZYFLIE.nominal(), behind(flights(), (*ATTITUDE.columns, *POSITION.columns), 3)).faults
    assert fault.evidence.startswith(f"pose 2.5 rows late ({' '.join((*ATTITUDE.columns, *POSITION.columns))} by")


@pytest.mark.parametrize("rows", [7, 11])
def test_a_place_with_its_velocity_is_late_beside_an_attitude_on_time(rows: int) -> None:
    """As a satellite receiver's, whose place and velocity agree with each other."""
    flown = simulate_case(Case("crazyflie", (), seed=71))
    (fault,) = check(CRAZYFLIE.nominal(), behind(flown, (*POSITION.columns, *VELOCITY.columns), rows)).faults
    assert fault.evidence.startswith(f"place {rows} rows late (x y z vx vy vz by {20 * rows} ms)")


def test_a_car_that_slips_has_no_late_place() -> None:
    """The axle moves outwards of where the heading points, as if it came too late."""
    slipping = simulate_case(Case("mushr", (("tyre_slip", {"value": 0.05}),), seed=71), trajectories=4, rows=260)
    assert check(ROBOTS["mushr"].nominal(), slipping).faults == ()


def test_what_to_move_is_said_in_the_angles_of_the_log() -> None:
    """No file of angles has the quaternion that is made of them."""
    read = AsRead({name: f"log_{name}" for name in (*EULER_ANGLES, "x")})
    assert "move log_roll log_pitch log_yaw log_x 60 ms earlier" in Late("pose", POSE[:5], 6.0, 0.01).fix(read)
