"""Peers to test against: a Crazyflie on UDP, a MuSHR car with its ROS master, and motion capture that sees them."""
