"""# A new robot from its MJCF

A file that MuJoCo opens is enough: columns, limits, a simulator, equations of motion, a controller and a diagnosis come
of it. Here it is a pendulum with a motor; put the path of your own file in its place.

    python docs/tutorials/07_new_robot.py
"""

from pathlib import Path

import numpy as np

from sym2real import (
    MPPI,
    Dataset,
    MujocoPlant,
    Robot,
    compare,
    compile_model,
    diagnose,
    effect,
    make_task,
    run_episode,
    sensors,
)

PENDULUM = """
<mujoco model="pendulum">
  <option timestep="0.002" integrator="RK4"/>
  <worldbody>
    <body name="arm" pos="0 0 1.5">
      <joint name="swing" type="hinge" axis="0 1 0" range="-170 170" limited="true"/>
      <inertial pos="0 0 -0.5" mass="1" diaginertia="0.084 0.084 0.001"/>
      <geom type="capsule" fromto="0 0 0 0 0 -1" size="0.02" contype="0" conaffinity="0" mass="0"/>
    </body>
  </worldbody>
  <actuator>
    <motor name="torque" joint="swing" ctrlrange="-6 6" ctrllimited="true"/>
  </actuator>
</mujoco>
"""
Path("pendulum.xml").write_text(PENDULUM, encoding="utf-8")

# The joint `swing` becomes the state columns `swing` in rad and `swing_rate` in rad/s, the motor `torque` an action in
# N m. What else a file may hold, and what becomes of it, stands in [a new robot](../new_robot.md).

robot = Robot.from_mjcf("pendulum.xml")
print(robot.title, "measures", *robot.layouts.state, "and takes", *robot.layouts.action)

# For hinges and slides the equations of motion follow from the bodies in the file. Nothing is simulated or fitted.

model = robot.nominal()
print(model.text())

# Do they hold? MuJoCo swings to three goals, MPPI with these equations chooses the torques, `compare` looks at the
# logs.


def swung(plant: MujocoPlant, goal: float, seed: int):
    task = make_task("regulate", robot, goal={"swing": goal})
    controller = MPPI(compile_model(model), robot, task)
    return run_episode(plant, controller, task, steps=300, seed=seed, name=f"to {goal:g} rad")


plain = Dataset([swung(MujocoPlant(robot), goal, seed) for seed, goal in enumerate((-1.0, 0.5, 1.5))])
plain[2].plot().savefig("plain.svg")
gap = compare(model, plain, start="measured")  # these logs have no noise that would have to be smoothed away
print(gap)
assert gap.at(0.8).errors["joint angle"].value < 1e-3

# The real pendulum has what its file lacks: here a bearing that brakes, by MuJoCo's own joint damping, and noisy
# sensors. Which effect is missing, and how large is it?

hidden = effect("joint_damping:swing", robot).inject(value=0.4)
real = MujocoPlant(robot, [sensors(robot, np.random.default_rng(0)), hidden])
logs = Dataset([swung(real, goal, seed) for seed, goal in enumerate((-1.0, 0.5, 1.5, -1.8))])
found = diagnose(model, logs, MujocoPlant(robot))
print(found.summary)
(finding,) = found.findings
assert finding.effect == "joint_damping:swing"
assert finding.parameters["value"].low < 0.4 < finding.parameters["value"].high

# The equations with the damping predict the logs better than those of the file alone.

informed = found.apply(model)
print("before", compare(model, logs))
print("after ", compare(informed, logs))
logs[2].plot(before=model, after=informed).savefig("measured_and_predicted.svg")

# Logs of a real pendulum take the place of the simulated ones: `read_log("swing.csv", layouts=robot.layouts)`.
# `sym2real nominal mjcf pendulum.xml --out runs/pendulum` makes a folder of it that the command line takes;
# [a new robot](../new_robot.md) says more.
