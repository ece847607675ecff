"""Which values the tests of effects use, and the same flights and drives simulated with MuJoCo and with equations."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor

from sym2real.effects import EFFECTS, Effect, effect
from sym2real.effects.filters import filter_commands, measurement_filters, numbers, with_hidden_start
from sym2real.plants import MujocoPlant
from sym2real.protocols import Change
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.symbolic import Equations, build_module, compile_function, rollout, symbol
from sym2real.trajectory import Array

# Robot, key, values, least direction cosine, how far the ratio of sizes may be from 1.
# Quadrotor: 0.5 s; held velocities and thrust shares are those of a step's start, at most 3 % of a term.
# Car: 0.8 s; the first-principles car has no steering servo: it answers the effect's jump at the start some 30 ms
# early, 12 % of what the jump does (a longer wheelbase, which makes no jump, agrees within 3 %).
Q, C = CRAZYFLIE, MUSHR
Case = tuple[Robot, str, dict[str, float], float, float]
CASES: list[Case] = [
    (Q, "added_mass", {"value": 0.0025}, 0.999, 0.01),
    (Q, "added_mass", {"value": 0.005}, 0.999, 0.01),
    (Q, "payload", {"mass": 0.005, "rx": 0.02, "ry": -0.01}, 0.998, 0.02),
    (Q, "payload", {"mass": 0.005, "rx": 0.03, "ry": -0.035}, 0.998, 0.02),
    # Its gyroscopic torque is held over a step, in which the rate loop changes the rates by half.
    (Q, "inertia_axes", {"roll": 0.2}, 0.998, 0.03),
    (Q, "inertia_axes", {"roll": -0.1, "coupling": -0.25}, 0.998, 0.03),
    (Q, "gain:thrust", {"value": 0.9}, 0.999, 0.01),
    (Q, "offset:wy_cmd", {"value": 0.2}, 0.999, 0.01),
    (Q, "limit:wy_cmd", {"lower": -0.5, "upper": 0.5}, 0.999, 0.01),
    (Q, "com_offset", {"rx": 0.0005}, 0.999, 0.01),
    (Q, "com_offset", {"rx": 0.002, "ry": -0.003}, 0.999, 0.02),
    (Q, "torque_bias", {"tx": 1e-5, "tz": 2e-5}, 0.999, 0.01),
    (Q, "wind", {"fx": 0.006, "fy": -0.003}, 0.999, 0.01),
    (Q, "wind", {"fx": 0.02, "fz": 0.01}, 0.999, 0.01),
    (Q, "linear_drag", {"cx": 0.02, "cy": 0.02, "cz": 0.02}, 0.999, 0.03),
    (Q, "linear_drag", {"cx": 0.02, "cy": 0.01}, 0.998, 0.03),
    (Q, "quadratic_drag", {"value": 0.016}, 0.998, 0.04),
    (Q, "periodic_force", {"fx": 0.02, "fz": 0.02, "omega": 6.0, "phase": 0.3}, 0.999, 0.02),
    (Q, "thrust_curve", {"value": 1.3}, 0.999, 0.01),
    (Q, "battery_sag", {"value": 0.01}, 0.999, 0.02),
    (Q, "ground_effect", {"value": 0.35}, 0.999, 0.02),
    (Q, "translational_lift", {"value": 0.05}, 0.999, 0.04),
    (Q, "flapping_moment", {"a": 2e-5, "b": -3e-5}, 0.999, 0.03),
    (Q, "rotor_loss", {"rotor": 2, "value": 0.1}, 0.999, 0.03),
    # The simulator takes the derivative from one physics step to the next, a tenth of the rate loop's time.
    (Q, "rotor_reaction", {"value": 5e-9}, 0.99, 0.12),
    (Q, "rate_damping", {"dx": 1e-4, "dy": 2e-4, "dz": 1e-4}, 0.999, 0.02),
    (Q, "rate_loop_gain", {"value": 0.8}, 0.999, 0.02),
    (Q, "rate_loop_gain", {"value": 0.9, "yaw": 0.6}, 0.999, 0.02),
    (Q, "motor_lag", {"value": 0.03}, 0.999, 0.01),
    (Q, "motor_lag", {"value": 0.07}, 0.999, 0.01),
    (Q, "delay", {"value": 0.02}, 0.999, 0.01),
    (Q, "delay:wx_cmd", {"value": 0.06}, 0.999, 0.01),
    # Within a period one number stands for a command that moves: rates end where they should, attitudes nearly.
    (Q, "delay", {"value": 0.01}, 0.99, 0.05),
    (Q, "lag:wx_cmd", {"value": 0.01}, 0.99, 0.05),
    (Q, "lag:wx_cmd", {"value": 0.05}, 0.999, 0.02),
    (Q, "rate_limit:wx_cmd", {"value": 20.0}, 0.999, 0.01),
    (Q, "dead_band:wx_cmd", {"value": 0.5}, 0.999, 0.01),
    # Commands about the threshold act in part, so that a fit feels it.
    (Q, "dead_zone:wx_cmd", {"value": 0.3}, 0.97, 0.05),
    (Q, "mounting_tilt", {"roll": 0.035, "pitch": -0.02}, 0.999, 0.01),
    (Q, "mounting_yaw", {"value": 0.1}, 0.999, 0.01),
    (Q, "marker_tilt", {"roll": 0.03, "pitch": -0.02}, 0.999, 0.01),
    (Q, "yaw_bias", {"value": 0.1}, 0.999, 0.01),
    (Q, "lever_arm", {"rx": 0.03, "ry": -0.02, "rz": 0.01}, 0.999, 0.01),
    (Q, "sensor_sign:wy", {"value": -1.0}, 0.999, 0.01),
    (Q, "sensor_bias:wz", {"value": 0.1}, 0.999, 0.01),
    (Q, "sensor_scale:x", {"value": 1.1}, 0.999, 0.01),
    (Q, "sensor_lag:z", {"value": 0.05}, 0.999, 0.01),
    (Q, "time_shift:wy", {"value": 0.03}, 0.999, 0.01),
    (C, "offset:steer", {"value": 0.02}, 0.99, 0.15),
    (C, "offset:steer", {"value": 0.1}, 0.99, 0.15),
    (C, "gain:steer", {"value": 0.85}, 0.99, 0.15),
    (C, "steering_curve", {"value": 1.0}, 0.99, 0.15),
    (C, "gain:speed", {"value": 0.9}, 0.99, 0.05),
    (C, "limit:speed", {"upper": 1.0}, 0.99, 0.05),
    (C, "limit:steer", {"magnitude": 0.1}, 0.99, 0.15),
    (C, "wheelbase", {"value": 1.1}, 0.999, 0.05),
    # A servo of its own behind the lag, 20 ms late, leaves the gyro by as much.
    (C, "lag:steer", {"value": 0.1, "mean_share": 0.8}, 0.99, 0.15),
    (C, "lag:speed", {"value": 0.3}, 0.99, 0.05),
    (C, "delay", {"value": 0.05}, 0.99, 0.06),
    (C, "delay", {"value": 0.2}, 0.99, 0.06),
    (C, "rate_limit:steer", {"value": 0.5, "mean_share": 0.8}, 0.99, 0.15),
    (C, "dead_zone:speed", {"value": 1.0}, 0.99, 0.15),
    (C, "dead_zone:steer", {"value": 0.1}, 0.99, 0.15),
    (C, "speed_curve", {"value": 0.1}, 0.99, 0.05),
    (C, "steering_asymmetry", {"value": 0.1}, 0.99, 0.15),
    (C, "speed_asymmetry", {"value": 0.1}, 0.99, 0.05),
    (C, "wind", {"fx": 2.0, "fy": 1.0}, 0.99, 0.05),
    (C, "slope", {"gx": 0.3, "gy": 0.5}, 0.99, 0.05),
    (C, "rolling_resistance", {"value": 0.5}, 0.99, 0.05),
    (C, "linear_drag", {"cx": 1.0, "cy": 1.0}, 0.99, 0.05),
    (C, "quadratic_drag", {"value": 1.0}, 0.99, 0.08),
    (C, "periodic_force", {"fx": 2.0, "omega": 5.0}, 0.99, 0.05),
    (C, "yaw_drag", {"value": 4.0}, 0.99, 0.1),
    # The simulated rear axle creeps outwards by a tenth of what the centre of mass moves sideways.
    (C, "lateral_slip", {"value": 5.0}, 0.99, 0.22),
    # The first-principles car does not scrub: up to 4 % faster in a turn, with the cube of which understeer grows.
    (C, "understeer", {"value": 0.01}, 0.99, 0.15),
    (C, "understeer", {"value": -0.005}, 0.99, 0.2),
    (C, "tyre_slip", {"value": 0.005}, 0.99, 0.05),
    (C, "tyre_slip", {"value": 0.02}, 0.99, 0.05),
    (C, "relaxation_length", {"value": 0.1, "mean_share": 0.8}, 0.99, 0.15),
    (C, "relaxation_length", {"value": 0.3, "mean_share": 0.8}, 0.99, 0.15),
    (C, "yaw_inertia", {"value": 0.05, "mean_share": 0.8}, 0.99, 0.15),
    (C, "yaw_inertia", {"value": 0.1, "mean_share": 0.8}, 0.99, 0.15),
    # Sliding tyres: the limit is a corner here and a bend in MuJoCo.
    (C, "tyre_friction", {"value": 0.3}, 0.99, 0.2),
    (C, "tyre_friction", {"value": 0.4}, 0.99, 0.2),
    (C, "yaw_bias", {"value": 0.035}, 0.999, 0.01),
    (C, "lever_arm", {"rx": 0.05, "ry": 0.02}, 0.999, 0.01),
]
FLIGHTS = {"crazyflie": (4, 25), "mushr": (4, 16)}  # how many, of how many rows
# Sizes that weigh alike, about the noise of a motion capture and a gyro.
UNITS = {"position": 0.001, "attitude": 0.005, "heading": 0.005, "velocity": 0.02, "rate": 0.02}


def one_key_per_kind(robot: Robot) -> list[str]:
    """Every kind that the robot's equations can be given, on one column."""
    keys = []
    for name, kind in EFFECTS.items():
        column = {"action": robot.layouts.action.columns[-1], "state": robot.layouts.state.columns[1]}.get(kind.columns)
        found = effect(f"{name}:{column}" if column else name, robot)
        if found.applies(robot.nominal()):
            keys.append(found.key)
    return keys


@dataclass(frozen=True)
class Run:
    """Starts ``# (N, state)`` and commands ``# (N, H, action)``."""

    robot: Robot
    starts: Array
    actions: Array


def wander(rng: np.random.Generator, rows: int, deviation: Any, correlation: float) -> Array:
    """Coloured noise ``# (rows, columns)``."""
    kept, values = np.exp(-1.0 / correlation), [rng.standard_normal(len(deviation))]
    while len(values) < rows:
        values.append(kept * values[-1] + np.sqrt(1.0 - kept**2) * rng.standard_normal(len(deviation)))
    noise: Array = np.array(values) * deviation
    return noise


@functools.cache
def run(robot: Robot, low: bool = False) -> Run:
    """Flights with moving commands, all ``low`` or all at 2 m; drives up to 2.4 m/s and 0.3 rad."""
    rng, (number, rows) = np.random.default_rng(1), FLIGHTS[robot.name]
    starts, actions = [], []
    for _ in range(number):
        if robot is CRAZYFLIE:
            state = CRAZYFLIE.start.copy()
            state[:3] = [*rng.uniform(-1, 1, 2), rng.uniform(0.15, 0.3) if low else 2.0]
            state[4:7] = rng.uniform(-0.08, 0.08, 3)
            state[3:7] /= np.linalg.norm(state[3:7])
            state[7:10] = rng.uniform(-1, 1, 3) * [1.0, 1.0, 0.2]
            state[9] = abs(state[9])
            state[10:] = rng.uniform(-0.5, 0.5, 3)
            action = CRAZYFLIE.rest + wander(rng, rows, [0.03, 1.0, 1.0, 0.7], 4.0)
        else:
            yaw, speed, steer = rng.uniform(-3, 3), rng.uniform(0.8, 2.4), rng.uniform(-0.3, 0.3)
            heading = np.array([np.cos(yaw), np.sin(yaw)])
            turning = speed * np.tan(steer) / MUSHR.numbers["wheelbase"]
            state = np.array([*rng.uniform(-1, 1, 2), heading[1], heading[0], *(speed * heading), turning])
            action = wander(rng, rows, [0.05, 0.2], 8.0)
            action += [steer, speed] - action[0]
        starts.append(state)
        actions.append(action)
    return Run(robot, np.array(starts), np.array(actions))


def simulated(given: Run, changes: list[Change], description: str | None = None) -> Array:
    """Measured states by MuJoCo, the start first ``# (N, H + 1, state)``."""
    plant = MujocoPlant(given.robot, changes, description=description)
    results = []
    for start, actions in zip(given.starts, given.actions, strict=True):
        rows = [plant.reset(start), *(plant.step(action) for action in actions)]
        assert not plant.crashed
        results.append(rows)
    return np.array(results)


@functools.cache
def plain(robot: Robot, low: bool = False) -> tuple[Array, Array]:
    """The run without effects: MuJoCo, equations."""
    return simulated(run(robot, low), []), predicted(nominal(robot), run(robot, low))


@functools.cache
def nominal(robot: Robot) -> Equations:
    return robot.nominal()


def predicted(equations: Equations, given: Run) -> Array:
    """Measured states by the equations, the start first ``# (N, H + 1, state)``."""
    starts, actions = torch.as_tensor(given.starts), torch.as_tensor(given.actions)
    columns = given.robot.layouts.state.columns
    commands = filter_commands(equations, actions)
    first = with_hidden_start(equations, starts, commands[:, 0])
    inputs = torch.zeros(len(starts), len(equations.layouts.inputs), dtype=torch.float64)
    after = rollout(build_module(equations).double(), first, commands, inputs)
    states = torch.cat([starts[:, None], after[..., : len(columns)]], dim=1)
    if equations.output:
        report = compile_function([equations.output.get(name, symbol(name)) for name in columns], [columns])
        states = report(states)
    for found, values in measurement_filters(equations):
        states = found.filter(states, equations.dt, numbers(equations, values))
    measured: Array = states.numpy()
    return measured


def change(robot: Robot, changed: Array, base: Array) -> Array:
    """What a change does to a run, on the manifold, in :data:`UNITS`."""
    layout = robot.layouts.state
    units = np.concatenate([[UNITS[field.name]] * field.tangent_size for field in layout.fields])
    difference: Tensor = layout.difference(torch.as_tensor(changed), torch.as_tensor(base))
    scaled: Array = difference.numpy() / units
    return scaled


def both_changes(found: Effect, robot: Robot, values: dict[str, float]) -> tuple[Array, Array]:
    """What an effect does by injection, and by substitution."""
    low = found.kind == "ground_effect"
    given, (mujoco_plain, equations_plain) = run(robot, low), plain(robot, low)
    if found.kind == "tyre_friction":  # from motions that slippery tyres allow
        held = Run(robot, given.starts, np.repeat(given.actions[:, :1], 12, axis=1))
        given = Run(robot, simulated(held, [found.inject(**values)])[:, -1], given.actions)
        mujoco_plain, equations_plain = simulated(given, []), predicted(nominal(robot), given)
    truth = simulated(given, [found.inject(**values)])
    hypothesis = predicted(found.substitute(nominal(robot), values), given)
    return change(robot, truth, mujoco_plain), change(robot, hypothesis, equations_plain)
