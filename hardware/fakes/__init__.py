"""Peers to test against: a Crazyflie that answers on UDP, and motion capture that sees it."""
