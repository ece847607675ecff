"""The floor against the errors of a model that misses nothing: equations and simulator agree, noise is known."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset
from sym2real.diagnosis import compare
from sym2real.diagnosis.conclusion import Parts
from sym2real.diagnosis.errors.floor import Floor, SensorNoise, floor_of_explained, no_higher_than_reached
from sym2real.diagnosis.errors.rungs import HeldOut, Rung, RungError
from sym2real.diagnosis.estimate.whitening import Spread, estimate
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.score.finding import Finding
from sym2real.diagnosis.score.held_out import Gate
from sym2real.diagnosis.unexplained.explaining import disturbance_notes
from sym2real.experiments.standard_conditions import ANGLE_NOISE, POSITION_NOISE
from sym2real.logs.differences import rates_on_time
from sym2real.plants import MujocoPlant
from sym2real.report.summary import summary
from sym2real.robots import CRAZYFLIE, Robot
from sym2real.trajectory import Trajectory


def stage(value: float) -> Rung:
    """Errors of a rung 0.8 s ahead."""
    return Rung("", {0.8: {"position": RungError(value, value, value, value, "m")}})


@pytest.fixture(scope="module")
def flights() -> Dataset:
    """As they are once they have been checked: velocities by differences are slopes."""
    return rates_on_time(simulate_case(Case("crazyflie", (), seed=3), trajectories=3, rows=250))


def test_the_noise_of_the_sensors_is_found_and_velocity_by_slopes_is_recognised(flights: Dataset) -> None:
    noise = SensorNoise.of(flights)
    assert noise.slopes == {6: 0, 7: 1, 8: 2}
    np.testing.assert_allclose(noise.deviation[:3], POSITION_NOISE, rtol=0.1)
    np.testing.assert_allclose(noise.deviation[3:6], ANGLE_NOISE, rtol=0.1)
    np.testing.assert_allclose(noise.of_a_row[6:9], np.sqrt(0.5) * POSITION_NOISE / 0.02, rtol=0.1)


def test_drawing_the_noise_once_more_doubles_its_variance(flights: Dataset) -> None:
    once = SensorNoise.of(flights)
    rng = np.random.default_rng(0)
    twice = SensorNoise.of(Dataset([once.added_to(trajectory, rng) for trajectory in flights]))
    np.testing.assert_allclose(twice.deviation[:6], np.sqrt(2) * once.deviation[:6], rtol=0.15)
    assert twice.slopes == once.slopes


def test_short_predictions_of_the_right_model_err_by_noise_alone(flights: Dataset) -> None:
    comparison = compare(CRAZYFLIE.nominal(), flights, horizons=(0.1, 0.2, 0.8))
    floor = {one.horizon: one.errors for one in comparison.floor}
    for errors in comparison.horizons[:2]:
        for channel in ("position", "attitude", "velocity"):
            # Seventy windows that overlap: the error itself is known to about a fifth.
            assert floor[errors.horizon][channel][0] == pytest.approx(errors.errors[channel].value, rel=0.25)
    # Later the pushes that the right model does not know count as well.
    assert floor[0.8]["position"][0] < comparison.horizons[2].errors["position"].value


WHEEL = """
<mujoco model="wheel">
  <option timestep="0.001"/>
  <worldbody>
    <body name="wheel" pos="0 0 1">
      <joint name="turn" axis="0 1 0"/>
      <geom type="cylinder" size="0.1 0.02" mass="1" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
  <actuator><motor name="torque" joint="turn" ctrlrange="-1 1" ctrllimited="true"/></actuator>
</mujoco>
"""


def test_what_a_start_smooths_away_is_in_the_floor() -> None:
    """A torque that changes in every row: no polynomial follows the rate, which is measured with little noise."""
    robot, rng = Robot.from_mjcf(WHEEL, name="wheel", dt=0.01), np.random.default_rng(0)
    plant, sent = MujocoPlant(robot), rng.normal(0.0, 0.05, (600, 1))
    state = np.array([plant.reset(), *(plant.step(torque) for torque in sent[:-1])])
    noisy = state + rng.normal(0.0, [1e-3, 0.01], state.shape)
    log = Trajectory.from_arrays(noisy, sent, robot.layouts, dt=0.01, name="dithered")
    found = compare(robot.nominal(), [log], horizons=(0.1, 0.5))
    floor = {level.horizon: level.errors for level in found.floor}
    for errors in found.horizons:
        for channel, error in errors.errors.items():
            assert floor[errors.horizon][channel][0] == pytest.approx(error.value, rel=0.2)


def test_the_floor_of_the_explained_model_is_its_error(flights: Dataset) -> None:
    library = Library.of(CRAZYFLIE.nominal(), [])
    problem = Problem(library, flights)
    spread = Spread.of(problem, library.null)
    segments = problem.segments
    whitening = estimate(spread, problem.residuals(library.null[None])[0], segments.noise, segments.channel)
    held = HeldOut(library, flights)
    horizons = held.horizons(0.8)
    (stage,) = held.ladder([("right", library.null[None])], horizons)
    floor = floor_of_explained(held, library.null, whitening, horizons)
    assert [one.horizon for one in floor] == [0.1, 0.2, 0.5, 0.8]
    for one in floor:
        for channel in ("position", "attitude", "velocity", "rate"):
            # Good to a third: trim of a run outlasts the disturbances that the whitening knows, and where the noise
            # that is drawn makes the start's estimator choose another polynomial, the change counts as error.
            assert 0.75 < one.errors[channel][0] / stage.horizons[one.horizon][channel].value < 1.35


def test_a_noisier_start_raises_the_floor(flights: Dataset) -> None:
    library = Library.of(CRAZYFLIE.nominal(), [])
    problem = Problem(library, flights)
    spread = Spread.of(problem, library.null)
    ones = torch.ones(len(problem.segments.compared), dtype=torch.float64)
    power = torch.full((len(spread.names),), 1e-8, dtype=torch.float64)
    noise, held = torch.as_tensor(problem.segments.noise), HeldOut(library, flights)
    plain, noisy = (
        floor_of_explained(held, library.null, spread.whitening((size * noise * ones).square(), power), (0.5,))
        for size in (1.0, 3.0)
    )
    for channel, (value, _) in plain[0].errors.items():
        assert noisy[0].errors[channel][0] > (1.5 if channel != "velocity" else 1.05) * value


def test_no_floor_stands_above_what_was_reached() -> None:
    floor = [Floor(0.8, {"position": (0.14, "m")}), Floor(0.2, {"position": (0.01, "m")})]
    lowered = no_higher_than_reached(floor, [stage(0.5), stage(0.04), stage(0.05)])
    assert lowered == (Floor(0.8, {"position": (0.04, "m")}), floor[1])
    assert no_higher_than_reached(floor, [stage(0.5)]) == tuple(floor)


@pytest.mark.parametrize(("noise", "said"), [(0.03, True), (0.045, False), (None, False)])
def test_disturbances_that_make_most_of_the_floor_are_said(noise: float | None, said: bool) -> None:
    floor = Floor(0.8, {"position": (0.06, "m")}, {} if noise is None else {"position": noise})
    lines = disturbance_notes([floor])
    assert bool(lines) == said
    assert not said or "the position error 2.0 times that of noise alone" in lines[0]
    assert disturbance_notes([]) == ()


@pytest.mark.parametrize(("noise", "words"), [(0.03, "and small disturbances."), (0.01, "error 6.0 times as large.")])
def test_disturbances_are_small_or_said_to_be_as_large_as_they_are(noise: float, words: str) -> None:
    floor = Floor(0.8, {"position": (0.06, "m")}, {"position": noise})
    said = summary("NOTHING_MISSING", Parts(floor=(floor,)))
    assert said.startswith("Nothing is missing beyond noise")
    assert said.endswith(words)


@pytest.mark.parametrize(("noise", "said"), [(0.03, False), (0.01, True)])
def test_an_effect_is_announced_with_the_disturbances_that_stay_large(noise: float, said: bool) -> None:
    """An integrator in three servos was three gains, and errors 29 times noise."""
    floor = Floor(0.8, {"position": (0.06, "m")}, {"position": noise})
    gate = Gate(stage(0.5), stage(0.06))
    sentence = summary("EFFECT", Parts(findings=(Finding("wind", {}, 1.0),), gate=gate, floor=(floor,)))
    told = "disturbances that nothing explains make the position error 6.0 times that of noise alone"
    assert (told in sentence) == said
