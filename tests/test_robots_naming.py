"""Joints and actuators without a name, or with one that is no column, are named as the file is opened."""

from pathlib import Path

import mujoco
import pytest

from sym2real.cli import main
from sym2real.errors import ModelError
from sym2real.robots import ROBOTS, Robot
from sym2real.robots.naming import give_names

NAMELESS = """
<mujoco>
  <worldbody>
    <body name="upper arm"><freejoint name="root:free"/><geom size="0.1"/></body>
    <body name="arm">
      <joint name="robot0:J-1"/><joint name="robot0_J_1" axis="0 1 0"/><geom size="0.1"/>
      <body name="fore arm" pos="0 0 1"><joint/><geom size="0.1"/>
        <body name="2nd" pos="0 0 1"><joint/><geom size="0.1"/></body></body>
    </body>
  </worldbody>
  <equality><joint joint1="robot0:J-1" joint2="robot0_J_1"/></equality>
  <actuator>
    <motor joint="robot0:J-1" ctrlrange="-1 1"/>
    <motor joint="robot0:J-1" ctrlrange="-1 1"/>
    <motor name="lambda" joint="robot0_J_1" ctrlrange="-1 1"/>
  </actuator>
  <sensor><jointpos joint="robot0:J-1"/><actuatorfrc actuator="lambda"/></sensor>
</mujoco>
"""


def test_names_become_columns_and_what_refers_to_them_follows() -> None:
    spec, plain = mujoco.MjSpec.from_string(NAMELESS), mujoco.MjModel.from_xml_string(NAMELESS)
    assert give_names(spec) == {
        "joint robot0:J-1": "robot0_J_1_2",
        "unnamed joint 2": "fore_arm_joint",
        "unnamed joint 3": "joint_2nd_joint",
        "unnamed actuator 0": "robot0_J_1_2",
        "unnamed actuator 1": "robot0_J_1_2_2",
        "actuator lambda": "actuator_lambda",
    }
    assert give_names(spec) == {}
    named = spec.compile()
    assert (named.actuator_trnid == plain.actuator_trnid).all()
    assert (named.sensor_objid == plain.sensor_objid).all()
    assert (named.eq_obj1id, named.eq_obj2id) == (plain.eq_obj1id, plain.eq_obj2id)


GANTRY = """
<mujoco>
  <worldbody>
    <body><joint name="x" type="slide" axis="1 0 0"/><geom size="0.1"/>
      <body><joint name="yaw" axis="0 0 1"/><geom size="0.1" pos="0.2 0 0"/></body></body>
  </worldbody>
  <actuator><motor name="fx" joint="x" ctrlrange="-1 1"/><motor name="motor1" joint="yaw" ctrlrange="-1 1"/></actuator>
</mujoco>
"""


def test_joints_and_their_motors_are_called_like_nothing_that_any_robot_has() -> None:
    """A slide x is no position that goes with an attitude, a hinge yaw no heading, its motor no rotor."""
    spec = mujoco.MjSpec.from_string(GANTRY)
    given = {"x": "joint_x", "yaw": "joint_yaw"}, {"fx": "actuator_fx", "motor1": "actuator_motor1"}
    kinds = ("joint", "actuator")
    expected = {f"{kind} {old}": new for kind, names in zip(kinds, given, strict=True) for old, new in names.items()}
    assert give_names(spec) == expected
    robot = Robot.from_mjcf(GANTRY, name="gantry")
    assert {*robot.layouts.state.joints} == {"joint_x", "joint_yaw"}
    assert robot.nominal().layouts.action.units["actuator_motor1"] == "N m"
    with pytest.raises(ModelError, match="a column of its own, found motor1, which means something else"):
        Robot.from_mjcf(GANTRY, name="gantry", actions={"actuator_motor1": "motor1"})


def test_rotors_keep_their_names() -> None:
    """They act at sites of a body that flies."""
    assert [*ROBOTS["hexarotor"].layouts.action] == [f"motor{number}" for number in range(1, 7)]


ARM = """
<mujoco>
  <worldbody><body><joint name="arm:lift" axis="0 1 0"/><geom size="0.1" pos="0 0 -0.3"/></body></worldbody>
  <actuator><motor joint="arm:lift" ctrlrange="-1 1"/></actuator>
</mujoco>
"""


def test_a_file_of_nameless_actuators_makes_a_model_and_says_what_it_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "arm.xml").write_text(ARM)
    main(["nominal", "mjcf", str(tmp_path / "arm.xml"), "--out", str(tmp_path / "arm")])
    said = " ".join(capsys.readouterr().out.split())
    assert "arm_lift_cmd N m commanded" in said
    assert "joint arm:lift → arm_lift, unnamed actuator 0 → arm_lift" in said


def test_a_joint_of_a_tendon_keeps_its_name_and_is_refused() -> None:
    tendon = '<tendon><fixed><joint joint="arm:lift" coef="1"/></fixed></tendon><actuator>'
    with pytest.raises(ModelError, match=r"joint 0, of a tendon: .* found 'arm:lift'"):
        Robot.from_mjcf(ARM.replace("<actuator>", tendon))
