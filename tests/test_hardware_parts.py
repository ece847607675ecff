"""Frames of motion capture, velocity from stamps, and the sender that a blocked radio does not stop."""

import math
import threading

import numpy as np
import pytest
import torch
from hypothesis import given, strategies as st

from hardware.crazyflie.sender import NewestOnly
from hardware.frame import Frame
from hardware.velocity import LONGEST, Velocity
from sym2real.errors import ShapeError
from sym2real.rotation import rotate

FRAMES = (Frame(), Frame(("x", "-z", "y"), 0.7, (1.0, 2.0, 3.0)), Frame(("-y", "x", "z"), -2.0, scale=0.001))


@pytest.mark.parametrize("frame", FRAMES)
def test_a_body_turns_as_its_points_do(frame: Frame) -> None:
    """A marker on the body, moved by the system's pose and then to the world, is where the world's pose has it."""
    rng = np.random.default_rng(0)
    for _ in range(20):
        attitude, marker, place = rng.standard_normal(4), rng.standard_normal(3), rng.standard_normal(3)
        attitude /= np.linalg.norm(attitude)
        seen = place + rotate(torch.from_numpy(attitude), torch.from_numpy(marker)).numpy() / frame.scale
        world = rotate(torch.from_numpy(frame.attitude(attitude)), torch.from_numpy(marker)).numpy()
        assert frame.position(seen) == pytest.approx(frame.position(place) + world)


def test_an_axis_that_points_up_is_the_worlds_z() -> None:
    assert Frame(("x", "-z", "y")).position(np.array([0.0, 1.0, 0.0])) == pytest.approx([0.0, 0.0, 1.0])
    assert Frame(yaw=math.pi / 2).position(np.array([1.0, 0.0, 0.0])) == pytest.approx([0.0, 1.0, 0.0])


@pytest.mark.parametrize("axes", [("x", "y", "-z"), ("x", "x", "z"), ("x", "y", "up"), ("y", "x", "z")])
def test_axes_that_are_no_frame_are_refused(axes: tuple[str, str, str]) -> None:
    with pytest.raises(ShapeError, match="right-handed"):
        Frame(axes)


@given(st.lists(st.floats(0.005, 0.05), min_size=3, max_size=30), st.floats(-3.0, 3.0))
def test_a_constant_velocity_is_found_whatever_the_stamps(intervals: list[float], speed: float) -> None:
    velocity, time = Velocity(), 5.0
    for interval in intervals:
        time += interval
        found = velocity.add(time, np.array([speed * time, 0.0, -speed * time]))
    assert found == pytest.approx([speed, 0.0, -speed], abs=1e-6)


def test_no_velocity_from_one_position_a_gap_or_a_clock_that_goes_back() -> None:
    velocity = Velocity()
    assert np.isnan(velocity.add(1.0, np.zeros(3))).all()
    assert velocity.add(1.02, np.full(3, 0.02)) == pytest.approx([1.0] * 3)
    assert velocity.add(1.02, np.full(3, 9.0)) == pytest.approx([1.0] * 3)  # the same frame again
    assert np.isnan(velocity.add(1.03 + 2 * LONGEST, np.zeros(3))).all()
    assert velocity.add(1.05 + 2 * LONGEST, np.zeros(3)) == pytest.approx([0.0] * 3)
    assert np.isnan(velocity.add(0.5, np.zeros(3))).all()
    assert np.isnan(velocity.add(math.nan, np.zeros(3))).all()


def test_poses_that_waited_make_no_velocity() -> None:
    """A receiver that was held up for 0.25 s gets 25 poses 0.2 ms apart: the quotient was fifty times too large."""
    velocity, fall, found = Velocity(), np.array([0.0, 0.0, -0.5]), []
    captured = 0.01 * np.arange(70)
    arrived = np.where((captured > 0.2) & (captured < 0.45), 0.445 + 0.0002 * (np.arange(70) - 45), captured)
    for moment, stamp in zip(captured, arrived, strict=True):
        found.append(velocity.add(stamp, moment * fall)[2])
    known = [value for value in found if not np.isnan(value)]
    assert len(known) > 40
    assert np.min(known) > -0.7
    assert np.max(known) < -0.35


def test_a_blocked_radio_costs_old_packets_and_no_time() -> None:
    """While one is stuck, the newest of each kind waits; the more urgent goes first."""
    stuck, free, gone = threading.Event(), threading.Event(), []

    def block() -> None:
        stuck.set()
        free.wait()

    sender = NewestOnly("set-point", "position")
    sender.put("position", block)
    assert stuck.wait(10.0)
    for number in range(100):
        sender.put("position", lambda number=number: gone.append(("position", number)))
        sender.put("set-point", lambda number=number: gone.append(("set-point", number)))
    assert not sender.flush(0.01)
    assert not sender.flush(0.01, "position")
    sender.put_alone("position", lambda: gone.append(("position", 99)))
    assert sender.flush(0.01, "set-point"), "none waits, whatever the radio is busy with"
    sender.put("set-point", lambda: gone.append(("set-point", 99)))
    free.set()
    assert sender.flush(10.0)
    assert gone == [("set-point", 99), ("position", 99)]
    assert sender.replaced == 200
    sender.close()


def test_a_packet_that_cannot_be_sent_keeps_no_other_from_going(caplog: pytest.LogCaptureFixture) -> None:
    """The thread ended with it, and no set-point went out any more, the one that stops the motors neither."""
    sender, gone = NewestOnly("set-point", "position"), list[str]()
    sender.put("position", lambda: gone.append(str(1 / 0)))
    assert sender.flush(10.0)
    sender.put("set-point", lambda: gone.append("stop"))
    assert sender.flush(10.0)
    assert gone == ["stop"]
    assert "division by zero" in caplog.text
    sender.close()
