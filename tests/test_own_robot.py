"""A robot that is known from its MJCF alone: one command makes a folder that holds it, whatever becomes of the file."""

import struct
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import two_links
from cli_results import Refused, result_of
from matplotlib.image import imsave
from scipy.spatial import ConvexHull

from sym2real.cli import main
from sym2real.effects import effect
from sym2real.experiments.models import robot_called
from sym2real.plants import MujocoPlant, load_plant, save_plant
from sym2real.robots import ROBOTS, Robot, own
from sym2real.robots.own import robot_of
from sym2real.symbolic import Equations, load_model, save_model
from sym2real.trajectory import Array


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A model folder ``arm`` and two logs; the file that it was made from is gone, and its name is another robot's."""
    place = tmp_path_factory.mktemp("own")
    (place / "arm.xml").write_text(two_links.MJCF)
    for seed in (1, 2):
        two_links.write(place / f"swing{seed}.csv", two_links.swings(load=0.3, seed=seed, seconds=8.0))
    logs = [str(place / f"swing{seed}.csv") for seed in (1, 2)]
    main(["nominal", "mjcf", str(place / "arm.xml"), "--log", *logs, "--out", str(place / "arm")])
    (place / "arm.xml").unlink()
    return place


def moved(plant: MujocoPlant, steps: int = 60) -> Array:
    """States of an episode under random commands."""
    rng, robot = np.random.default_rng(0), plant.robot
    states = [plant.reset(robot.start)]
    states += [plant.step(0.3 * rng.uniform(robot.low, robot.high)) for _ in range(steps)]
    return np.array(states)


def test_the_command_and_python_give_the_same_equations(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "arm.xml").write_text(two_links.MJCF)
    robot = Robot.from_mjcf(tmp_path / "arm.xml", dt=two_links.STEP)
    assert load_model(folder / "arm").to_json() == robot.nominal().to_json()
    assert Equations.from_json(robot.nominal().to_json()).origin == robot.nominal().origin


def test_the_robot_of_a_folder_is_that_of_its_file(folder: Path, tmp_path: Path) -> None:
    """Numbers of a description that MuJoCo writes have six digits."""
    (tmp_path / "arm.xml").write_text(two_links.MJCF)
    known, made = Robot.from_mjcf(tmp_path / "arm.xml", dt=two_links.STEP), robot_called(str(folder / "arm"))
    assert made.layouts == known.layouts
    assert made.numbers == known.numbers
    np.testing.assert_allclose(moved(MujocoPlant(made)), moved(MujocoPlant(known)), atol=1e-4)
    assert robot_of(load_model(folder / "arm")) is made
    assert made.name in ROBOTS  # which is another one


def test_what_is_made_of_a_model_holds_its_robot_too(folder: Path, tmp_path: Path) -> None:
    """`add` writes a model and a simulator: a mass in the hand there is the mass in the file's own simulator."""
    main(["add", str(folder / "arm"), "load:hand", "value=0.3", "--out", str(tmp_path / "heavier")])
    plant, robot = load_plant(tmp_path / "heavier" / "simulator"), robot_called(str(tmp_path / "heavier"))
    assert plant.robot is robot is robot_called(str(folder / "arm"))
    loaded = MujocoPlant(robot, (effect("load:hand", robot).inject(value=0.3),))
    np.testing.assert_allclose(moved(plant), moved(loaded), atol=1e-4)
    assert np.abs(moved(plant) - moved(MujocoPlant(robot))).max() > 0.05
    simulator = str(tmp_path / "heavier" / "simulator")
    main(["run", str(tmp_path / "heavier"), "regulate", "--plant", simulator, "--seconds", "0.1", "--samples", "32"])
    main(["simulate", simulator, "regulate", "--seconds", "0.5", "--out", str(tmp_path / "log.csv")])


@pytest.mark.slow
def test_every_question_has_an_answer_from_the_folder_alone(folder: Path, tmp_path: Path) -> None:
    model, logs = str(folder / "arm"), [str(folder / f"swing{seed}.csv") for seed in (1, 2)]
    assert result_of(["compare", model, *logs], tmp_path)["horizons"]
    found = result_of(
        ["diagnose", model, *logs, "--exclude", "*:tau?", "sensor_*", "--out", str(tmp_path / "a")], tmp_path
    )
    assert found["findings"][0]["effect"] == "load:hand"
    assert load_plant(tmp_path / "a" / "simulator").changes
    simulated = ["simulate", model, "regulate", "--seconds", "1", "--noise", "--out", str(tmp_path / "simulated.csv")]
    assert result_of(simulated, tmp_path)["rows"] == round(1 / two_links.STEP)
    of_logs = result_of(["plan", model, *logs, "--exclude", "*:tau?"], tmp_path)
    assert of_logs["seconds"] == pytest.approx(16.0, abs=0.1)
    known = result_of(["effects", "--robot", model], tmp_path)
    assert "load" in {row["name"] for row in known["effects"]}


@pytest.mark.slow
def test_goals_of_joints_are_planned_before_anything_moves(
    folder: Path, tmp_path: Path, refused: Refused, capsys: pytest.CaptureFixture[str]
) -> None:
    """Farther goals show smaller loads, and a joint's range is heeded."""

    def planned(*goals: str) -> dict[str, Any]:
        excluded = ["--exclude", "*:tau?", "*:q?", "delay", "lag"]
        return result_of(["plan", str(folder / "arm"), *goals, *excluded], tmp_path)

    near, far = (
        {row["effect"]: row["smallest"] for row in planned("regulate", f"q1={goal}")["visible"]} for goal in (0.1, 1.2)
    )
    assert far["load:hand"] < 0.5 * near["load:hand"]
    assert planned()["seconds"] == pytest.approx(16.0)
    assert "load:hand" in capsys.readouterr().out  # no picture of one
    for wrong, said in (("regulate q1=2.8", "its range"), ("circle", "'circle'"), ("regulate q9=1", "q9")):
        assert said in refused(f"plan {folder}/arm {wrong}")


def test_a_file_of_the_package_is_known_by_its_name_unless_it_is_asked_otherwise(tmp_path: Path) -> None:
    file = ROBOTS["cart_pole"].description.mjcf
    main(["nominal", "mjcf", file, "--out", str(tmp_path / "plain")])
    main(["nominal", "mjcf", file, "--dt", "0.01", "--out", str(tmp_path / "faster")])
    assert robot_called(str(tmp_path / "plain")) is ROBOTS["cart_pole"]
    assert robot_called(str(tmp_path / "faster")).dt == pytest.approx(0.01)


@pytest.mark.slow
def test_a_changed_file_is_a_target_that_the_plain_model_meets(
    refused: Refused, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("links.xml").write_text(two_links.MJCF)
    Path("heavier.xml").write_text(two_links.MJCF.replace('mass="', 'mass="1'))
    for name in ("links", "heavier"):
        main(["nominal", "mjcf", f"{name}.xml", "--out", name])
    flown = ["--seconds", "0.4", "--samples", "64"]
    plain, other = (
        result_of(["run", "links", "regulate", *flown, *target], tmp_path)["final"]
        for target in ([], ["--plant", "heavier"])
    )
    assert other != plain
    adapted = result_of(
        ["adapt", "links", "heavier", "regulate", "--rounds", "1", *flown, "--out", "adapted"], tmp_path
    )
    assert [entry["number"] for entry in adapted["rounds"]] == [0, 1]
    assert "heavier is a heavier; the model is of a crazyflie" in refused("run crazyflie hover --plant heavier")
    main(["nominal", "mjcf", "links.xml", "--dt", "0.01", "--out", "faster"])
    assert "control period of 0.02 s, found 0.01 s" in refused("run links regulate --plant faster")


def test_actuators_and_period_are_chosen_on_the_command_line(tmp_path: Path) -> None:
    (tmp_path / "links.xml").write_text(two_links.MJCF)
    asked = ["nominal", "mjcf", str(tmp_path / "links.xml"), "--actions", "tau2=elbow", "--dt", "0.005"]
    main([*asked, "--out", str(tmp_path / "links")])
    robot = robot_called(str(tmp_path / "links"))
    assert (robot.layouts.action.columns, robot.dt) == (("elbow",), 0.005)
    np.testing.assert_array_equal(robot.description.to_control(np.array([2.0])), [0.0, 2.0])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("none.xml", "none.xml"),
        ("links.xml --actions tau9", "did you mean 'tau"),
        ("links.xml --state q1 q3", "q3"),
        ("afloat.xml", "found joints that its actuators drive"),
        ("links.xml --spec log.toml", "found no --log"),
        ("links.xml --log unstamped.csv", "a column of stamps, or --dt"),
    ],
)
def test_what_cannot_be_is_refused_in_words(
    arguments: str, said: str, refused: Refused, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("links.xml").write_text(two_links.MJCF)
    afloat = '<body name="raft"><freejoint name="raft"/><geom size="0.1"/></body><body name="upper" pos="0 0 1">'
    Path("afloat.xml").write_text(two_links.MJCF.replace('<body name="upper" pos="0 0 1">', afloat))
    two_links.write(Path("unstamped.csv"), two_links.swings(seconds=0.3)[:, 1:], two_links.COLUMNS[1:])
    assert said in refused(f"nominal mjcf {arguments} --out out")
    assert not Path("out").exists()


def test_meshes_and_includes_need_not_lie_beside_a_folder(tmp_path: Path) -> None:
    """A mesh gives its body a mass, and touches: both stay, of the convex hull that MuJoCo lets touch."""
    source = tmp_path / "robot"
    (source / "meshes").mkdir(parents=True)
    write_stl(source / "meshes" / "link.stl")
    (source / "floor.xml").write_text(
        '<mujocoinclude><worldbody><geom name="floor" type="plane" size="5 5 1"/></worldbody></mujocoinclude>'
    )
    (source / "robot.xml").write_text(MESHED)
    robot = Robot.from_mjcf(source / "robot.xml")
    save_model(robot.nominal(), tmp_path / "model")
    save_plant(robot, [("load:tip", {"value": 0.2})], tmp_path / "plant")
    before = touches(MujocoPlant(robot))
    plain = [moved(MujocoPlant(robot)), moved(MujocoPlant(robot, (effect("load:tip", robot).inject(value=0.2),)))]
    for file in sorted(source.rglob("*.*")):
        file.unlink()
    made = robot_called(str(tmp_path / "model"))
    np.testing.assert_allclose(moved(MujocoPlant(made)), plain[0], atol=1e-4)
    np.testing.assert_allclose(moved(load_plant(tmp_path / "plant")), plain[1], atol=1e-4)
    assert touches(MujocoPlant(made)) == before
    assert any(before)
    assert not all(before)


def test_what_mujoco_cannot_write_without_its_meshes_is_refused_by_its_file(
    tmp_path: Path, refused: Refused, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(_: str) -> str:
        raise ValueError("a mesh\nof no volume")

    monkeypatch.setattr(own, "alone", failing)
    (tmp_path / "links.xml").write_text(two_links.MJCF)
    said = refused(f"nominal mjcf {tmp_path}/links.xml --out {tmp_path}/out")
    assert f"{tmp_path}/links.xml: expected" in said
    assert "found: a mesh of no volume" in said


def test_a_field_of_heights_stays_a_file_so_that_no_simulator_goes_with_the_model(
    tmp_path: Path, refused: Refused, capsys: pytest.CaptureFixture[str]
) -> None:
    imsave(tmp_path / "hills.png", np.random.default_rng(0).uniform(size=(4, 4)))
    hills = '<asset><hfield name="hills" file="hills.png" size="1 1 0.1 0.1"/></asset><worldbody>'
    ground = '<geom type="hfield" hfield="hills" pos="0 0 -1"/>'
    (tmp_path / "hilly.xml").write_text(two_links.MJCF.replace("<worldbody>", hills + ground))
    main(["nominal", "mjcf", str(tmp_path / "hilly.xml"), "--out", str(tmp_path / "hilly")])
    assert "no simulator goes with the model" in " ".join(capsys.readouterr().out.split())
    log = two_links.write(tmp_path / "log.csv", two_links.swings(seconds=4.0))
    assert result_of(["compare", str(tmp_path / "hilly"), str(log)], tmp_path)["horizons"]
    said = refused(f"simulate {tmp_path}/hilly regulate --out {tmp_path}/new.csv")
    assert "expected the model of a robot that has a description" in said


MESHED = """
<mujoco model="meshed">
  <compiler meshdir="meshes" inertiafromgeom="true"/>
  <include file="floor.xml"/>
  <asset>
    <texture name="grey" type="2d" builtin="checker" width="8" height="8"/>
    <material name="grey" texture="grey"/>
    <mesh name="sheet" inertia="shell" vertex="0 0 0  0.1 0 0  0 0.1 0  0.1 0.1 0" face="0 1 2  1 3 2"/>
    <mesh name="link" file="link.stl" scale="1 1 1.5" refpos="0.01 0 0.02"/>
  </asset>
  <worldbody>
    <body name="link" pos="0 0 0.4" euler="10 0 0">
      <joint name="swing" axis="0 1 0"/>
      <geom type="mesh" mesh="link" pos="0.01 0 0" euler="0 5 0" material="grey"/>
      <geom type="mesh" mesh="link" contype="0" conaffinity="0" mass="0.1"/>
      <geom type="mesh" mesh="sheet" contype="0" conaffinity="0" mass="0.05"/>
      <site name="tip" pos="0 0 -0.3"/>
    </body>
  </worldbody>
  <actuator><motor name="torque" joint="swing" ctrlrange="-2 2"/></actuator>
</mujoco>
"""


def write_stl(file: Path) -> None:
    """A lump of random corners with a dent, longer below its joint than above."""
    corners = np.random.default_rng(0).normal(size=(40, 3)) * [0.04, 0.03, 0.1] + [0.0, 0.01, -0.15]
    inside, triangles = corners.mean(axis=0), []
    top, *faces = corners[ConvexHull(corners).simplices]
    dent = (top.sum(axis=0) + inside) / 4
    for a, b, c in [*faces, *((top[i - 1], top[i], dent) for i in range(3))]:
        outwards = np.cross(b - a, c - a) @ (a - inside) > 0
        triangles.append(np.concatenate([np.zeros(3), a, *((b, c) if outwards else (c, b))]))
    packed = b"".join(struct.pack("<12fH", *triangle, 0) for triangle in triangles)
    file.write_bytes(bytes(80) + struct.pack("<I", len(triangles)) + packed)


def touches(plant: MujocoPlant) -> list[bool]:
    """Where on its way around the link meets the floor."""
    met = []
    for angle in np.linspace(0.0, 2 * np.pi, 60):
        plant.reset([angle, 0.0])
        mujoco.mj_forward(plant.mj_model, plant.mj_data)
        met.append(bool(plant.mj_data.ncon))
    return met
