"""The ROS 1 node beside real ROS: rosmaster, rospy, rosbag; and beside peers that misbehave."""

import contextlib
import socket
import struct
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st
from ros_peers import PATIENCE, master, rospy_script, wait_for
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from hardware.errors import LinkError
from hardware.ros1 import ACKERMANN, POSE, TRANSFORM, Message, MessageType, Node
from sym2real.logs import LogSpec, read_log

TYPES = (POSE, TRANSFORM, ACKERMANN)
RATE = 20.0  # Hz
COUNT = 40

ECHO = """
import rospy
from geometry_msgs.msg import PoseStamped, TransformStamped
rospy.init_node("echo", disable_signals=True)
out = rospy.Publisher("/back", TransformStamped, queue_size=100)
def heard(pose):
    back = TransformStamped(header=pose.header, child_frame_id="car")
    back.transform.translation.x = pose.pose.position.x
    back.transform.rotation.w = pose.pose.orientation.w
    out.publish(back)
rospy.Subscriber("/pose", PoseStamped, heard, queue_size=100)
print("ready")
rospy.spin()
"""


@pytest.fixture(scope="module")
def uri() -> Iterator[str]:
    with master() as address:
        yield address


def a_pose(stamp: float, x: float) -> Message:
    return Message(stamp, "map", (), (x, 2.0, 0.5, 0.0, 0.0, 0.6, 0.8))


@pytest.mark.parametrize("kind", TYPES, ids=lambda kind: kind.name)
def test_definitions_and_sums_are_those_of_ros(kind: MessageType) -> None:
    store = get_typestore(Stores.ROS1_NOETIC)
    drive = "".join(f"float32 {field}\n" for field in ACKERMANN.fields)
    store.register(get_types_from_msg(drive, "ackermann_msgs/msg/AckermannDrive"))
    stamped = "std_msgs/Header header\nAckermannDrive drive"
    store.register(get_types_from_msg(stamped, "ackermann_msgs/msg/AckermannDriveStamped"))
    definition, md5sum = store.generate_msgdef(kind.name.replace("/", "/msg/"))
    assert (kind.definition.strip(), kind.md5sum) == (definition.strip(), md5sum)


@given(
    st.integers(0, 2**32 - 1),
    st.integers(0, 10**9 - 1),
    st.text(max_size=20),
    st.lists(st.floats(width=32), max_size=7),
)
def test_messages_come_back_as_they_went(seconds: int, nanoseconds: int, frame: str, values: list[float]) -> None:
    for kind in TYPES:
        numbers = tuple((values + [0.0] * 7)[: len(kind.fields)])
        message = Message(seconds + nanoseconds / 1e9, frame, tuple("a" for _ in kind.texts), numbers)
        back = kind.decode(kind.encode(message))
        assert back.stamp == pytest.approx(message.stamp, abs=1e-6)
        assert (back.frame, back.texts) == (message.frame, message.texts)
        np.testing.assert_array_equal(back.numbers, numbers)


@given(st.binary(max_size=120))
def test_bytes_that_are_no_message_are_refused(data: bytes) -> None:
    for kind in TYPES:
        try:
            message = kind.decode(data)
        except LinkError:
            continue
        assert kind.encode(message)[4:12] == data[4:12]


def test_rospy_hears_us_and_is_heard(uri: str) -> None:
    """Poses go to rospy's echo and come back as transforms, each with its stamp and its numbers."""
    heard: list[Message] = []
    echo = rospy_script(uri, ECHO)
    try:
        assert echo.stdout is not None and echo.stdout.readline().strip() == "ready"
        with Node("/here", uri, "127.0.0.1") as node:
            node.subscribe("/back", TRANSFORM, heard.append)
            poses = node.advertise("/pose", POSE)
            wait_for(lambda: poses.subscribers == 1)
            start = 1_700_000_000.25
            for number in range(COUNT):
                poses.publish(a_pose(start + number, float(number)))
                wait_for(lambda sent=number: len(heard) > sent)
    finally:
        echo.kill()
        echo.wait(PATIENCE)
    assert [message.numbers[0] for message in heard] == [float(number) for number in range(COUNT)]
    np.testing.assert_allclose([message.stamp for message in heard], start + np.arange(COUNT), atol=1e-6)
    assert {(message.frame, message.texts, message.numbers[6]) for message in heard} == {("map", ("car",), 0.8)}


PUBLISH = """
import sys
import rospy
from geometry_msgs.msg import PoseStamped
rospy.init_node("cameras", disable_signals=True)
out = rospy.Publisher("/pose", PoseStamped, queue_size=1)
while out.get_num_connections() == 0:
    rospy.sleep(0.01)
sequence = 0
while not rospy.is_shutdown():
    sequence += 1
    pose = PoseStamped()
    pose.header.stamp = rospy.Time.from_sec(1.7e9 + sequence)
    pose.pose.position.x = sequence
    out.publish(pose)
    rospy.sleep(0.01)
"""


def test_a_publisher_that_dies_is_left_and_one_that_comes_is_heard(uri: str) -> None:
    heard: list[Message] = []
    with Node("/here", uri, "127.0.0.1") as node:
        node.subscribe("/pose", POSE, heard.append)
        for _ in range(2):
            cameras = rospy_script(uri, PUBLISH)
            enough = len(heard) + 5
            wait_for(lambda least=enough: len(heard) > least)
            cameras.kill()
            cameras.wait(PATIENCE)
    numbers = [message.numbers[0] for message in heard]
    assert numbers.count(1.0) <= 2
    assert np.all(np.diff(numbers) != 0)
    silent = len(heard)
    time.sleep(0.1)
    assert len(heard) == silent, "a node that is closed hears nothing"


def test_the_real_bag_recorder_keeps_what_we_send(uri: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What `rosbag record` wrote opens as a log, definitions and all; it ends when it has as many messages."""
    import shutil
    import subprocess

    from ros_peers import environment

    if shutil.which("rosbag") is None:
        pytest.skip("rosbag is not here: apt-get install --no-install-recommends python3-rosbag")
    bag = tmp_path / "drive.bag"
    command = ["rosbag", "record", "-l", str(COUNT), "-O", str(bag), "/car/pose", "/car/command"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    recorder = subprocess.Popen(command, env=environment(uri), **quiet)
    with Node("/here", uri, "127.0.0.1") as node:
        poses, commands = node.advertise("/car/pose", POSE), node.advertise("/car/command", ACKERMANN)
        wait_for(lambda: poses.subscribers == commands.subscribers == 1)
        start = time.time()
        for number in range(COUNT):
            stamp = start + number / RATE
            poses.publish(a_pose(stamp, 0.1 * number))
            commands.publish(Message(stamp, "", (), (0.01 * number, 0.0, 1.0, 0.0, 0.0)))
            wait_for(lambda: not any(one._waiting for topic in (poses, commands) for one in topic._subscribers))
        recorder.wait(PATIENCE)
    monkeypatch.setattr("sym2real.logs.recordings.ros.CLOCKS_AGREE", PATIENCE)  # a busy recorder is late
    spec = LogSpec.parse(
        '[columns]\nx = "/car/pose.pose.position.x"\ny = "/car/pose.pose.position.y"\n'
        'steer = "/car/command.drive.steering_angle"\nspeed = "/car/command.drive.speed"\n'
    )
    log = read_log(bag, spec)
    assert len(log) == COUNT
    np.testing.assert_allclose(np.diff(log.column("x")), 0.1, atol=1e-9)
    np.testing.assert_allclose(log.action[:, 1], 1.0)


def test_the_newest_command_is_sent_and_a_slow_subscriber_delays_nobody(uri: str) -> None:
    """A peer that connects and never reads fills its socket; another still hears the last message at once."""
    heard: list[Message] = []
    with Node("/here", uri, "127.0.0.1") as node, Node("/there", uri, "127.0.0.1") as other:
        commands = node.advertise("/command", ACKERMANN)
        stuck = subscriber_socket(node, "/command")
        other.subscribe("/command", ACKERMANN, heard.append)
        wait_for(lambda: commands.subscribers == 2)
        last = 20_000
        for number in range(last + 1):
            commands.publish(Message(0.0, "", (), (float(number), 0.0, 0.0, 0.0, 0.0)))
        wait_for(lambda: bool(heard) and heard[-1].numbers[0] == last)
        stuck.close()
    assert [m.numbers[0] for m in heard] == sorted(m.numbers[0] for m in heard)


def subscriber_socket(node: Node, topic: str, md5sum: str = "*") -> socket.socket:
    """A bare TCPROS subscriber."""
    _, host, port = node.request_topic(topic)
    connection = socket.create_connection((host, port))
    fields = [
        f"{key}={value}".encode() for key, value in {"topic": topic, "md5sum": md5sum, "callerid": "/raw"}.items()
    ]
    content = b"".join(struct.pack("<I", len(field)) + field for field in fields)
    connection.sendall(struct.pack("<I", len(content)) + content)
    return connection


def test_messages_of_another_type_are_refused_with_both_names(uri: str, caplog: pytest.LogCaptureFixture) -> None:
    heard: list[Message] = []
    with Node("/here", uri, "127.0.0.1") as node, Node("/there", uri, "127.0.0.1") as other:
        node.advertise("/pose", POSE)
        other.subscribe("/pose", TRANSFORM, heard.append)
        wait_for(lambda: "md5sum" in caplog.text)
    assert "expected geometry_msgs/TransformStamped, found /pose is geometry_msgs/PoseStamped" in caplog.text
    assert heard == []


def test_what_waits_is_sent_before_a_node_closes(uri: str) -> None:
    """A car's zeros must not be lost with the program that ends."""
    heard: list[Message] = []
    for _ in range(10):
        heard.clear()
        with Node("/there", uri, "127.0.0.1") as other:
            with Node("/here", uri, "127.0.0.1") as node:
                commands = node.advertise("/command", ACKERMANN)
                other.subscribe("/command", ACKERMANN, heard.append)
                wait_for(lambda publisher=commands: publisher.subscribers == 1)
                commands.publish(Message(0.0, "", (), (1.0,) * 5))
                commands.publish(Message(0.0, "", (), (0.0,) * 5))
            wait_for(lambda: bool(heard) and heard[-1].numbers == (0.0,) * 5)


def test_a_connection_that_breaks_is_made_again(uri: str, caplog: pytest.LogCaptureFixture) -> None:
    """One reset of a pose connection silenced the poses for good, while the publisher went on."""
    heard: list[Message] = []
    with Node("/here", uri, "127.0.0.1") as node, Node("/there", uri, "127.0.0.1") as other:
        poses = node.advertise("/pose", POSE)
        other.subscribe("/pose", POSE, heard.append)
        for _ in range(3):
            known = len(heard)
            wait_for(lambda known=known: len(heard) > known, lambda: poses.publish(a_pose(0.0, 1.0)))
            for subscriber in list(poses._subscribers):
                subscriber._connection.shutdown(socket.SHUT_RDWR)
    assert "the other side closed" in caplog.text


@pytest.mark.parametrize(
    "reply", [b"", b"nonsense", struct.pack("<I", 2**31), struct.pack("<I", 6) + b"\xff\xff\xff\xffab"]
)
def test_a_peer_that_talks_nonsense_is_left(uri: str, reply: bytes, caplog: pytest.LogCaptureFixture) -> None:
    with Node("/here", uri, "127.0.0.1") as node:
        publisher = node.advertise("/pose", POSE)
        _, host, port = node.request_topic("/pose")
        with socket.create_connection((host, port)) as peer:
            peer.sendall(reply)
            with contextlib.suppress(OSError):  # it may have left at the first bytes
                peer.shutdown(socket.SHUT_WR)
            peer.settimeout(PATIENCE)
            with contextlib.suppress(ConnectionResetError):
                while peer.recv(100):
                    pass
        assert publisher.subscribers == 0
        publisher.publish(a_pose(0.0, 1.0))  # goes nowhere, and harms nothing


def test_without_a_master_the_error_names_its_address() -> None:
    with pytest.raises(LinkError, match=r"http://127\.0\.0\.1:1 does not answer.*is roscore running.*ROS_MASTER_URI"):
        Node("/here", "http://127.0.0.1:1", "127.0.0.1")


def test_a_master_that_never_answers_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hardware.ros1.rpc.ANSWER", 0.2)
    with socket.create_server(("127.0.0.1", 0)) as silent, pytest.raises(LinkError, match="does not answer getPid"):
        Node("/here", f"http://127.0.0.1:{silent.getsockname()[1]}", "127.0.0.1")


def test_no_thread_of_a_node_stays(uri: str) -> None:
    before = threading.active_count()
    for _ in range(5):
        with Node("/here", uri, "127.0.0.1") as node:
            node.advertise("/pose", POSE)
            node.subscribe("/pose", POSE, lambda _: None)
    wait_for(lambda: threading.active_count() <= before)
