"""Crazyflie 2.1: thrust and body rates commanded, a proportional rate loop on board.

Mass and inertia: J. Förster, "System Identification of the Crazyflie 2.0 Nano Quadrocopter", ETH 2015, as rounded
by the paper this package follows.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sym2real.layout import Layout, Layouts
from sym2real.robots.description import Coordinates, Description
from sym2real.robots.recipe import Recipe
from sym2real.robots.robot import GRAVITY, Limits, MPPISettings, Robot
from sym2real.vocabulary import RATE, RATE_COMMAND, THRUST_COLUMN, VELOCITY, WRENCH

if TYPE_CHECKING:
    from sym2real.symbolic import Equations

MASS = 0.027  # kg
INERTIA = (1.66e-5, 1.67e-5, 2.93e-5)  # kg m²
RATE_GAINS = (50.0, 50.0, 20.0)  # 1/s
RATE_LIMITS = (8.0, 8.0, 4.0)  # rad/s
THRUST_LIMIT = 0.6  # N
ARM = 0.046  # m, centre to rotor
TORQUE_PER_THRUST = 0.00596  # m: Crazyflie firmware, thrustToTorque
ROTOR_THRUST = 2.88e-8  # N s²/rad², of one rotor: Förster's 3.16e-10 N per rpm²
HOVER = MASS * GRAVITY

LAYOUTS = Layouts(
    state=Layout.of(("x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz")),
    action=Layout.of(("thrust", "wx_cmd", "wy_cmd", "wz_cmd")),
    inputs=Layout.of(WRENCH),
)


# A state is MuJoCo's, place by place.
_COORDINATES = Coordinates(places=[*range(13)], standing=np.zeros(13), positions=7)


def _rigid_body() -> Equations:
    from sym2real.robots.nominal_quadrotor import quadrotor  # noqa: PLC0415 — SymPy stays out of light imports

    return quadrotor(MASS, INERTIA, rate_gains=RATE_GAINS, dt=0.02)


# A wrench may use half of the torque that the rate loop has at full command.
_TORQUES = tuple(
    0.5 * inertia * gain * limit for inertia, gain, limit in zip(INERTIA, RATE_GAINS, RATE_LIMITS, strict=True)
)

CRAZYFLIE = Robot(
    name="crazyflie",
    title="Crazyflie 2.1",
    layouts=LAYOUTS,
    dt=0.02,
    limits=Limits(
        low=np.array([0.0, *(-limit for limit in RATE_LIMITS)]),
        high=np.array([THRUST_LIMIT, *RATE_LIMITS]),
        draws=(
            np.array([0.5 * HOVER, *(-limit for limit in RATE_LIMITS)]),
            np.array([1.5 * HOVER, *RATE_LIMITS]),
        ),
        push=dict(zip(WRENCH, (*[0.3 * HOVER] * 3, *_TORQUES), strict=True)),
        state={"velocity": 15.0, "rate": 2.0 * max(RATE_LIMITS)},  # m/s: a fall of a second and a half; rad/s
        workspace=1.5,  # m: the paper authors' flight space, |x|, |y| <= 1.5 m
    ),
    description=Description(
        mjcf="crazyflie.xml",
        physics_dt=0.002,
        start=np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        rest=np.array([HOVER, 0.0, 0.0, 0.0]),
        to_state=_COORDINATES.to_state,
        to_coordinates=_COORDINATES.to_coordinates,
        body="crazyflie",
        crash="contact",
        coarse_substeps=1,  # one Runge–Kutta step a period is within 0.03 mm of ten after 0.8 s for the free body
    ),
    recipe=Recipe(
        tasks=(("hover", {}), ("circle", {}), ("lemniscate", {})),
        episodes=3,
        most_episodes=10,  # the most that the paper's bases took
        dither=(0.005, 0.15, 0.15, 0.15),
        dependencies=(
            *((velocity, THRUST_COLUMN) for velocity in VELOCITY.columns),
            *zip(RATE.columns, RATE_COMMAND.columns, strict=True),
        ),
        cost_weights={"position": 1.0, "orientation": 0.4, "velocity": 0.05, "rate": 0.01},
    ),
    numbers={
        "mass": MASS,
        **dict(zip(("jx", "jy", "jz"), INERTIA, strict=True)),
        **dict(zip(("kx", "ky", "kz"), RATE_GAINS, strict=True)),
        "arm": ARM,
        "torque_per_thrust": TORQUE_PER_THRUST,
        "rotor_thrust": ROTOR_THRUST,
    },
    mppi=MPPISettings(horizon=0.8, temperature=0.5, noise=(0.025, 1.2, 1.2, 0.5), correlation=0.1),
    rigid_body=_rigid_body,
)
