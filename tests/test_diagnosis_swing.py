"""A force that swings is found with its frequency in flights whose paths swing too; where none does, none is found."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from noisy_flights import LEFT_OUT, flights_with, measured
from standard_set import Case, simulate_case
from torch import Tensor

from sym2real.control import Disturbed, GeometricQuadrotor
from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose, plan
from sym2real.diagnosis.estimate import swing
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.estimate.preparation import whiten
from sym2real.diagnosis.estimate.swing import Swing, find_swing
from sym2real.diagnosis.pipeline import prepare
from sym2real.diagnosis.predict.candidate import NO_SWING, candidates, library_for
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.question import Question
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects import applicable, effect
from sym2real.effects.inputs import ANGLE
from sym2real.experiments.excitation import ColouredNoise
from sym2real.experiments.models import cached_base
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import CRAZYFLIE, ROBOTS
from sym2real.stages import Stages
from sym2real.trajectory import Trajectory

OTHERS = (*LEFT_OUT, "rate_loop_gain", "mounting_tilt")
FORCE = {"fx": 0.012, "fy": 0.006, "omega": 7.0}


def found_in(data: Dataset, chance: float | None = None) -> Swing | None:
    library = library_for(CRAZYFLIE.nominal(), data, OTHERS)
    problem, tried = Problem(library, data), candidates(library, data)
    whitened = whiten(problem, tried)
    chance = SETTINGS.false_alarms_of_each(len(tried)) if chance is None else chance
    return find_swing(Problems(whitened.problem, whitened.whitening), whitened.values, chance)


@pytest.mark.slow
@pytest.mark.parametrize("chance", [None, 0.2])
def test_no_swing_is_found_in_flights_on_periodic_paths(chance: float | None) -> None:
    """Frequencies share the chance, of which there are dozens."""
    assert found_in(flights_with("", {}, steps=400), chance) is None


@pytest.mark.slow
def test_a_steady_wind_is_no_swing() -> None:
    assert found_in(flights_with("wind", {"fx": 0.02, "fy": 0.0}, steps=400)) is None


@pytest.mark.slow
def test_a_swing_is_named_with_its_frequency_and_size() -> None:
    data = flights_with("periodic_force", FORCE, steps=400)
    found = diagnose(CRAZYFLIE.nominal(), data, exclude=OTHERS)
    assert [one.effect for one in found.findings] == ["periodic_force"]
    (one,) = found.findings
    for name, value in FORCE.items():
        assert one.values[name] == pytest.approx(value, rel=0.1 if name != "omega" else 0.01)
    assert one.parameters["omega"].low <= FORCE["omega"] <= one.parameters["omega"].high
    assert found.gate.passed


@pytest.mark.slow
def test_the_angle_in_the_logs_is_the_one_that_the_force_had() -> None:
    data = flights_with("periodic_force", FORCE, steps=400)
    swing = found_in(data)
    assert swing is not None
    library = library_for(CRAZYFLIE.nominal(), data, OTHERS)
    values = library.null
    for slot, name in zip(library.indices("periodic_force"), ("fx", "fy"), strict=False):
        values[slot] = FORCE[name]
    told = CRAZYFLIE.nominal()
    true = effect("periodic_force", told).substitute(told, {**FORCE, "phase": swing.phases[0]})
    alone, first = library_for(true, Dataset([data[0]]), ("*",)), Dataset([data[0]])
    swung = Swing(FORCE["omega"], 0.0, swing.phases[:1]).in_data(first)
    expected = Problem(alone, first).residuals(alone.null[None])
    torch.testing.assert_close(Problem(library, swung).residuals(values[None]), expected, rtol=1e-6, atol=1e-9)
    assert np.allclose(np.cos(swing.phases), 1.0, atol=0.05)


@pytest.mark.slow
def test_a_swing_that_moves_a_car_more_than_all_else_is_no_disturbance() -> None:
    """What swings makes disturbances look larger, and so a large one was hidden where half of it was found."""
    size = {"fx": -4.6, "fy": 1.8, "omega": 4.1}
    data = simulate_case(Case("mushr", (("periodic_force", size),), seed=6))
    first = diagnose(cached_base(ROBOTS["mushr"]), data).findings[0]
    assert first.effect == "periodic_force"
    assert first.values["omega"] == pytest.approx(size["omega"], rel=0.005)
    assert np.hypot(first.values["fx"], first.values["fy"]) == pytest.approx(np.hypot(size["fx"], size["fy"]), rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("force", [0.0, 0.008], ids=["healthy", "a force that swings"])
def test_a_path_that_moves_at_the_frequency_of_a_force_hides_none_and_makes_none(force: float) -> None:
    """Hops from place to place have all frequencies, and more of these than such a force could make."""
    found = found_in(Dataset(hops(seed, force) for seed in range(4)))
    assert (found is not None) == (force > 0.0)
    if found is not None:
        assert found.omega == pytest.approx(4.3, rel=0.02)


def hops(seed: int, force: float) -> Trajectory:
    """A noisy flight from place to place, 1.6 s each, in a force of this many N that swings at 4.3 rad/s."""
    robot, rng = CRAZYFLIE, np.random.default_rng([11, seed])
    places = torch.as_tensor(rng.uniform([-0.7, -0.7, 0.6], [0.7, 0.7, 1.0], (6, 3)))

    def reference(time: Tensor) -> Tensor:
        hop = (time / 1.6).clamp(0.0, 4.999)
        part, (start, end) = (hop % 1.0)[..., None], (places[hop.long() + more] for more in (0, 1))
        state = torch.as_tensor(robot.start).repeat(*time.shape, 1)
        state[..., :3] = start + (end - start) * part**3 * (10 - 15 * part + 6 * part**2)
        state[..., 7:10] = (end - start) * 30 * (part * (1 - part)) ** 2 / 1.6
        return state

    changes = [effect("periodic_force", robot).inject(fx=force, fy=0.5 * force, omega=4.3)] if force else []
    tracking = GeometricQuadrotor(robot.mass, robot.low, robot.high, robot.dt, reference)
    dither = ColouredNoise(np.array([0.005, 0.15, 0.15, 0.15]), 0.05, robot.dt, rng)
    disturbed = Disturbed(tracking, dither.next, robot.low, robot.high)
    first = reference(torch.zeros((), dtype=torch.float64)).numpy()
    return measured(
        run_episode(MujocoPlant(robot, changes), disturbed, start=first, steps=400, name=f"hops {seed}"), rng
    )


@pytest.mark.slow
def test_a_swing_is_found_from_about_the_size_on_that_a_plan_announces() -> None:
    """The plan sees healthy flights alone; the force that swings is MuJoCo's."""
    announced = plan(CRAZYFLIE.nominal(), flights_with("", {}, steps=400), exclude=OTHERS).visible
    (smallest,) = (
        row.smallest for row in announced if (row.effect, row.parameter) == ("periodic_force", "fy") and row.smallest
    )
    large, small = (
        found_in(flights_with("periodic_force", {"fx": 0.0, "fy": times * smallest, "omega": 11.0}, steps=400))
        for times in (2.0, 0.25)
    )
    assert small is None
    assert large is not None
    assert large.omega == pytest.approx(11.0, rel=0.02)


def test_frequencies_are_searched_alike_however_many_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    data = flights_with("periodic_force", FORCE, steps=400)
    found = []
    for count in (7, 10_000):
        monkeypatch.setattr(swing, "AT_A_TIME", count)
        found.append(found_in(data))
    assert found[0] is not None
    assert found[0] == found[1]


@pytest.mark.parametrize("hidden", [FORCE, {}], ids=["swings", "healthy"])
def test_a_swing_is_settled_before_the_search_where_there_is_one_and_else_not_tested(hidden: dict[str, float]) -> None:
    """Its angle is in the logs then, and the force along it competes."""
    base, data = CRAZYFLIE.nominal(), flights_with("periodic_force" if hidden else "", hidden, steps=300)
    exclude = [known.key for known in applicable(base) if known.key not in ("periodic_force", "wind")]
    found = prepare(Question(base, data, exclude=exclude), Stages(lambda _: None))
    tried = {candidate.name for candidate in found.candidates}
    assert tried == {"wind", *(["periodic_force"] if hidden else [])}
    assert (found.swing is not None) is bool(hidden)
    assert all((ANGLE in log.extra) is bool(hidden) for log in found.checked.data)
    if found.swing is not None:
        assert found.swing.omega == pytest.approx(FORCE["omega"], rel=0.01)
    told = {left_out.effect: left_out.reason for left_out in found.not_tested}
    assert (told.get("periodic_force") == NO_SWING) is not bool(hidden)
