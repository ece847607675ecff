"""Which of the effects that are equal at one speed is named, where logs tell a little of other speeds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from noisy_flights import flights_with

from sym2real.dataset import Dataset
from sym2real.diagnosis import Diagnosis, diagnose
from sym2real.diagnosis.conclusion import Verdict
from sym2real.diagnosis.naming import Doubt, doubts, renamed
from sym2real.diagnosis.predict.competitors import EXCLUDED, NotTested
from sym2real.diagnosis.score.finding import Finding
from sym2real.diagnosis.unexplained.leftover import Leftover
from sym2real.effects.manoeuvres import steady_speed
from sym2real.effects.searching import LATER
from sym2real.robots import CRAZYFLIE, car, quadrotor
from sym2real.trajectory import Trajectory

# A car of full size: kg, kg m², m from the centre of mass to the axles, N/rad of an axle.
MASS, INERTIA, FRONT, REAR = 1500.0, 2200.0, 1.25, 1.45
STIFFNESS = 1500.0 * 9.81 * 13.0  # of both axles together
SLIP = 1.0 / (13.0 * 9.81)  # rad of the rear axle's slip per m/s², with the load's share of the stiffness
MODEL = car(FRONT + REAR, mass=MASS, time_constant=0.5, dt=0.05)
SUBSTEPS = 25


def drive(seed: int, speed: float, rows: int = 300) -> Trajectory:
    """How the rear axle of a single track with linear tyres moves (R. Rajamani, "Vehicle Dynamics and Control", 2.3).

    Its axles bear their load's share of the stiffness, so that it neither over- nor understeers.
    """
    rng = np.random.default_rng(seed)
    x = y = yaw = across = rate = 0.0
    along, states, actions, step = speed, [], [], 0.05 / SUBSTEPS
    for row in range(rows):
        if row % 10 == 0:
            command = np.array([rng.uniform(-0.06, 0.06), speed + rng.uniform(-0.3, 0.3)])
        outward = across - REAR * rate
        c, s = np.cos(yaw), np.sin(yaw)
        place, velocity = (x - REAR * c, y - REAR * s), (along * c - outward * s, along * s + outward * c)
        states.append([*place, s, c, *velocity, rate])
        actions.append(command)
        for _ in range(SUBSTEPS):
            shares = np.array([REAR, FRONT]) / (FRONT + REAR)
            slips = np.array([command[0] - (across + FRONT * rate) / along, -(across - REAR * rate) / along])
            front, rear = STIFFNESS * shares * slips
            along += step * (command[1] - along) / 0.5
            across += step * ((front + rear) / MASS - along * rate)
            rate += step * (FRONT * front - REAR * rear) / INERTIA
            yaw += step * rate
            x, y = (
                x + step * (along * np.cos(yaw) - across * np.sin(yaw)),
                y + step * (along * np.sin(yaw) + across * np.cos(yaw)),
            )
    noise = np.array([0.02, 0.02, 0.0, 0.0, 0.03, 0.03, 0.003])
    state = np.array(states) + noise * rng.standard_normal((rows, 7))
    heading = np.arctan2(state[:, 2], state[:, 3]) + 0.002 * rng.standard_normal(rows)
    state[:, 2], state[:, 3] = np.sin(heading), np.cos(heading)
    return Trajectory.from_arrays(state, np.array(actions), MODEL.layouts, dt=0.05, name=f"drive {seed}")


@pytest.mark.slow
def test_tyres_that_slip_are_named_before_an_arm_where_a_few_other_speeds_show_them() -> None:
    data = Dataset(drive(seed, speed) for seed, speed in enumerate((8.0, 8.2, 7.8, 8.1, 5.0, 11.0)))
    assert steady_speed(list(data))
    found = diagnose(MODEL, data)
    named = {finding.effect: finding for finding in found.findings}
    assert "lever_arm" not in named
    assert named["tyre_slip"].values["value"] == pytest.approx(SLIP, rel=0.1)
    assert "lever_arm" in named["tyre_slip"].group
    assert {entry.effect: entry.reason for entry in found.not_tried}["lever_arm"].startswith("another effect")


LEFT = Leftover("speed", "steer", 0.3, "")
UNTESTED = (NotTested("tyre_slip", "lever_arm stands for it"), NotTested("slope", "wind stands for it"))
ANSWER = Diagnosis("EFFECT", "", (), (Finding("lever_arm", {}, 1.0),), (LEFT,), not_tried=UNTESTED)


def test_a_name_is_doubtful_where_something_is_left_and_another_was_not_tested() -> None:
    data = Dataset([drive(0, 8.0)])
    assert doubts(ANSWER, MODEL, data) == (Doubt(("lever_arm",)),)
    assert doubts(replace(ANSWER, leftovers=()), MODEL, data) == ()
    assert doubts(replace(ANSWER, not_tried=()), MODEL, data) == ()
    assert doubts(replace(ANSWER, findings=()), MODEL, data) == ()


def test_what_is_the_same_on_every_flight_is_in_doubt_together() -> None:
    """A drag is relative to the mass: a weaker thrust in the place of more mass would change it and explain no more."""
    flights = flights_with("", {})
    untested = (NotTested("offset:thrust", "added_mass stands for it"),)
    heavier = replace(ANSWER, findings=(Finding("added_mass", {}, 1.0),), not_tried=untested)
    assert doubts(heavier, CRAZYFLIE.nominal(), flights)[:1] == (Doubt(("added_mass", "gain:thrust")),)


@pytest.mark.parametrize(
    ("verdict", "findings", "reason", "expected"),
    [
        ("EFFECT", (Finding("com_offset", {}, 0.9), Finding("gain:thrust", {}, 0.1, group=("added_mass",))), "b", True),
        ("EFFECT", (Finding("com_offset", {}, 1.0),), "b", False),
        ("UNEXPLAINED", (Finding("rotor_loss", {}, 1.0),), "b", True),
        ("UNEXPLAINED", (Finding("com_offset", {}, 0.9), Finding("added_mass", {}, 0.1)), EXCLUDED, False),
    ],
)
def test_a_load_is_in_doubt_where_what_stands_for_it_is_named_or_too_little(
    verdict: Verdict, findings: tuple[Finding, ...], reason: str, expected: bool
) -> None:
    answer = Diagnosis(verdict, "", (), findings, (LEFT,), not_tried=(NotTested("payload", reason),))
    own, data = (Doubt(("added_mass", "com_offset"), ("payload",)),), Dataset([drive(0, 8.0)])
    assert doubts(answer, CRAZYFLIE.nominal(), data) == (own if expected else ())
    assert doubts(answer, quadrotor(mass=0.03, attitude="measured"), data) == ()  # no rate is predicted


def test_markers_away_from_the_centre_of_mass_are_found_in_flight_where_something_is_left() -> None:
    """In every search the arm would take up what late velocities do."""
    found = diagnose(CRAZYFLIE.nominal(), flights_with("lever_arm", {"rx": 0.08, "rz": 0.05}))
    (arm,) = found.findings
    assert (found.verdict, arm.effect) == ("EFFECT", "lever_arm")
    for name, value in {"rx": 0.08, "ry": 0.0, "rz": 0.05}.items():
        assert arm.parameters[name].low <= value <= arm.parameters[name].high
        assert arm.parameters[name].high - arm.parameters[name].low < 0.02
    still = diagnose(CRAZYFLIE.nominal(), flights_with("", {}))
    later = "marker_tilt", "lever_arm"
    assert {entry.effect: entry.reason for entry in still.not_tried}.items() >= dict.fromkeys(later, LATER).items()
    doubtful = doubts(replace(still, leftovers=(LEFT,)), CRAZYFLIE.nominal(), flights_with("", {}))
    assert doubtful == tuple(Doubt((), (key,)) for key in later)
    without_rates, untested = quadrotor(mass=0.03, attitude="measured"), (NotTested("lever_arm", "needs wz"),)
    assert doubts(replace(ANSWER, not_tried=untested), without_rates, Dataset([drive(0, 8.0)])) == ()


def test_what_lost_its_name_is_said_to_stand_behind_another_effect() -> None:
    excluded = (NotTested("slope", EXCLUDED), NotTested("sensor_bias:x", EXCLUDED), UNTESTED[0])
    answer = renamed(replace(ANSWER, not_tried=excluded), ["sensor_*"])
    assert [entry.reason.startswith("another effect") for entry in answer.not_tried] == [True, False, False]
