"""What a car's logs do not show as a mistake, although a transformation would mend them: drives of a car that slips."""

from __future__ import annotations

import numpy as np
import pytest

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.mistakes.balance import Balances
from sym2real.diagnosis.faults.mistakes.listed import transformations
from sym2real.diagnosis.faults.mistakes.transformation import Exchanged, Late, Transformation, Turned, of_all
from sym2real.diagnosis.faults.sanity import check
from sym2real.robots import car
from sym2real.trajectory import Trajectory
from sym2real.vocabulary import HEADING

WHEELBASE, LAG, FINE = 0.26, 0.06, 1e-3
BASE = car(WHEELBASE, time_constant=0.1, mass=3.0, dt=0.02)


def driven(
    seed: int,
    *,
    slip: float = 0.0,
    sign: float = 1.0,
    square: bool = False,
    held: float | None = None,
    rows: int = 600,
    late: float = 0.0,
) -> Trajectory:
    """The yaw rate follows the steering in 60 ms; the rear axle slips aside by so many rad s²/m of u ω.

    Args:
        sign: of the steering angle in the log.
        square: left and right in turn, at the limit.
        held: the steering angle where it never changes, in rad.
        late: how old place and heading are, in s.
    """
    rng, every = np.random.default_rng(seed), round(BASE.dt / FINE)
    x = y = yaw = speed = turn = 0.0
    states, told, poses = [], [], [(x, y, yaw)] * (round(late / FINE) + 1)
    for row in range(rows):
        if row % 30 == 0:
            steer = 0.4 * (-1.0) ** (row // 30) if square else rng.uniform(-0.35, 0.35) if held is None else held
        if row % 75 == 0:
            wanted = rng.uniform(0.5, 2.0)
        aside = yaw - slip * speed * turn
        states.append([*poses[-1 - round(late / FINE)], speed * np.cos(aside), speed * np.sin(aside), turn])
        told.append([sign * steer, wanted])
        for _ in range(every):
            speed += FINE / 0.1 * (wanted - speed)
            turn += FINE / LAG * (speed * np.tan(steer) / WHEELBASE - turn)
            yaw += FINE * turn
            aside = yaw - slip * speed * turn
            x, y = x + FINE * speed * np.cos(aside), y + FINE * speed * np.sin(aside)
            poses.append((x, y, yaw))
    noisy = np.array(states) + rng.normal(size=(rows, 6)) * [0.002, 0.002, 0.009, 0.03, 0.03, 0.02]
    turned = [np.sin(noisy[:, 2]), np.cos(noisy[:, 2])]
    state = np.column_stack([noisy[:, :2], *turned, noisy[:, 3:]])
    return Trajectory.from_arrays(state, np.array(told), BASE.layouts, dt=BASE.dt)


def test_no_sensor_reports_what_is_still_to_come() -> None:
    """An axle that slips moves as if the heading were early: the path alone would have it moved."""
    slipping = Dataset(driven(seed, slip=0.04) for seed in range(4))
    balances, moved = Balances.of(BASE, slipping), of_all(Late("heading", HEADING.columns, -3, BASE.dt), slipping)
    as_it_is, shifted = balances.inside(slipping), balances.inside(moved)
    assert shifted.losses.mean(0)[0] < 0.1 * as_it_is.losses.mean(0)[0]
    shifts = [one.rows for one in transformations(slipping, as_it_is) if isinstance(one, Late)]
    assert shifts and min(shifts) > 0
    assert check(BASE, slipping).faults == ()


@pytest.mark.parametrize("square", [False, True])
def test_a_reversed_angle_is_not_one_of_another_turn(square: bool) -> None:
    """14.7 times 0.4 rad are a turn less 0.4 rad, the tangent of which is that of the reversed angle."""
    checked = check(BASE, Dataset(driven(seed, sign=-1.0, square=square) for seed in range(3)))
    (fault,) = checked.faults
    assert fault.evidence.startswith("steer with the wrong sign")


@pytest.mark.parametrize("held", [0.15, 0.176, 0.2, 0.25])
def test_one_angle_with_an_offset_is_in_no_other_unit(held: float) -> None:
    """Of any angle a few thousand times as large has the tangent that the offset makes."""
    drives = [*(driven(seed) for seed in range(3)), driven(3, held=held + 0.05)]
    offset = Dataset(log.with_columns({"steer": log.column("steer") - 0.05}) for log in drives)
    assert check(BASE, offset).faults == ()


@pytest.mark.parametrize("mistake", [Turned("heading", np.pi / 2), Exchanged(("vx", "vy"), ("vy", "vx"), (1, 1))])
def test_no_drive_alone_has_another_unit_while_all_have_a_mistake(mistake: Transformation) -> None:
    """Of a short drive that steers little a turned frame looks like an angle that is far too small."""
    drives = [driven(seed, slip=0.01) for seed in range(2)]
    short = Dataset([log.rows(first, first + 60) for log in drives for first in range(0, 600, 60)][:12])
    (fault,) = check(BASE, of_all(mistake, short)).faults
    assert ("heading in a turned frame" if isinstance(mistake, Turned) else "vx vy swapped") in fault.evidence


@pytest.mark.parametrize("slip", [0.0, 0.04])
@pytest.mark.parametrize(("what", "columns"), [("heading", ()), ("pose", ("x", "y", "vx", "vy"))])
def test_a_place_with_velocities_of_its_own_is_late_with_its_heading(
    what: str, columns: tuple[str, ...], slip: float
) -> None:
    """As motion capture that derives them writes it, and not where a compass is late alone, although the car slips."""
    drives = [driven(seed, slip=slip) for seed in range(4)]
    early = Late(what, (*HEADING.columns, *columns), -5.0, BASE.dt)
    (fault,) = check(BASE, Dataset(early.undone(log).rows(6, len(log) - 6) for log in drives)).faults
    assert fault.evidence.startswith(f"{what} 5 rows late ({' '.join((*HEADING.columns, *columns))} by 100 ms)")


@pytest.mark.parametrize("rows", [2.5, 3.0, 4.5])
def test_a_late_pose_is_late_by_parts_of_a_row(rows: float) -> None:
    """In whole rows the rest would be a delay of commands and an arm."""
    checked = check(BASE, Dataset(driven(seed, late=rows * BASE.dt) for seed in range(4)))
    (fault,) = checked.faults
    assert fault.evidence.startswith(f"pose {rows:g} rows late (sin_yaw cos_yaw x y by {1e3 * rows * BASE.dt:.0f} ms)")
