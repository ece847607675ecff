"""No file but a robot's own knows it: a registered copy under another name goes the whole way."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest
from quick_engines import Given
from standard_set import Case, simulate_case

from sym2real.adaptation import StageOne
from sym2real.dataset import Dataset
from sym2real.diagnosis import compare, diagnose
from sym2real.effects import effect
from sym2real.errors import ModelError
from sym2real.experiments.learning import learn_from_drives, learn_in_simulation, training_tasks
from sym2real.experiments.measured import measured
from sym2real.experiments.models import base_folder
from sym2real.regression import ENGINES
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS, Robot

KEY, FACTOR = "gain:thrust", {"value": 0.9}


@pytest.fixture(scope="module")
def hexa() -> Iterator[Robot]:
    robot = replace(CRAZYFLIE, name="hexa")
    ROBOTS.register("hexa", robot)
    yield robot
    del ROBOTS._entries["hexa"]


@pytest.fixture(scope="module")
def logs(hexa: Robot) -> Dataset:
    return simulate_case(Case("hexa", ((KEY, FACTOR),), seed=1), trajectories=4, rows=250)


def test_a_copy_of_a_robot_is_learned_like_it(hexa: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(ENGINES._entries, "beam", Given(CRAZYFLIE.nominal()))
    learned = learn_in_simulation(hexa, "beam", StageOne(1, 120, pushed=False), None, lambda _: None)
    assert learned.equations.robot == "hexa"
    assert learned.equations.numbers == CRAZYFLIE.numbers
    assert [task.name for task in training_tasks(hexa)] == ["hover", "circle", "lemniscate"]
    assert base_folder(hexa) != base_folder(CRAZYFLIE)
    assert measured("hexa").like.recipe.dependencies == CRAZYFLIE.recipe.dependencies


def test_a_copy_of_a_car_is_learned_from_its_drives(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(ENGINES._entries, "beam", Given(MUSHR.nominal()))
    copy = replace(MUSHR, name="other")
    assert learn_from_drives(copy, 1).equations.robot == "other"


@pytest.mark.slow
def test_what_is_wrong_with_a_copy_is_found(hexa: Robot, logs: Dataset) -> None:
    base = hexa.nominal()
    found = diagnose(base, logs)
    assert found.verdict == "EFFECT", found.summary
    assert KEY in (found.findings[0].effect, *found.findings[0].group)
    informed = effect(KEY, base).substitute(base, FACTOR)
    before, after = (compare(model, logs).horizons[-1].errors["position"].value for model in (base, informed))
    assert after < 0.5 * before


def test_a_name_is_registered_once(hexa: Robot) -> None:
    with pytest.raises(ModelError, match="hexa"):
        ROBOTS.register("hexa", hexa)
