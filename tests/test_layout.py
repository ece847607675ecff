"""The manifold: group axioms, round trips, derivatives, and errors that help."""

import numpy as np
import pytest
import torch
from hypothesis import given, settings, strategies as st
from torch import Tensor

from sym2real import rotation
from sym2real.errors import ShapeError, UnknownNameError
from sym2real.field import Field
from sym2real.layout import Layout
from sym2real.registry import Registry

QUADROTOR = Layout.of(["x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz"])
CAR = Layout.of(["x", "y", "sin_yaw", "cos_yaw", "vx", "vy", "wz"])

vectors = st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3).map(lambda v: torch.tensor(v, dtype=torch.float64))
quaternions = vectors.map(rotation.exponential)


@given(quaternions, quaternions, vectors)
def test_quaternions_act_as_a_group_of_rotations(p: Tensor, q: Tensor, v: Tensor) -> None:
    once = rotation.rotate(p, rotation.rotate(q, v))
    torch.testing.assert_close(rotation.rotate(rotation.multiply(p, q), v), once)
    torch.testing.assert_close(rotation.rotate(rotation.conjugate(p), rotation.rotate(p, v)), v)
    torch.testing.assert_close(rotation.rotate(-p, v), rotation.rotate(p, v))
    torch.testing.assert_close(rotation.to_matrix(p) @ v, rotation.rotate(p, v))
    assert float(torch.linalg.det(rotation.to_matrix(p))) == pytest.approx(1.0)


@given(vectors)
def test_exponential_and_logarithm_are_inverse(v: Tensor) -> None:
    q = rotation.exponential(v)
    again = rotation.exponential(rotation.logarithm(q))
    assert float((q * again).sum().abs()) == pytest.approx(1.0, abs=1e-12)
    assert float(rotation.logarithm(q).norm()) <= np.pi + 1e-9


def test_logarithm_has_a_finite_gradient_at_identity() -> None:
    q = torch.tensor([1.0, 0.0, 0.0, 0.0], dtype=torch.float64, requires_grad=True)
    rotation.logarithm(q).sum().backward()
    assert q.grad is not None
    torch.testing.assert_close(q.grad[1:], torch.full((3,), 2.0, dtype=torch.float64))


@given(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_euler_angles_compose_as_their_matrices(roll: float, pitch: float, yaw: float) -> None:
    def about(axis: int, angle: float) -> np.ndarray:
        i, j = [(1, 2), (2, 0), (0, 1)][axis]
        matrix = np.eye(3)
        matrix[[i, j], [i, j]] = np.cos(angle)
        matrix[i, j], matrix[j, i] = -np.sin(angle), np.sin(angle)
        return matrix

    angles = [torch.tensor(angle, dtype=torch.float64) for angle in (roll, pitch, yaw)]
    q = rotation.from_euler(*angles)
    np.testing.assert_allclose(
        rotation.to_matrix(q).numpy(), about(2, yaw) @ about(1, pitch) @ about(0, roll), atol=1e-12
    )
    assert float(torch.cos(rotation.yaw(q) - yaw)) == pytest.approx(1.0, abs=1e-9)
    assert float(torch.cos(rotation.tilt(q))) == pytest.approx(np.cos(pitch) * np.cos(roll), abs=1e-9)


@pytest.mark.parametrize("layout", [QUADROTOR, CAR], ids=["quadrotor", "car"])
@settings(max_examples=30)
@given(seed=st.integers(0, 10_000))
def test_retract_undoes_difference(layout: Layout, seed: int) -> None:
    generator = torch.Generator().manual_seed(seed)
    start, end = (
        layout.normalise(torch.randn(4, layout.size, generator=generator, dtype=torch.float64)) for _ in range(2)
    )
    tangent = layout.difference(end, start)
    assert tangent.shape == (4, layout.tangent_size)
    reached = layout.retract(start, tangent)
    torch.testing.assert_close(layout.difference(reached, end), torch.zeros_like(tangent), atol=1e-7, rtol=0)
    torch.testing.assert_close(layout.normalise(reached), reached)


def test_difference_is_blind_to_the_sign_of_a_quaternion() -> None:
    state = QUADROTOR.normalise(torch.randn(13, dtype=torch.float64, generator=torch.Generator().manual_seed(1)))
    flipped = state.clone()
    flipped[QUADROTOR.slice("attitude")] *= -1
    torch.testing.assert_close(QUADROTOR.difference(flipped, state), torch.zeros(12, dtype=torch.float64))


@pytest.mark.parametrize("layout", [QUADROTOR, CAR], ids=["quadrotor", "car"])
def test_over_a_step_directions_are_halfway_and_all_else_is_held(layout: Layout) -> None:
    generator = torch.Generator().manual_seed(0)
    moves = 0.5 * torch.randn(5, layout.tangent_size, generator=generator, dtype=torch.float64)
    rows = layout.normalise(torch.randn(5, layout.size, generator=generator, dtype=torch.float64))
    rows = torch.cat([rows, layout.retract(rows, moves)]).reshape(2, 5, -1).transpose(0, 1).flatten(0, 1)
    acting, places = torch.as_tensor(layout.over_steps(rows.numpy())), layout.tangent_places
    before, behind = layout.difference(acting[::2], rows[::2]), layout.difference(rows[1::2], acting[::2])
    for field, place in zip(layout.fields, places, strict=True):
        turns = field.kind != "vector"
        torch.testing.assert_close(before[:, list(place)], turns * moves[:, list(place)] / 2)
        torch.testing.assert_close(behind[:, list(place)], (1 - turns / 2) * moves[:, list(place)])
    torch.testing.assert_close(acting[-1], rows[-1])


def test_standard_names_carry_units_and_kinds() -> None:
    assert QUADROTOR.units["wx"] == "rad/s"
    assert QUADROTOR.field("attitude").kind == "quaternion"
    assert [field.name for field in CAR.fields] == ["position", "heading", "velocity", "rate"]
    assert Layout.of(["my_sensor"]).fields == (Field("my_sensor", ("my_sensor",)),)


def test_wrong_names_are_answered_with_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match=r"'qx'.*known: .*qw"):
        QUADROTOR.index("qqx")
    with pytest.raises(UnknownNameError, match="did you mean 'crazyflie'"):
        Registry("robot", {"crazyflie": 1, "mushr": 2})["crazyfly"]


def test_layouts_refuse_what_cannot_be() -> None:
    with pytest.raises(ShapeError, match="more than once"):
        Layout.of(["x", "vx", "x"])
    with pytest.raises(ShapeError, match="expected 4 columns of a quaternion, found"):
        Layout.of(["qw", "qx"])
    with pytest.raises(ShapeError, match="expected 13 columns"):
        QUADROTOR.normalise(torch.zeros(12))
