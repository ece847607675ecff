"""ROS 2 through the interface of ROS 1: with rclpy two nodes of this machine, without it a recorded exchange."""

import importlib.util
import time
import warnings
from pathlib import Path

import numpy as np
import pytest
from recordings import POSE, write_bag
from ros2_replay import STAMPED, Replay
from ros_peers import wait_for

from hardware import ros1, ros2
from hardware.captures import capture_of
from hardware.errors import LinkError
from hardware.frame import Frame
from hardware.mushr.laboratory import MushrLaboratory
from hardware.mushr.link import COMMANDS
from hardware.ros2.messages import decoded, encoded
from sym2real.errors import MissingDependencyError, ModelError, UnknownNameError
from sym2real.robots import MUSHR

HERE = importlib.util.find_spec("rclpy") is not None
SPEED = 0.5  # m/s, of the recorded car along x


@pytest.fixture
def replay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Replay:
    """A car that drives straight on, as a bag."""
    if not HERE:
        warnings.warn("rclpy is not here: ROS 2 is a recorded exchange", stacklevel=1)
    at = np.arange(0.0, 20.0, 0.01)
    poses = {"t": at, "x": SPEED * at, "y": 0.0 * at, "yaw": 0.0 * at}
    commands = {"t": at[:2], "steer": at[:2], "speed": at[:2]}
    exchange = Replay(write_bag(tmp_path / "drive", 2, poses, commands))
    exchange.install(monkeypatch)
    return exchange


def test_a_car_on_ros_2_is_seen_and_told(replay: Replay) -> None:
    with MushrLaboratory(ros=2, poses=POSE).open(MUSHR.start, print) as opened:
        link = opened.link
        link.connect()
        link.arm()
        wait_for(lambda: abs(link.state().state[4] - SPEED) < 0.02)
        reading = link.state()
        assert not reading.flags
        np.testing.assert_allclose(reading.state[[1, 2, 3, 6]], [0.0, 0.0, 1.0, 0.0], atol=1e-6)
        sent = link.send([0.1, 0.1])
    told = [replay.store.deserialize_cdr(raw, STAMPED) for raw in replay.sent[COMMANDS]]
    assert (told[0].drive.steering_angle, told[0].drive.speed) == (0.0, 0.0)
    assert [told[1].drive.steering_angle, told[1].drive.speed] == pytest.approx(sent.tolist())
    assert abs(told[1].header.stamp.sec + 1e-9 * told[1].header.stamp.nanosec - time.time()) < 60.0
    assert all(one.drive.speed == 0.0 for one in told[2:]), "zeros on the way out"


def test_a_drone_is_seen_by_a_topic_of_ros_2(replay: Replay) -> None:
    settings = {"topic": POSE, "type": "PoseStamped"}
    with capture_of("ros2", "cf1", settings, Frame(("x", "-z", "y"))) as capture:
        capture.connect()
        pose = capture.latest()
        assert pose is not None
        np.testing.assert_allclose(pose.position[1:], 0.0, atol=1e-9)
    with (
        pytest.raises(UnknownNameError, match="setting of ros2 'master'"),
        capture_of("ros2", "cf1", {"master": "x"}, Frame()),
    ):
        pass


@pytest.mark.parametrize("kind", [ros1.POSE, ros1.TRANSFORM, ros1.ACKERMANN])
def test_messages_come_back_as_they_went(kind: ros1.MessageType, replay: Replay) -> None:
    numbers = tuple(0.125 * place for place in range(len(kind.fields)))
    message = ros1.Message(1_700_000_000.25, "map", tuple("a" for _ in kind.texts), numbers)
    assert decoded(kind, encoded(kind, message)) == message


def test_a_silent_topic_is_named(replay: Replay, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hardware.seen.FIRST_POSE", 0.2)
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    silent = capture_of("ros2", "cf1", {"topic": "/nowhere"}, Frame())
    with silent as capture, pytest.raises(LinkError, match=r"ROS 2, domain 7: no pose on /nowhere"):
        capture.connect()


@pytest.mark.skipif(HERE, reason="rclpy is installed: nothing is missing")
def test_without_rclpy_the_error_says_where_it_comes_from() -> None:
    with pytest.raises(MissingDependencyError, match="source /opt/ros"):
        ros2.Node("/sym2real")


@pytest.mark.skipif(not HERE, reason="rclpy is not here: the recorded exchange stands for it")
def test_two_real_nodes_exchange_poses() -> None:
    heard: list[ros1.Message] = []
    message = ros1.Message(1_700_000_000.25, "map", (), (1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0))
    with ros2.Node("/teller") as teller, ros2.Node("/hearer") as hearer:
        hearer.subscribe("/car/car_pose", ros1.POSE, heard.append)
        publisher = teller.advertise("/car/car_pose", ros1.POSE)
        wait_for(lambda: publisher.subscribers == 1)
        publisher.publish(message)
        wait_for(lambda: heard == [message])


def test_options_of_ros_1_are_refused() -> None:
    laboratory = MushrLaboratory(ros=2, sim=True)
    with pytest.raises(ModelError, match="--ros 2"), laboratory.open(MUSHR.start, print):
        pass
