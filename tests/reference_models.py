"""Models that the kernel's tests run: fixed equations with many sines, nominal ones, and ones with memory."""

from __future__ import annotations

from sym2real.effects import compose, effect
from sym2real.layout import Layout, Layouts
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.symbolic import Equations

# Physics with small terms such as regression leaves behind: nested sines, sines of unbounded and of bounded arguments.
FLYING = {
    "x": "x + 0.02*vx + 0.0004*sin((wx_cmd*wz_cmd + 2*wy - sin(vx) + 0.46)*cos(qz))",
    "y": "y + 0.02*vy - 0.0004*sin(sin(qy*sin(wz))*cos(vy))",
    "z": "z + 0.02*vz + 0.0087*thrust*sin(cos(qx**2 + qy**2 + 0.5))",
    "qw": "qw - 0.01*(qx*wx + qy*wy + qz*wz) + 0.0006*sin(cos(sin(cos(wx_cmd))) + 0.66)",
    "qx": "qx + 0.01*(qw*wx + qy*wz - qz*wy)",
    "qy": "qy + 0.01*(qw*wy - qx*wz + qz*wx) + 0.0006*sin(qw*qz*vx - cos(thrust)*cos(vy*cos(qw)))",
    "qz": "qz + 0.01*(qw*wz + qx*wy - qy*wx)",
    "vx": "vx + 1.4816*thrust*(qw*qy + qx*qz) - 0.006*sin(qw - 0.46*vx + wy*(vz + wz_cmd + sin(thrust)))",
    "vy": "vy + 1.4816*thrust*(qy*qz - qw*qx)",
    "vz": "vz + 0.7408*thrust*(1 - 2*qx**2 - 2*qy**2) - 0.1962 + 0.006*sin(cos(wx*(wy_cmd + cos(wz))))",
    "wx": "0.58*wx + 0.42*wx_cmd + 0.012*wy*wz + 0.02*sin(0.1*wz + sin(vz)*cos(wz_cmd + sin(qw)))",
    "wy": "0.58*wy + 0.42*wy_cmd - 0.012*wx*wz + 0.02*sin(cos(wx + cos(wy_cmd) + 0.3))",
    "wz": "0.7*wz + 0.3*wz_cmd - 0.02*sin(cos(wz)*cos(0.5*sin(wy_cmd)))",
}


def flying() -> Equations:
    """A quadrotor's equations with sines."""
    layouts = Layouts(CRAZYFLIE.layouts.state, CRAZYFLIE.layouts.action, Layout())
    return Equations.parse(layouts, FLYING, CRAZYFLIE.dt, robot="crazyflie")


def late(robot: Robot = MUSHR) -> Equations:
    """Nominal equations with every filter of commands: cut off, dropped, late by 1.5 periods, slowed, lagged; play."""
    base = robot.nominal()
    column = "steer" if robot is MUSHR else "wx_cmd"
    values = {
        f"limit:{column}": {"magnitude": 0.3},
        f"limit:{'speed' if robot is MUSHR else 'thrust'}": {"lower": 0.1, "upper": 0.35},
        "delay": {"value": 1.5 * robot.dt},
        f"lag:{column}": {"value": 0.6 * robot.dt},
        f"rate_limit:{column}": {"value": 3.0},
        f"dead_band:{column}": {"value": 0.04},
        f"dead_zone:{column}": {"value": 0.03},
    }
    return compose(base, [(effect(key, base), given) for key, given in values.items()])


def motor_lagged() -> Equations:
    """A quadrotor whose thrust is a hidden state."""
    base = CRAZYFLIE.nominal()
    return compose(base, [(effect("motor_lag", base), {"value": 0.04})])
