"""The standard set: what is measured, what varies, and that the label stays out of the data."""

import numpy as np
import pytest
import torch
from standard_set import DRIVES, FLIGHTS, Case, simulate_case

from sym2real.experiments.standard_conditions import ANGLE_NOISE, GYRO_NOISE, POSITION_NOISE, sensors
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.tasks.standard_paths import Manoeuvre, drive, flight

H = 1e-4


@pytest.mark.parametrize("manoeuvre", FLIGHTS, ids=str)
def test_flight_velocity_is_the_derivative_of_position(manoeuvre: Manoeuvre) -> None:
    reference, times = flight(manoeuvre, 1.0, 0.6), torch.linspace(0.1, 8.0, 60, dtype=torch.float64)
    here, ahead, before = reference(times), reference(times + H), reference(times - H)
    assert torch.allclose((ahead - before)[:, :3] / (2 * H), here[:, 7:10], atol=2e-3)
    assert torch.allclose(here[:, 3:7].norm(dim=-1), torch.ones(60, dtype=torch.float64))


@pytest.mark.parametrize("manoeuvre", DRIVES, ids=str)
def test_drive_points_along_its_velocity_at_its_speed(manoeuvre: Manoeuvre) -> None:
    reference, times = drive(manoeuvre, 2.0), torch.linspace(0.1, 20.0, 60, dtype=torch.float64)
    here, ahead, before = reference(times), reference(times + H), reference(times - H)
    assert torch.allclose((ahead - before)[:, :2] / (2 * H), here[:, 4:6], atol=5e-3)
    speed, modulation = here[:, 4:6].norm(dim=-1), manoeuvre.modulation
    assert torch.allclose(here[:, 4:6] / speed[:, None], here[:, [3, 2]], atol=1e-9)
    assert (abs(speed / manoeuvre.speed - 1.0) <= modulation + 1e-9).all()


@pytest.mark.parametrize("robot", [CRAZYFLIE, MUSHR], ids=lambda robot: robot.name)
def test_noise_has_the_stated_size_and_velocity_is_the_difference(robot: Robot) -> None:
    rows, layout = 4000, robot.layouts.state
    change = sensors(robot, np.random.default_rng(0))
    assert change.measure is not None
    measure = change.measure()
    measured = np.array([measure(robot.start) for _ in range(rows)])
    position, rate = measured[:, layout.slice("position")], measured[:, layout.slice("rate")]
    assert np.allclose(position.std(0), POSITION_NOISE, rtol=0.05)
    assert np.allclose(rate.std(0), GYRO_NOISE, rtol=0.05)
    start = torch.from_numpy(robot.start.copy())
    turned = layout.difference(torch.from_numpy(measured), start)
    angles = turned[:, 3:6] if layout.has_field("attitude") else turned[:, 2:3]
    assert np.allclose(angles.std(0), ANGLE_NOISE, rtol=0.05)
    differences = np.diff(position, axis=0) / robot.dt
    assert np.allclose(measured[1:, layout.slice("velocity")], differences)


def test_equal_seeds_give_equal_data_and_others_do_not() -> None:
    first, again, other = (simulate_case(Case("mushr", seed=seed), 1, 30)[0] for seed in (3, 3, 4))
    assert np.array_equal(first.state, again.state)
    assert np.array_equal(first.action, again.action)
    assert not np.array_equal(first.state, other.state)


def test_the_label_never_enters_the_data() -> None:
    case = Case("mushr", (("offset:steer", {"value": 0.1}),), seed=5)
    null = Case("mushr", (), seed=5)
    with_effect, without = (simulate_case(one, 2, 30) for one in (case, null))
    for a, b in zip(with_effect, without, strict=True):
        assert (a.name, a.notes, set(a.extra), set(a.raw)) == (b.name, b.notes, set(b.extra), set(b.raw))
        assert np.array_equal(a.inputs, np.zeros_like(a.inputs))


def test_a_flight_carries_the_added_mass_in_its_thrust() -> None:
    """The controller knows only the nominal mass; the integrator finds the rest before the log starts."""
    extra = 0.005
    flights = simulate_case(Case("crazyflie", (("added_mass", {"value": extra}),), seed=1), 1, 150)
    assert len(flights[0]) == 150
    weight = 9.81 * (CRAZYFLIE.mass + extra)
    assert flights[0].column("thrust").mean() == pytest.approx(weight, rel=0.02)
    assert abs(flights[0].column("z") - flights[0].column("ref_z")).max() < 0.1


def test_a_steering_offset_shows_in_the_turning_rate() -> None:
    """On the first circle the car turns as its wheels point, which is 0.1 rad from what was sent."""
    drives = simulate_case(Case("mushr", (("offset:steer", {"value": 0.1}),), seed=2), 1, 150)
    log = drives[0].rows(50, 150)
    speed = np.hypot(log.column("vx"), log.column("vy")).mean()
    pointed = np.arctan(MUSHR.numbers["wheelbase"] * log.column("wz").mean() / speed)
    assert pointed - log.column("steer").mean() == pytest.approx(0.1, abs=0.02)
