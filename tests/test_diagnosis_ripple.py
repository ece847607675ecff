"""A torque that repeats along a joint, by MuJoCo's applied forces: how often it does, from logs with noise."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import two_links

from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.diagnosis.estimate.ripple import slowest_count
from sym2real.effects import effect
from sym2real.experiments.noisy_runs import noisy_runs
from sym2real.plants import MujocoPlant
from sym2real.robots import Robot
from sym2real.tasks import make_task
from sym2real.trajectory import Trajectory

LINKS = Robot.from_mjcf(two_links.MJCF, name="links", dt=0.02)
INERTIA = 0.02  # kg m²
WHEEL = f"""
<mujoco>
  <option timestep="0.0001" gravity="0 0 0"/>
  <worldbody>
    <body>
      <joint name="q" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="1" diaginertia="{INERTIA} {INERTIA} {INERTIA}"/>
    </body>
  </worldbody>
  <actuator><motor name="tau" joint="q" ctrlrange="-1 1"/></actuator>
</mujoco>
"""
RIPPLE, TRUTH = "torque_ripple:q1", {"count": 9.0, "sine": 0.3, "cosine": -0.2}


@cache
def logs(*rippling: str) -> Dataset:
    goals = [{"q1": side * 1.2, "q2": -side * 0.6} for side in (1.0, -1.0)]
    tasks = [make_task("regulate", LINKS, goal=goal) for goal in goals]
    return noisy_runs(LINKS, tasks, [(key, TRUTH) for key in rippling], count=6, rows=300, dither=2.5, seed=4)


def test_the_count_is_found_and_its_size_estimated() -> None:
    found = diagnose(LINKS.nominal(), logs(RIPPLE))
    assert [finding.effect for finding in found.findings] == [RIPPLE], found.summary
    values = found.findings[0].values
    assert values["count"] == pytest.approx(TRUTH["count"], rel=0.02)
    assert np.hypot(values["sine"], values["cosine"]) == pytest.approx(np.hypot(0.3, 0.2), rel=0.1)


def test_where_nothing_repeats_no_count_competes() -> None:
    found = diagnose(LINKS.nominal(), logs())
    assert (found.verdict, found.findings) == ("NOTHING_MISSING", ())
    assert {own.effect for own in found.not_tried} >= {RIPPLE, "torque_ripple:q2"}


def test_a_spring_that_hardens_repeats_nothing() -> None:
    """MuJoCo's own third coefficient; the joint passes less than two periods of what comes near it."""
    hardening = two_links.MJCF.replace('name="q1" axis', 'name="q1" stiffness="0 0 3" axis')
    rows = [two_links.swings(mjcf=hardening, seed=seed) for seed in range(3)]
    robot = Robot.from_mjcf(two_links.MJCF, name="links", dt=two_links.STEP)
    data = Dataset(Trajectory.from_arrays(own[:, 1:5], own[:, 5:7], robot.layouts, dt=two_links.STEP) for own in rows)
    found = diagnose(robot.nominal(), data)
    assert found.verdict == "UNEXPLAINED"
    assert RIPPLE not in {finding.effect for finding in found.findings}
    assert "q1_push that depends on q1" in found.summary
    assert slowest_count(data, "q1") * np.ptp(np.concatenate([own[:, 1] for own in rows])) == pytest.approx(4 * np.pi)


def test_a_ripple_does_as_much_work_one_way_as_it_takes_the_other() -> None:
    """Of a wheel that nothing else moves: with the integral of its force the energy stays, turn by turn."""
    robot = Robot.from_mjcf(WHEEL, name="wheel", dt=0.02)
    plant = MujocoPlant(robot, (effect("torque_ripple:q", robot).inject(count=4.0, sine=0.5, cosine=0.2),))
    states = [plant.reset(np.array([0.0, 12.0]))] + [plant.step(np.zeros(1)) for _ in range(200)]
    place, rate = np.stack(states).T
    potential = (0.5 * np.cos(4.0 * place) - 0.2 * np.sin(4.0 * place)) / 4.0
    energy = 0.5 * INERTIA * rate**2 + potential
    assert np.ptp(place) > 2 * np.pi
    assert np.ptp(energy) < 0.01 * np.ptp(potential)
