"""ROS 1 without ROS: a node on TCPROS from Python's standard library, for poses in and Ackermann commands out."""

from hardware.ros1.messages import ACKERMANN, POSE, TRANSFORM, Message, MessageType
from hardware.ros1.node import Node

__all__ = ["ACKERMANN", "POSE", "TRANSFORM", "Message", "MessageType", "Node"]
