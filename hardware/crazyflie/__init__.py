"""The Crazyflie: thrust map, set-point routes, telemetry, link."""
