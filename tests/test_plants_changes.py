"""Changes and pushes against what mechanics says they do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from sym2real.effects import effect
from sym2real.plants import MujocoPlant
from sym2real.protocols import Change
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.robots.robot import GRAVITY
from sym2real.trajectory import Array

WIND, OFFSET = effect("wind", CRAZYFLIE), effect("com_offset", CRAZYFLIE)
HIGH = np.array([0, 0, 50.0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0])
INERTIA = np.array([CRAZYFLIE.numbers[name] for name in ("jx", "jy", "jz")])
GAINS = np.array([CRAZYFLIE.numbers[name] for name in ("kx", "ky", "kz")])


def fly(plant: MujocoPlant, steps: int = 50, push: Sequence[float] = (0.0,) * 6) -> Array:
    state = plant.reset(HIGH)
    plant.push(push)
    for _ in range(steps):
        state = plant.step(CRAZYFLIE.rest)
    return state


def test_a_constant_force_gives_its_acceleration() -> None:
    plant = MujocoPlant(
        CRAZYFLIE,
        [WIND.inject(fx=0.03, fy=-0.01, fz=0.02), WIND.inject(fx=0.01)],
    )
    expected = np.array([0.04, -0.01, 0.02]) / CRAZYFLIE.mass
    np.testing.assert_allclose(fly(plant)[7:10], expected, rtol=1e-6)


def test_tilted_gravity_accelerates_and_keeps_its_size() -> None:
    plant = MujocoPlant(CRAZYFLIE, [effect("slope", CRAZYFLIE).inject(gx=0.5, gy=-1.0)])
    np.testing.assert_allclose(fly(plant)[7:9], [0.5, -1.0], rtol=1e-6)
    assert np.linalg.norm(plant.mj_model.opt.gravity) == pytest.approx(GRAVITY)


def test_an_offset_of_the_centre_of_mass_turns_the_body_against_the_rate_loop() -> None:
    offset = np.array([0.002, -0.001, 0.003])
    plant = MujocoPlant(CRAZYFLIE, [OFFSET.inject(rx=offset[0], ry=offset[1], rz=offset[2])])
    state = plant.reset(HIGH)
    for _ in range(20):
        state = plant.step([0.3, 0.0, 0.0, 0.0])
    torque = -np.cross(offset, [0.0, 0.0, 0.3])
    # Steady rates where J K ω = τ; the gyroscopic rest is below a thousandth here.
    np.testing.assert_allclose(state[10:], torque / (INERTIA * GAINS), rtol=0.01, atol=2e-3)


def test_an_offset_leaves_mass_inertia_and_frame_alone() -> None:
    plain = MujocoPlant(CRAZYFLIE).mj_model
    moved = MujocoPlant(CRAZYFLIE, [OFFSET.inject(rx=0.002)]).mj_model
    assert moved.body_mass[1] == pytest.approx(plain.body_mass[1])
    np.testing.assert_allclose(moved.body_inertia[1], plain.body_inertia[1])
    np.testing.assert_allclose(moved.body_ipos[1] - plain.body_ipos[1], [0.002, 0.0, 0.0])
    np.testing.assert_allclose(moved.body_mass, plain.body_mass)
    # The car's wheels stay where they are, and its centre of mass is that of all.
    car, offset = (
        MujocoPlant(MUSHR, changes).mj_data.subtree_com[1].copy()
        for changes in ([], [effect("com_offset", MUSHR).inject(ry=0.01)])
    )
    np.testing.assert_allclose(offset - car, [0.0, 0.01, 0.0], atol=1e-9)


def test_velocity_is_that_of_the_frame_and_not_of_the_centre_of_mass() -> None:
    plant = MujocoPlant(CRAZYFLIE, [OFFSET.inject(rx=0.02)])
    start = HIGH.copy()
    start[12] = 4.0
    state = plant.reset(start)
    # A free body turns about its centre of mass, 2 cm ahead: the origin is pulled towards it with ω² r.
    before = state[7:10]
    plant.mj_model.actuator_gainprm[:] = plant.mj_model.actuator_biasprm[:] = 0.0
    state = plant.step([0.0, 0.0, 0.0, 0.0])
    assert (state[7] - before[0]) / CRAZYFLIE.dt == pytest.approx(16.0 * 0.02, rel=0.01)


def test_a_pushed_force_is_held_in_world_axes_until_it_is_changed() -> None:
    plant = MujocoPlant(CRAZYFLIE)
    plant.reset(HIGH)
    plant.push([0.0, 0.027, 0.0, 0.0, 0.0, 0.0])
    np.testing.assert_array_equal(plant.inputs, [0.0, 0.027, 0.0, 0.0, 0.0, 0.0])
    for _ in range(25):
        state = plant.step([CRAZYFLIE.rest[0], 0.0, 0.0, 4.0])
    assert state[8] == pytest.approx(0.5, rel=1e-6)
    plant.push(np.zeros(6))
    for _ in range(25):
        state = plant.step([CRAZYFLIE.rest[0], 0.0, 0.0, 4.0])
    assert state[8] == pytest.approx(0.5, rel=1e-6)
    plant.reset(HIGH)
    assert not plant.inputs.any()


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_pushed_torque_turns_about_the_body_axis(axis: int) -> None:
    plant = MujocoPlant(CRAZYFLIE)
    start = HIGH.copy()
    start[3:7] = [0.5, 0.5, 0.5, 0.5]
    plant.reset(start)
    wrench = np.zeros(6)
    wrench[3 + axis] = 1e-3
    plant.push(wrench)
    for _ in range(30):
        state = plant.step(CRAZYFLIE.rest)
    expected = np.zeros(3)
    expected[axis] = 1e-3 / (INERTIA[axis] * GAINS[axis])
    np.testing.assert_allclose(state[10:], expected, atol=1e-3)


def test_pushes_and_changes_add_up() -> None:
    plant = MujocoPlant(CRAZYFLIE, [WIND.inject(fx=0.027)])
    assert fly(plant, push=[0.027, 0.0, 0.0, 0.0, 0.0, 0.0])[7] == pytest.approx(2.0, rel=1e-6)


def test_the_slope_drags_a_car_that_holds_speed_zero() -> None:
    """The wheels' speed loop gives 4 k_v / r² = 32 N per m/s, which is what holds the car against the slope."""
    pull = 2.0 / MUSHR.mass
    plant = MujocoPlant(MUSHR, [effect("slope", MUSHR).inject(gx=pull)])
    pushed = MujocoPlant(MUSHR)
    pushed.push([2.0, 0.0, 0.0])
    for one in (plant, pushed):
        for _ in range(60):
            state = one.step([0.0, 0.0])
        assert state[4] == pytest.approx(2.0 / 32.0, rel=0.05)


def test_filters_of_commands_and_measurements_start_anew_with_every_reset() -> None:
    def delay() -> object:
        kept = [np.array(CRAZYFLIE.rest)]

        def shift(action: Array) -> Array:
            kept.append(action)
            return kept.pop(0)

        return shift

    late = Change("one step late", command=delay)  # type: ignore[arg-type]
    biased = Change("bias", measure=lambda: lambda state: state + np.eye(13)[2])
    plant, plain = MujocoPlant(CRAZYFLIE, [late, biased]), MujocoPlant(CRAZYFLIE)
    action = np.array([0.4, 1.0, 0.0, 0.0])
    for _ in range(2):
        assert plant.reset(HIGH)[2] == 51.0
        plain.reset(HIGH)
        expected = [plain.step(CRAZYFLIE.rest), plain.step(action)]
        got = [plant.step(action), plant.step(action)]
        np.testing.assert_allclose(np.array(got) - np.array(expected), np.eye(13)[[2, 2]], atol=1e-12)
    np.testing.assert_allclose(plant.true_state, expected[1])


def test_force_callbacks_see_the_present_and_not_the_last_step() -> None:
    seen: list[tuple[Array, Array]] = []

    def watch(model: object, data: object) -> None:
        seen.append((np.array(data.xpos[1]), np.array(data.qpos[:3])))  # type: ignore[attr-defined]

    plant = MujocoPlant(CRAZYFLIE, [Change("watch", force=watch)])
    start = HIGH.copy()
    start[7] = 3.0
    plant.reset(start)
    plant.step(CRAZYFLIE.rest)
    assert len(seen) == 10
    np.testing.assert_allclose(*zip(*seen, strict=True), atol=1e-12)


def test_edits_of_the_description_are_compiled_in() -> None:
    def heavier(spec: object) -> None:
        spec.worldbody.first_body().mass = 0.04  # type: ignore[attr-defined]

    plant = MujocoPlant(CRAZYFLIE, [Change("heavier", edit=heavier)])
    assert fly(plant, 50)[9] == pytest.approx(GRAVITY * (0.027 / 0.04 - 1.0), rel=1e-6)
    assert MujocoPlant(replace(CRAZYFLIE)).mj_model.body_mass[1] == 0.027
