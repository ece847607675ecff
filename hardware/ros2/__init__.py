"""ROS 2 through ``rclpy``, which a ROS installation brings: the same poses in, the same Ackermann commands out."""

from hardware.ros2.node import Node

__all__ = ["Node"]
