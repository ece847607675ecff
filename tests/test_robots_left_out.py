"""What a robot of joints may meet and its equations do not have is said: contacts, and the ends of joints."""

import numpy as np

from sym2real.dataset import Dataset
from sym2real.diagnosis import compare, diagnose
from sym2real.plants import MujocoPlant
from sym2real.robots import ROBOTS, Robot
from sym2real.robots.left_out import CONTACTS, STOPS
from sym2real.trajectory import Array, Trajectory

LEG = """
<mujoco>
  <option timestep="0.005"/>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="hip" pos="0 0 0.5">
      <joint name="height" type="slide" axis="0 0 1" damping="1"/><geom name="hip" size="0.05"/>
      <body name="foot">
        <joint name="knee" axis="0 1 0" range="-60 30" damping="1"/><geom size="0.05" pos="0 0 -0.3"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor name="lift" joint="height" ctrlrange="-50 50"/><motor name="bend" joint="knee" ctrlrange="-5 5"/>
  </actuator>
</mujoco>
"""
OFF = '<option timestep="0.005"><flag contact="disable"/></option>'


def bent(robot: Robot, torque: float) -> Dataset:
    """The robot as its knee is bent to and fro while it is held up."""
    plant, rng = MujocoPlant(robot), np.random.default_rng(0)
    states, actions, state = list[Array](), list[Array](), plant.reset(robot.start)
    for lift, bend in rng.uniform(-1.0, 1.0, (150, 2)) * [3.0, torque]:
        held = robot.mass * 9.81 - 100 * state[0] - 20 * state[2] + lift
        states.append(state)
        actions.append(np.clip([held, bend], robot.low, robot.high))
        state = plant.step(actions[-1])
    inputs = np.zeros((len(states), robot.layouts.inputs.size))
    time = robot.dt * np.arange(len(states))
    return Dataset([Trajectory(time, np.array(states), np.array(actions), inputs, robot.layouts, name="bent")])


def test_bodies_that_can_touch_and_joints_that_end_are_named() -> None:
    contacts, stops = Robot.from_mjcf(LEG).nominal().notes
    assert contacts.startswith(f"{CONTACTS}: ")
    assert "foot with world" in contacts
    assert "hip with world" in contacts
    assert "hip with foot" not in contacts  # a body and its parent pass through each other
    assert stops == f"{STOPS}: knee at -1.05 and 0.524 rad"
    (alone,) = Robot.from_mjcf(LEG.replace('<option timestep="0.005"/>', OFF)).nominal().notes
    assert alone == stops
    assert not ROBOTS["hexarotor"].nominal().notes
    assert not any(CONTACTS in note for note in ROBOTS["differential_drive"].nominal().notes)


def test_compare_and_diagnose_say_that_contacts_lack_and_ends_that_the_logs_reach() -> None:
    robot = Robot.from_mjcf(LEG)
    model = robot.nominal()
    calm, hard = bent(robot, 0.5), bent(robot, 5.0)
    for notes in (compare(model, calm).notes, diagnose(model, calm, exclude=["*"]).notes):
        assert any(note.startswith(CONTACTS) for note in notes)
        assert not any("end stops" in note for note in notes)
    assert "the logs reach what is not in the equations: end stops of knee" in compare(model, hard).notes
