"""The manoeuvre that is named really parts a pair: figures against physics, in flights of the plain simulator."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

import pytest
from noisy_flights import flights
from standard_set import Case, simulate_case

from sym2real.control import geometric_controller
from sym2real.diagnosis import Estimate, Finding
from sym2real.diagnosis.design.separation import UNTESTED, untested_notes, with_advice
from sym2real.diagnosis.estimate.preparation import whiten
from sym2real.diagnosis.estimate.whitening import Whitening
from sym2real.diagnosis.predict.candidate import candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.effects import effect
from sym2real.errors import ModelError
from sym2real.plants import MujocoPlant, run_episode
from sym2real.protocols import Change
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.tasks import make_task


@cache
def whitening(robot: Robot) -> Whitening:
    data = flights() if robot is CRAZYFLIE else simulate_case(Case("mushr", (), seed=11), rows=180)
    key = "wind" if robot is CRAZYFLIE else "gain:steer"
    library = Library.of(robot.nominal(), [effect(key, robot.nominal())])
    return whiten(Problem(library, data), candidates(library, data)).whitening


def advice(robot: Robot, key: str, values: dict[str, float], *others: str, plant: bool = True) -> str:
    parameters = {name: Estimate(value, value, value, "") for name, value in values.items()}
    shown = effect(key, robot.nominal()).shown_by
    found = Finding(key, parameters, 1.0, group=(key, *others), separate_by=shown)
    (said,) = with_advice([found], robot.nominal(), whitening(robot), MujocoPlant(robot) if plant else None)
    return said.separate_by


def explained(said: str, rival: str) -> float:
    share = re.search(rf"{rival} explains ([\d.e+-]+) %", said)
    assert share is not None, said
    return float(share[1])


def test_a_turning_heading_parts_a_tilted_sensor_from_wind() -> None:
    said = advice(CRAZYFLIE, "mounting_tilt", {"roll": 0.02}, "wind")
    assert said.startswith("hover with a heading that turns")
    assert explained(said, "wind") < 30


def test_turns_both_ways_part_a_steering_offset_from_a_gain() -> None:
    said = advice(MUSHR, "offset:steer", {"value": 0.05}, "gain:steer")
    assert "both ways" in said
    assert explained(said, "gain:steer") < 10


def test_a_simulator_that_runs_away_costs_the_advice_and_not_the_answer() -> None:
    def push(_: object, data: Any) -> None:
        data.xfrc_applied[:] = 1e13

    parameters = {"roll": Estimate(0.02, 0.02, 0.02, "")}
    found = Finding("mounting_tilt", parameters, 1.0, group=("mounting_tilt", "wind"), separate_by="a turn")
    runaway = MujocoPlant(CRAZYFLIE, [Change("a gale", force=push)])
    with pytest.raises(ModelError, match="beyond all measure"):
        run_episode(runaway, geometric_controller(CRAZYFLIE, make_task("hover", CRAZYFLIE).reference))
    assert with_advice([found], CRAZYFLIE.nominal(), whitening(CRAZYFLIE), runaway) == (found,)


def test_a_torque_and_a_centre_of_mass_stay_one_and_it_is_said() -> None:
    said = advice(CRAZYFLIE, "torque_bias", {"tx": 0.0, "ty": 2e-6}, "com_offset", "offset:wx_cmd")
    assert said.startswith("none of 6 manoeuvres")
    assert explained(said, "com_offset") > 95
    assert "no motion tells it from offset:wx_cmd" in said


def test_what_nothing_parts_is_not_simulated() -> None:
    said = advice(CRAZYFLIE, "added_mass", {"value": 0.003}, "gain:thrust")
    assert said == "no motion tells it from gain:thrust, but scales do: weigh the robot"


def test_without_a_simulator_one_note_says_that_advice_was_not_simulated() -> None:
    base = CRAZYFLIE.nominal()
    assert advice(CRAZYFLIE, "wind", {"fx": 0.01}, "mounting_tilt", plant=False) == effect("wind", base).shown_by
    found = [Finding("wind", {}, 1.0, group=("wind", *others)) for others in (("mounting_tilt",), ("mounting_tilt",))]
    assert untested_notes(found, base, None) == (UNTESTED,)
    assert untested_notes(found, base, MujocoPlant(CRAZYFLIE)) == ()
    assert untested_notes([Finding("wind", {}, 1.0, group=("wind",))], base, None) == ()


@pytest.mark.parametrize("others", [(), ("wind",)])
def test_a_finding_of_its_own_needs_no_advice(others: tuple[str, ...]) -> None:
    alone = Finding("linear_drag", {"cx": Estimate(0.01, 0.01, 0.01, "")}, 1.0, group=("linear_drag",))
    other = Finding("mounting_tilt", {"roll": Estimate(0.02, 0.02, 0.02, "")}, 1.0, group=("mounting_tilt", *others))
    said = with_advice([alone, other], CRAZYFLIE.nominal(), whitening(CRAZYFLIE), MujocoPlant(CRAZYFLIE))
    assert said[0].separate_by == ""
    assert bool(said[1].separate_by) is bool(others)
