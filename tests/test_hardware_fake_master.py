"""The master of --sim does for two nodes what roscore does."""

import pytest
from ros_peers import wait_for

from hardware.errors import LinkError
from hardware.fakes.master import FakeMaster
from hardware.ros1 import POSE, Message, Node

HERE = Message(0.0, "map", (), (1.0, *[0.0] * 5, 1.0))


@pytest.mark.parametrize("subscriber_first", [True, False])
def test_two_nodes_meet_whoever_comes_first(subscriber_first: bool) -> None:
    heard: list[Message] = []
    with FakeMaster() as master, Node("/a", master.uri) as a, Node("/b", master.uri) as b:
        if subscriber_first:
            b.subscribe("/pose", POSE, heard.append)
        publisher = a.advertise("/pose", POSE)
        if not subscriber_first:
            b.subscribe("/pose", POSE, heard.append)
        wait_for(lambda: publisher.subscribers == 1)
        publisher.publish(HERE)
        wait_for(lambda: bool(heard))
    assert heard == [HERE]


def test_a_publisher_that_leaves_is_forgotten_and_the_next_is_heard() -> None:
    heard: list[Message] = []
    with FakeMaster() as master, Node("/b", master.uri) as b:
        b.subscribe("/pose", POSE, heard.append)
        for count in (1, 2):
            with Node("/a", master.uri) as a:
                publisher = a.advertise("/pose", POSE)
                wait_for(lambda users=publisher: users.subscribers == 1)
                publisher.publish(HERE)
                wait_for(lambda least=count: len(heard) == least)


def test_what_it_does_not_know_is_refused_by_name() -> None:
    with FakeMaster() as master, Node("/a", master.uri) as node, pytest.raises(LinkError, match="getParam"):
        node._ask_master("getParam", "/use_sim_time")
