"""Robots that MuJoCo simulates and that somebody has written down by hand, with named parameters, for tests."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from sym2real.dataset import Dataset
from sym2real.layout import Layout, Layouts
from sym2real.symbolic import Equations
from sym2real.trajectory import Array, Trajectory

# Two propellers, `arm` to either side; water as damping. In SI units.
BOAT = {"mass": 25.0, "inertia": 2.7, "drag": 6.0, "yaw_drag": 1.9, "arm": 0.4}
BOAT_MJCF = """<mujoco><option timestep="0.005" gravity="0 0 0"/><worldbody><body name="hull">
<joint name="x" type="slide" axis="1 0 0" damping="{drag}"/><joint name="y" type="slide" axis="0 1 0" damping="{drag}"/>
<joint name="yaw" type="hinge" axis="0 0 1" damping="{yaw_drag}"/>
<inertial pos="0 0 0" mass="{mass}" diaginertia="9 9 {inertia}"/>
<site name="port" pos="0 {arm} 0"/><site name="starboard" pos="0 -{arm} 0"/></body></worldbody><actuator>
<motor site="port" gear="1 0 0 0 0 0"/><motor site="starboard" gear="1 0 0 0 0 0"/></actuator></mujoco>"""
BOAT_LAYOUTS = Layouts(Layout.of(["x", "y", "sin_yaw", "cos_yaw", "vx", "vy", "wz"]), Layout.of(["port", "starboard"]))
BOAT_NOISE = (0.01, 0.01, 0.004, 0.015, 0.015, 0.004)
BOAT_STEP = 0.1

# A pendulum hangs from a cart on a rail.
CRANE = {"cart_mass": 1.2, "pole_mass": 0.4, "length": 0.5, "friction": 2.0, "pivot_damping": 0.01}
CRANE_MJCF = """<mujoco><option timestep="0.002" integrator="RK4"/><worldbody><body>
<joint name="rail" type="slide" axis="1 0 0" damping="{friction}"/>
<inertial pos="0 0 0" mass="{cart_mass}" diaginertia="0.01 0.01 0.01"/><body>
<joint name="swing" type="hinge" axis="0 -1 0" damping="{pivot_damping}"/>
<inertial pos="0 0 -{length}" mass="{pole_mass}" diaginertia="1e-6 1e-6 1e-6"/></body></body></worldbody>
<actuator><motor joint="rail"/></actuator></mujoco>"""
CRANE_LAYOUTS = Layouts(Layout.of(["rail", "swing", "rail_rate", "swing_rate"]), Layout.of(["drive"]))
CRANE_NOISE = (0.001, 0.002, 0.01, 0.02)
CRANE_STEP = 0.02


def boat(step: float = BOAT_STEP) -> Equations:
    """Newton's and Euler's equations of the boat in world axes, by the midpoint."""
    push = "((port + starboard)/mass)"
    turning = "((starboard - port)*arm - yaw_drag*{rate})/inertia"
    rate, half = f"(wz + dt/2*({turning.format(rate='wz')}))", "dt/2*wz"
    vx = f"vx + dt*((cos_yaw - sin_yaw*{half})*{push} - drag/mass*(vx + dt/2*(cos_yaw*{push} - drag/mass*vx)))"
    vy = f"vy + dt*((sin_yaw + cos_yaw*{half})*{push} - drag/mass*(vy + dt/2*(sin_yaw*{push} - drag/mass*vy)))"
    return Equations.parse(
        BOAT_LAYOUTS,
        {
            "x": f"x + dt*(vx + {vx})/2",
            "y": f"y + dt*(vy + {vy})/2",
            "sin_yaw": f"sin_yaw*cos(dt*{rate}) + cos_yaw*sin(dt*{rate})",
            "cos_yaw": f"cos_yaw*cos(dt*{rate}) - sin_yaw*sin(dt*{rate})",
            "vx": vx,
            "vy": vy,
            "wz": f"wz + dt*({turning.format(rate=rate)})",
        },
        dt=step,
        parameters={"dt": step, **BOAT},
        numbers={"mass": BOAT["mass"]},
    )


def crane(step: float = CRANE_STEP) -> Equations:
    """Lagrange's equations of the cart and its pendulum, by the classical Runge–Kutta method."""
    quantities = dict[str, str]()
    before = {"swing": "swing", "rail_rate": "rail_rate", "swing_rate": "swing_rate"}
    for stage, part in enumerate(("1/2", "1/2", "1", ""), start=1):
        q, v, w = (f"({value})" for value in before.values())
        torque = f"(-pivot_damping*{w})"
        pull = f"(drive - friction*{v} + pole_mass*length*{w}**2*sin{q} - {torque}*cos{q}/length)"
        quantities[f"rail_{stage}"] = f"({pull} + pole_mass*g*sin{q}*cos{q})/(cart_mass + pole_mass*sin{q}**2)"
        quantities[f"swing_{stage}"] = f"({torque}/(pole_mass*length) - cos{q}*rail_{stage} - g*sin{q})/length"
        quantities |= {f"along_{stage}": v, f"around_{stage}": w}
        before = {
            "swing": f"swing + dt*{part}*around_{stage}",
            "rail_rate": f"rail_rate + dt*{part}*rail_{stage}",
            "swing_rate": f"swing_rate + dt*{part}*swing_{stage}",
        }
    sums = {"rail": "along", "swing": "around", "rail_rate": "rail", "swing_rate": "swing"}
    return Equations.parse(
        CRANE_LAYOUTS,
        {column: f"{column} + dt/6*({of}_1 + 2*{of}_2 + 2*{of}_3 + {of}_4)" for column, of in sums.items()},
        dt=step,
        quantities=quantities,
        parameters={"dt": step, "g": 9.81, **CRANE},
    )


def sailed(
    seed: int, *, logs: int = 5, rows: int = 400, wind: Sequence[float] = (0.0, 0.0), **others: float
) -> Dataset:
    """Noisy logs of the boat under random commands; a wind pushes it (N), and some parameters are others."""
    model = mujoco.MjModel.from_xml_string(BOAT_MJCF.format(**BOAT | others))
    made = []
    for number in range(logs):
        rng, data = np.random.default_rng([seed, number]), mujoco.MjData(model)
        commands = 2.0 * wandering(rng, rows, 2, 1.5 / BOAT_STEP) + rng.uniform(2.0, 5.0, 2)
        data.qpos[2], data.qfrc_applied[:2] = rng.uniform(-3.0, 3.0), wind
        states = np.array([stepped(model, data, command, BOAT_STEP) for command in commands])
        states += rng.normal(0.0, BOAT_NOISE, states.shape)
        x, y, yaw, *rates = states.T
        measured = np.column_stack([x, y, np.sin(yaw), np.cos(yaw), *rates])
        made.append(Trajectory.from_arrays(measured, commands, BOAT_LAYOUTS, dt=BOAT_STEP, name=f"leg {number}"))
    return Dataset(made)


def swung(seed: int, *, logs: int = 5, rows: int = 500, late: int = 0, **others: float) -> Dataset:
    """Noisy logs of the crane under random commands that act so many rows late; some parameters are others."""
    model = mujoco.MjModel.from_xml_string(CRANE_MJCF.format(**CRANE | others))
    made = []
    for number in range(logs):
        rng, data = np.random.default_rng([seed, number]), mujoco.MjData(model)
        data.qpos[1] = rng.uniform(-0.5, 0.5)
        shaken, commands, states = 4.0 * wandering(rng, rows, 1, 0.3 / CRANE_STEP), list[Array](), list[Array]()
        for row in range(rows):
            commands.append(shaken[row] - 3.0 * data.qpos[0])
            states.append(stepped(model, data, commands[max(0, row - late)], CRANE_STEP))
        measured = np.array(states) + rng.normal(0.0, CRANE_NOISE, (rows, 4))
        sent = np.array(commands)
        made.append(Trajectory.from_arrays(measured, sent, CRANE_LAYOUTS, dt=CRANE_STEP, name=f"run {number}"))
    return Dataset(made)


def stepped(model: mujoco.MjModel, data: mujoco.MjData, command: Array, step: float) -> Array:
    """Coordinates and their rates before a period under a command ``# (coordinates + rates,)``."""
    before, data.ctrl[:] = np.concatenate([data.qpos, data.qvel]), command
    for _ in range(round(step / model.opt.timestep)):
        mujoco.mj_step(model, data)
    return before


def wandering(rng: np.random.Generator, rows: int, columns: int, correlation: float) -> Array:
    """Coloured noise of deviation 1 ``# (rows, columns)``; correlation in rows."""
    kept, values = np.exp(-1.0 / correlation), [rng.standard_normal(columns)]
    while len(values) < rows:
        values.append(kept * values[-1] + np.sqrt(1.0 - kept**2) * rng.standard_normal(columns))
    return np.array(values)
