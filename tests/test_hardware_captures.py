"""Motion capture by the name of its kind: a topic of ROS sees the Crazyflie, as `motioncapture` and its mock do."""

import time
from threading import Event

import numpy as np
import pytest
from ros_peers import master, repeated, wait_for

from hardware.captures import capture_of
from hardware.crazyflie.laboratory import CrazyflieLaboratory
from hardware.fakes.crazyflie import FakeCrazyflie
from hardware.frame import Frame
from hardware.motion_capture import LaboratoryCapture
from hardware.ros1 import POSE, TRANSFORM, Message, Node
from hardware.ros1.capture import RosCapture, Topic
from sym2real.errors import UnknownNameError
from sym2real.robots import CRAZYFLIE


def test_the_crazyflie_is_seen_by_a_topic_of_ros() -> None:
    """By Vicon's bridge, y axis upward."""
    topic, half = "/vicon/cf1/cf1", np.sqrt(0.5)
    with FakeCrazyflie() as fake, master() as uri, Node("/vicon", uri, "127.0.0.1") as vicon:
        publisher = vicon.advertise(topic, TRANSFORM)

        def tell() -> None:
            x, y, z, *_ = fake.vehicle.seen().tolist()
            # The body's axes seen from axes that are turned by -90° about x.
            publisher.publish(Message(time.time(), "vicon", ("cf1",), (x, z, -y, -half, 0.0, 0.0, half)))

        settings = (f"master={uri}", "host=127.0.0.1")
        laboratory = CrazyflieLaboratory(
            uri=fake.uri, thrust_map="2025.02", capture="ros", settings=settings, axes=("x", "-z", "y")
        )
        with repeated(tell), laboratory.open(CRAZYFLIE.start, print, dry=True) as opened:
            opened.link.connect()
            reading = opened.link.state()
            np.testing.assert_allclose(reading.state[:3], fake.vehicle.state[:3], atol=0.01)
            assert reading.extra["capture_yaw"] == pytest.approx(0.0, abs=1e-6)
            wait_for(lambda: opened.link.state().ages["pose"] < 1.0)


def test_a_pose_that_is_told_again_with_its_stamp_is_none_of_now() -> None:
    """How a node that looks up transforms tells of a body that is lost: a car would drive on in the place it had."""
    seen_again = Event()
    with master() as uri, Node("/tells", uri, "127.0.0.1") as tells, Node("/hears", uri, "127.0.0.1") as hears:
        publisher, capture = tells.advertise("/pose", POSE), RosCapture(hears, Topic("/pose"))

        def tell() -> None:
            again = float(seen_again.is_set())
            publisher.publish(Message(5.0 + again, "", (), (1.0, 2.0, 0.5 + 0.001 * again, 0.0, 0.0, 0.0, 1.0)))

        with repeated(tell):
            capture.connect()
            first = capture.latest()
            time.sleep(0.2)
            assert capture.latest() is first
            seen_again.set()
            wait_for(lambda: capture.latest() is not first)


def test_a_kind_that_is_not_ros_is_the_librarys() -> None:
    with capture_of("mock", "cf1", {"frequency": "100"}, Frame()) as capture:
        assert isinstance(capture, LaboratoryCapture)


@pytest.mark.parametrize(("settings", "wrong"), [({"topics": "/a"}, "topic"), ({"type": "Pose"}, "PoseStamped")])
def test_what_ros_does_not_know_is_named(settings: dict[str, str], wrong: str) -> None:
    with pytest.raises(UnknownNameError, match=f"did you mean.*{wrong}"), capture_of("ros", "cf1", settings, Frame()):
        pass
