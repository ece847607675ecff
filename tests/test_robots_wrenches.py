"""A quadrotor that is commanded a thrust and torques, as simulators have it: from numbers, and from its MJCF."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from sym2real.cli import main
from sym2real.diagnosis import diagnose
from sym2real.errors import ModelError
from sym2real.experiments.models import open_model
from sym2real.logs import read_logs, write_log
from sym2real.neural.model_folder import below
from sym2real.plants import MujocoPlant
from sym2real.robots import Motors, Robot, quadrotor
from sym2real.robots.motors import Wrenches
from sym2real.symbolic import Equations, compile_model
from sym2real.trajectory import Array, Trajectory

INERTIA = (1.4e-5, 1.5e-5, 2.6e-5)
# As a public collection of models has it: a thrust in N, and moments whose commands go from -1 to 1.
DRONE = """
<mujoco model="drone">
  <option timestep="0.001"/>
  <worldbody>
    <body name="drone" pos="0 0 1">
      <freejoint/>
      <inertial pos="0 0 0" mass="{mass}" diaginertia="1.4e-5 1.5e-5 2.6e-5"/>
      <site name="actuation"/>
    </body>
  </worldbody>
  <actuator>
    <motor name="{thrust}" site="actuation" gear="0 0 1 0 0 0" ctrlrange="0 0.6" ctrllimited="true"/>
    <motor name="x_moment" site="actuation" gear="0 0 0 -1e-4 0 0" ctrlrange="-1 1" ctrllimited="true"/>
    <motor name="y_moment" site="actuation" gear="0 0 0 0 -1e-4 0" ctrlrange="-1 1" ctrllimited="true"/>
    <motor name="z_moment" site="actuation" gear="0 0 0 0 0 -1e-4" ctrlrange="-1 1" ctrllimited="true"/>
  </actuator>
</mujoco>
"""


def drone(mass: float = 0.027, thrust: str = "body_thrust") -> Robot:
    return Robot.from_mjcf(DRONE.format(mass=mass, thrust=thrust), name="drone", dt=0.01)


@pytest.mark.parametrize("thrust", ["body_thrust", "thrust"])
def test_equations_of_a_thrust_and_moments_are_the_simulator(thrust: str) -> None:
    robot, rng = drone(thrust=thrust), np.random.default_rng(0)
    assert robot.layouts.action.units == {thrust: "N", "x_moment": "1", "y_moment": "1", "z_moment": "1"}
    model, plant = compile_model(robot.nominal(), dtype=torch.float64), MujocoPlant(robot)
    np.testing.assert_allclose(robot.rest, [0.027 * 9.80665, 0.0, 0.0, 0.0], atol=1e-3)
    for _ in range(5):
        state, action = robot.start.copy(), robot.rest + rng.uniform(-0.1, 0.1, 4)
        state[7:] = rng.uniform(-0.5, 0.5, 6)
        push = 0.1 * rng.uniform(-1.0, 1.0, 6) * [0.1, 0.1, 0.1, 1e-4, 1e-4, 1e-4]
        plant.reset(state)
        plant.push(push)
        after = plant.step(action)
        found = model(*map(torch.as_tensor, (state, action, push))).numpy()
        assert np.abs(found - after).max() < 2e-3 * np.abs(after - state).max()


def test_torques_that_motors_would_give_turn_it_as_the_motors_do() -> None:
    motors = Motors(thrust=0.15)
    by_motors = compile_model(quadrotor(0.03, INERTIA, interface="motors", motors=motors), dtype=torch.float64)
    equations = quadrotor(0.03, INERTIA, interface="thrust_torques")
    assert equations.layouts.action.columns == ("thrust", "tx_cmd", "ty_cmd", "tz_cmd")
    assert equations.layouts.action.units["tx_cmd"] == "N m"
    state = torch.tensor([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.1, 0.2, -0.1, 0.3, -0.2, 0.4], dtype=torch.float64)
    sent = torch.tensor([0.5, 0.52, 0.49, 0.55], dtype=torch.float64)
    forces = motors.forces([*sent.tolist()])
    wrench = torch.tensor([float(sum(forces)), *map(float, motors.torques(forces))], dtype=torch.float64)
    torch.testing.assert_close(compile_model(equations, dtype=torch.float64)(state, wrench), by_motors(state, sent))


def flown(robot: Robot, rows: int, seed: int) -> Trajectory:
    """Held up by a loop of its attitude in MuJoCo, thrown about by steps of thrust and moments, and measured."""
    plant, rng = MujocoPlant(robot), np.random.default_rng(seed)
    states, sent, state = list[Array](), list[Array](), plant.reset()
    wanted = np.zeros(3)
    for row in range(rows):
        if row % 40 == 0:
            wanted = rng.uniform([-0.25, -0.25, -0.3], [0.25, 0.25, 0.3])
        angle = 2.0 * state[4:7] * np.sign(state[3])
        moments = -(6e-4 * (angle - [*wanted[:2], 0.0]) + 6e-5 * (state[10:] - [0.0, 0.0, wanted[2]])) / -1e-4
        lift = 0.27 * (1.0 - 0.6 * (state[2] - 1.0 - 0.3 * wanted[2]) - 0.5 * state[9])
        action = np.clip([lift, *moments], robot.low, robot.high)
        states.append(state)
        sent.append(action)
        state = plant.step(action)
    noise = np.array([1e-3] * 3 + [5e-4] * 4 + [5e-3] * 3 + [0.02] * 3)
    noisy = np.array(states) + rng.normal(0.0, noise, (rows, 13))
    noisy[:, 3:7] /= np.linalg.norm(noisy[:, 3:7], axis=1, keepdims=True)
    return Trajectory.from_arrays(noisy, np.array(sent), robot.layouts, dt=0.01, name=f"flight{seed}")


@pytest.mark.slow
def test_a_heavier_drone_is_found_through_its_file_and_its_logs(tmp_path: Path) -> None:
    (tmp_path / "drone.xml").write_text(DRONE.format(mass=0.027, thrust="body_thrust"))
    main(["nominal", "mjcf", str(tmp_path / "drone.xml"), "--dt", "0.01", "--out", str(tmp_path / "model")])
    base = below(open_model(str(tmp_path / "model")))
    assert isinstance(base, Equations)
    heavier = drone(0.030)
    for seed in range(6):
        write_log(flown(heavier, 400, seed), tmp_path / "logs" / f"{seed}.csv")
    found = diagnose(base, read_logs(tmp_path / "logs", layouts=base.layouts, dt=base.dt))
    assert found.verdict == "EFFECT"
    assert "added_mass" in (found.findings[0].effect, *found.findings[0].group)
    healthy = [flown(drone(), 400, seed) for seed in range(6)]
    assert diagnose(base, healthy).verdict == "NOTHING_MISSING"


def test_rotors_of_other_names_are_still_asked_for_theirs() -> None:
    rotors = "".join(
        f'<motor name="r{place}" site="s{place}" gear="0 0 1 0 0 {0.006 * sign}" ctrlrange="0 0.2"/>'
        for place, sign in enumerate((-1, 1, -1, 1))
    )
    places = ((1, -1), (-1, -1), (-1, 1), (1, 1))
    sites = "".join(f'<site name="s{n}" pos="{0.03 * x} {0.03 * y} 0"/>' for n, (x, y) in enumerate(places))
    text = DRONE.format(mass=0.027, thrust="t").replace('<site name="actuation"/>', sites)
    text = text[: text.index("<actuator>")] + f"<actuator>{rotors}</actuator></mujoco>"
    with pytest.raises(ModelError, match="not called motor1, motor2, motor3, motor4"):
        Robot.from_mjcf(text, name="drone").nominal()


def test_a_command_called_thrust_is_all_of_it() -> None:
    with pytest.raises(ModelError, match="all of it in N"):
        Wrenches(("thrust", "left"), (1.0, 0.5), ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)))
