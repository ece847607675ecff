"""MuSHR racecar: steering angle and speed commanded, four driven wheels.

Position and velocity of the state are those of the middle of the rear axle, where the kinematic bicycle does not slip.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sym2real.layout import Layout, Layouts
from sym2real.robots.description import Description, yaw_of
from sym2real.robots.recipe import Recipe
from sym2real.robots.robot import GRAVITY, Limits, MPPISettings, Robot
from sym2real.trajectory import Array

if TYPE_CHECKING:
    from sym2real.symbolic import Equations

WHEELBASE = 0.2955  # m
TRACK = 0.23  # m
WHEEL_RADIUS = 0.05  # m
STEER_LIMIT = 0.38  # rad
SPEED_LIMIT = 2.5  # m/s
MASS = 3.5  # kg: chassis 2.9, wheels 0.15 each
# A force along the car also spins up the wheels (4 I / r², ellipsoids); their speed servos (k_v = 0.02 N m s each) give
# 4 k_v / r² = 32 N per m/s.
MOVED_MASS = MASS + 4 * 1.5e-4 / WHEEL_RADIUS**2  # kg
SPEED_TIME_CONSTANT = MOVED_MASS / (4 * 0.02 / WHEEL_RADIUS**2)  # s
WHEEL_DRIVE = 0.02 / WHEEL_RADIUS**2  # N s/m: force of one wheel's speed servo per m/s of error
CENTRE = 0.5 * WHEELBASE  # m: centre of mass ahead of the rear axle
YAW_INERTIA = 0.0641  # kg m², about the centre of mass, with wheels
REST_HEIGHT = 0.049698  # m: rear axle above the ground once the contacts carry the car

LAYOUTS = Layouts(
    state=Layout.of(("x", "y", "sin_yaw", "cos_yaw", "vx", "vy", "wz")),
    action=Layout.of(("steer", "speed")),
    inputs=Layout.of(("fx", "fy", "tz")),
)

# Joints in the order of mushr.xml after the free joint: steer and spin of the front wheels, spin of the rear ones.
STEER_JOINTS = [0, 2]
SPIN_JOINTS = [1, 3, 4, 5]


def ackermann(steer: Array) -> Array:
    """Angles of the left and right front wheel in rad ``# (..., 2)`` that share one turning centre.

    Args:
        steer: angle of the bicycle's front wheel in rad, left positive ``# (...)``.
    """
    tangent = WHEELBASE * np.tan(steer)[..., None]
    side = np.array([-1.0, 1.0]) * 0.5 * TRACK * np.tan(steer)[..., None]
    return np.arctan2(tangent, WHEELBASE + side)


def _to_control(actions: Array) -> Array:
    wheels = np.repeat(actions[..., 1:] / WHEEL_RADIUS, 4, axis=-1)
    return np.concatenate([ackermann(actions[..., 0]), wheels], axis=-1)


def _to_state(qpos: Array, qvel: Array) -> Array:
    yaw = yaw_of(qpos)
    parts = (qpos[..., 0], qpos[..., 1], np.sin(yaw), np.cos(yaw), qvel[..., 0], qvel[..., 1], qvel[..., 5])
    return np.stack(parts, axis=-1)


def _to_coordinates(state: Array) -> tuple[Array, Array]:
    """Wheels roll without slip, and the front wheels are turned as the yaw rate asks, within their limits."""
    x, y, sine, cosine, vx, vy, wz = state
    yaw = np.arctan2(sine, cosine)
    forward = vx * cosine + vy * sine
    steer = np.clip(np.arctan(WHEELBASE * wz / forward), -STEER_LIMIT, STEER_LIMIT) if abs(forward) > 0.1 else 0.0
    angles = ackermann(np.asarray(steer))
    sides = np.array([0.5, -0.5]) * TRACK
    front = ((forward - wz * sides) * np.cos(angles) + wz * WHEELBASE * np.sin(angles)) / WHEEL_RADIUS
    rear = (forward - wz * sides) / WHEEL_RADIUS
    joints, rates = np.zeros(6), np.zeros(6)
    joints[STEER_JOINTS] = angles
    rates[SPIN_JOINTS] = [*front, *rear]
    qpos = np.concatenate([[x, y, REST_HEIGHT, np.cos(0.5 * yaw), 0.0, 0.0, np.sin(0.5 * yaw)], joints])
    return qpos, np.concatenate([[vx, vy, 0.0, 0.0, 0.0, wz], rates])


def _rigid_body() -> Equations:
    from sym2real.robots.nominal_car import car  # noqa: PLC0415 — SymPy stays out of light imports

    return car(WHEELBASE, time_constant=SPEED_TIME_CONSTANT, mass=MOVED_MASS, centre=CENTRE, dt=0.05)


MUSHR = Robot(
    name="mushr",
    title="MuSHR racecar",
    layouts=LAYOUTS,
    dt=0.05,
    limits=Limits(
        low=np.array([-STEER_LIMIT, -2.2]),
        high=np.array([STEER_LIMIT, SPEED_LIMIT]),
        draws=(np.array([-STEER_LIMIT, -2.0]), np.array([STEER_LIMIT, 2.0])),
        push={"fx": 0.3 * MASS * GRAVITY, "fy": 0.3 * MASS * GRAVITY, "tz": 0.15 * MASS * GRAVITY * WHEELBASE},
        # Twice what commands ask for, m/s, and three times what they turn at without slip, rad/s: it may spin.
        state={"velocity": 2.0 * SPEED_LIMIT, "rate": 3.0 * SPEED_LIMIT * float(np.tan(STEER_LIMIT)) / WHEELBASE},
        workspace=3.2,  # m: the paper authors' floor, y from -4.2 to 2.2 m
    ),
    description=Description(
        mjcf="mushr.xml",
        physics_dt=0.005,
        start=np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        rest=np.zeros(2),
        to_control=_to_control,
        to_state=_to_state,
        to_coordinates=_to_coordinates,
        body="mushr",
        crash="rolled over",
    ),
    recipe=Recipe(
        # The second circle is the first the other way round, smaller and faster.
        tasks=(("circle", {}), ("park", {}), ("circle", {"radius": 1.2, "speed": 1.6, "clockwise": True})),
        episodes=5,
        most_episodes=20,  # the most that the paper's bases took
        # Over the standard drives the base of such drives has a thirteenth of the squared error of Stage I's.
        base="drives",
        dither=(0.03, 0.1),
        dependencies=(("vx", "speed"), ("vy", "speed"), ("wz", "steer")),
        angles=("steer",),
        cost_weights={"position": 1.0, "orientation": 0.2, "velocity": 0.1, "rate": 0.0},
    ),
    numbers={
        "mass": MASS,
        "wheelbase": WHEELBASE,
        "track": TRACK,
        "wheel_radius": WHEEL_RADIUS,
        "wheel_drive": WHEEL_DRIVE,
        "centre": CENTRE,
        "jz": YAW_INERTIA,
        "speed_time": SPEED_TIME_CONSTANT,
    },
    mppi=MPPISettings(horizon=1.0, temperature=0.5, noise=(0.2, 0.8), knots=5),
    rigid_body=_rigid_body,
)
