"""Whole flights on a clock that the test owns: start, task, every fault, landing."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hardware.errors import LinkError, UnreachableError
from hardware.interfaces import Reading, Verdict
from hardware.pilot import FlightPilot
from hardware.plant import HardwarePlant
from hardware.row import Row
from sym2real.adaptation import Adaptation, Adapting, adapt, tracking_error
from sym2real.adaptation.target import Flights
from sym2real.control import geometric_controller
from sym2real.effects import effect
from sym2real.errors import ShapeError
from sym2real.experiments.learners import NoResidual
from sym2real.plants import run_episode
from sym2real.protocols import Controller
from sym2real.robots import CRAZYFLIE
from sym2real.tasks import make_task
from sym2real.trajectory import Array
from tests.hardware_link import SimulatedLink, TestClock

PLACE = np.array([0.3, 0.2, 0.8, 1.0, *[0.0] * 9])
REST = CRAZYFLIE.rest
LANDED = 0.0125 + 0.04 + 0.001  # m: on the ground, touch-down, and a little


class Held:
    """A controller that is now and then held up, and keeps its last action where it is told no state."""

    def __init__(self, controller: Controller, clock: TestClock) -> None:
        self.controller, self.clock, self.last = controller, clock, REST
        self.reset, self.remember = controller.reset, controller.remember

    def act(self, state: Array, step: int, inputs: Array | None = None) -> Array:
        if step % 40 == 39:
            self.clock.time += 0.04
        if np.isfinite(state).all():
            self.last = self.controller.act(state, step, inputs)
        return self.last


class Flown:
    """A plant on a simulated link, with what it recorded."""

    def __init__(self, *effects: tuple[str, dict[str, float]]) -> None:
        self.clock = TestClock()
        self.link = SimulatedLink(self.clock, [effect(key, CRAZYFLIE).inject(**values) for key, values in effects])
        self.rows: list[Row] = []
        self.pilot = FlightPilot(CRAZYFLIE)
        self.plant = HardwarePlant(self.link, self.pilot, clock=self.clock, record=self.rows.append, guard=False)

    def hover(self, seconds: float) -> Array:
        """Hold the place by the geometric controller; the last state."""
        controller = geometric_controller(CRAZYFLIE, make_task("hover", CRAZYFLIE, goal=PLACE[:3]).reference)
        state = self.plant.reset(PLACE)
        for step in range(round(seconds / self.plant.dt)):
            state = self.plant.step(controller.act(state, step))
        return state

    def down(self) -> None:
        """Go on until the flight has ended."""
        while not self.plant.crashed:
            self.plant.step(REST)

    def entered(self) -> tuple[float, str]:
        """When the flight was first no longer "go", s, and its phase then."""
        first = next(row for row in self.rows if row.command.verdict is not Verdict.GO)
        return first.reading.time, first.command.phase


def test_a_task_flies_as_in_simulation() -> None:
    """Take-off, an episode of the simulator's own loop, landing; what the log holds is what was sent."""
    flown, task = Flown(), make_task("circle", CRAZYFLIE)
    trajectory = run_episode(flown.plant, geometric_controller(CRAZYFLIE, task.reference), task, steps=200)
    flown.plant.land()
    assert len(trajectory) == 200
    assert tracking_error(trajectory) < 0.1
    assert flown.plant.ended == "the task is over"
    assert flown.link.stopped
    assert flown.link.plant.true_state[2] < LANDED
    assert abs(flown.link.plant.true_state[9]) < 0.5


def test_the_start_is_reached_with_a_fifth_of_the_thrust_missing() -> None:
    flown = Flown(("gain:thrust", {"value": 0.79}), ("added_mass", {"value": 0.005}))
    state = flown.plant.reset(PLACE)
    assert np.linalg.norm(state[:3] - PLACE[:3]) < 0.1
    flown.plant.land()
    assert flown.link.plant.true_state[2] < LANDED


def test_a_flight_that_missed_periods_and_poses_is_learned_from_at_its_true_times() -> None:
    """Four times another program takes the processor for two periods; twice a pose comes too late for a velocity."""
    flown, task = Flown(), make_task("circle", CRAZYFLIE)
    measured, late = flown.link.state, (180, 240)

    def seen() -> Reading:
        reading = measured()
        if len(flown.rows) in late:
            reading.state[7:10] = math.nan
        return reading

    def controller(*_: object, **__: object) -> Held:
        return Held(geometric_controller(CRAZYFLIE, task.reference), flown.clock)

    flown.link.state = seen  # type: ignore[method-assign]
    flights = Flights(flown.plant, CRAZYFLIE, task, 200, None, 0, lambda _: None, controller)
    log = flights.log(0, CRAZYFLIE.nominal())
    assert (flown.plant.ended, flown.link.stopped) == ("the task is over", True), "it has landed before a model trains"
    assert flown.plant.missed == 4
    assert all(np.isnan(flown.rows[row].reading.state).any() for row in late)
    assert flights.judged(log)[0] is False, "no row is missing, so it is no crash"
    assert np.isfinite(log[0].state).all()
    np.testing.assert_allclose(np.diff(log[0].time), CRAZYFLIE.dt)
    way, speed = np.diff(log[0].state[:, :3], axis=0), log[0].state[:, 7:10]
    np.testing.assert_allclose(way, CRAZYFLIE.dt * (speed[1:] + speed[:-1]) / 2, atol=2e-3)


def flown_to_the_end(cause: Callable[[Flown], None], folder: Path | None = None) -> tuple[Flown, Adaptation]:
    """An adaptation of one round, whose first flight has a cause to end after a second of its task."""
    flown, task = Flown(), make_task("circle", CRAZYFLIE)
    read = flown.link.state

    def seen() -> Reading:
        if sum(row.stage == "task" for row in flown.rows) == 50:
            cause(flown)
        return read()

    def controller(*_: object, **__: object) -> Controller:
        return geometric_controller(CRAZYFLIE, task.reference)

    flown.link.state = seen  # type: ignore[method-assign]
    settings = Adapting(rounds=1, steps=100, until_settled=False)
    return flown, adapt(
        CRAZYFLIE.nominal(), flown.plant, task, NoResidual(), settings, folder=folder, controller=controller
    )


@pytest.mark.parametrize(
    ("cause", "words"),
    [
        (
            lambda flown: setattr(flown.link, "battery", 3.0),
            r"battery low: 3\.00 V: no fault.*; change the battery, then",
        ),
        (lambda flown: flown.link.lost.setdefault("pose", flown.clock.now()), "no pose.*: no fault.*look at the radio"),
        (lambda flown: flown.link.flags.add("lost"), "the link to the robot has ended: no fault.*look at the radio"),
    ],
)
def test_a_flight_that_no_model_ended_does_not_count(
    cause: Callable[[Flown], None], words: str, tmp_path: Path
) -> None:
    """It was a crash of the model that flew it. The same command flies that round again."""
    with pytest.raises(LinkError, match=f"{words}.*the same command again"):
        flown_to_the_end(cause, tmp_path)
    assert not list(tmp_path.rglob("log.parquet"))
    _, adapted = flown_to_the_end(lambda _: None, tmp_path)
    assert [(report.rows, report.crashed) for report in adapted.reports] == [(100, False)] * 2


def test_a_flight_that_its_actions_ended_is_a_crash() -> None:
    """Its next round needs a person: the run ends there, and the log of the crash is kept."""
    flown = Flown()
    task = make_task("circle", CRAZYFLIE)

    def wild(*_: object, **__: object) -> Controller:
        return geometric_controller(CRAZYFLIE, make_task("hover", CRAZYFLIE, goal=(9.0, 0.0, 1.0)).reference)

    flights = Flights(flown.plant, CRAZYFLIE, task, 400, None, 0, lambda _: None, wild)
    log = flights.log(0, CRAZYFLIE.nominal())
    assert "fence" in flown.plant.ended
    assert flights.judged(log)[0] is True


def test_what_was_sent_is_told_apart_from_what_was_asked() -> None:
    flown = Flown()
    flown.plant.reset(PLACE)
    flown.plant.step(REST)
    assert flown.plant.sent == pytest.approx(REST * [0.99, 1, 1, 1])
    assert flown.rows[-1].asked == pytest.approx(REST)
    assert flown.rows[-1].sent == pytest.approx(flown.plant.sent)


def test_a_wild_action_is_clipped_and_one_that_is_none_lands() -> None:
    flown = Flown()
    flown.hover(0.2)
    flown.plant.step(np.array([1e9, -1e9, 1e9, -1e9]))
    assert flown.link.sent[-1] == pytest.approx(
        [CRAZYFLIE.high[0], CRAZYFLIE.low[1], CRAZYFLIE.high[2], CRAZYFLIE.low[3]]
    )
    flown.plant.step(np.full(4, math.nan))
    assert "finite" in flown.plant.ended


@pytest.mark.parametrize("source", ["pose", "attitude"])
def test_lost_data_land_blind(source: str) -> None:
    flown = Flown()
    flown.hover(1.0)
    flown.link.lost[source] = lost = flown.clock.now()
    flown.down()
    when, phase = flown.entered()
    assert phase == "blind landing"
    assert 0.0 < when - lost - 0.2 < 0.05
    blind = [row for row in flown.rows if row.command.phase == "blind landing"]
    assert blind[-1].reading.time - blind[0].reading.time <= 3.0 + 0.05
    learned = flown.pilot.safe.hover / CRAZYFLIE.rest[0]
    assert learned == pytest.approx(1.0, rel=0.005)  # of a robot whose map and mass are right
    assert blind[0].sent[0] == pytest.approx(0.99 * 0.94 * learned * CRAZYFLIE.rest[0])
    assert flown.link.stopped


def while_blind(flown: Flown, happens: Callable[[], None]) -> None:
    """Land, and let something happen once that is blind."""
    measured = flown.link.state

    def seen() -> Reading:
        if flown.rows[-1].command.phase == "blind landing":
            happens()
        return measured()

    flown.link.state = seen  # type: ignore[method-assign]
    flown.down()


def test_a_link_that_ends_while_it_lands_without_attitude_is_the_reason() -> None:
    flown = Flown()
    flown.hover(0.5)
    flown.link.lost["attitude"] = flown.clock.now()
    while_blind(flown, lambda: flown.link.flags.add("lost"))
    reasons = list(dict.fromkeys(row.command.reason for row in flown.rows if row.command.reason))
    assert "no attitude" in reasons[0]
    assert reasons[1:] == [flown.plant.ended] == ["the link to the robot has ended"]


@pytest.mark.parametrize("gain", [0.8, 1.2])
def test_a_blind_landing_goes_down_where_the_thrust_map_is_wrong(gain: float) -> None:
    """By the weight alone a robot with a fifth more thrust than its map says climbs to 6 m until its motors are cut."""
    flown = Flown(("gain:thrust", {"value": gain}))
    flown.plant.reset(PLACE)
    flown.link.lost["pose"] = flown.clock.now()
    while not flown.plant.crashed:
        flown.plant.step(REST / gain)
    heights, climbs = np.array(
        [row.reading.state[[2, 9]] for row in flown.rows if row.command.phase == "blind landing"]
    ).T
    assert heights.max() < heights[0] + 0.02
    assert climbs.min() > -1.5
    assert flown.link.plant.true_state[2] < LANDED


def test_a_landing_steers_again_when_poses_come_back() -> None:
    flown = Flown()
    flown.hover(1.0)
    flown.link.lost["pose"] = flown.clock.now()
    while_blind(flown, flown.link.lost.clear)
    phases = [row.command.phase for row in flown.rows if row.command.verdict is not Verdict.GO]
    assert phases.index("blind landing") < phases.index("land")
    assert phases[-1] == "cut"
    assert np.linalg.norm(flown.link.plant.true_state[:2] - PLACE[:2]) < 0.2


def test_levelling_turns_upright_without_a_position() -> None:
    """Tilted by 30° about an axis between x and y when poses are lost, it is level within half a second."""
    flown = Flown()
    flown.plant.reset(PLACE)
    tilted = PLACE.copy()
    tilted[3:7] = [math.cos(0.26), math.sin(0.26) * 0.6, math.sin(0.26) * 0.8, 0.0]
    flown.link.plant.reset(tilted)
    flown.link.lost["pose"] = flown.clock.now() - 1.0
    flown.down()
    blind = [row for row in flown.rows if row.command.phase == "blind landing"]
    assert abs(blind[25].reading.state[4:6]).max() < 0.02


def test_the_fence_lands_inside_it() -> None:
    flown = Flown()
    flown.hover(0.5)
    outside = PLACE.copy()
    outside[0] = 1.6
    flown.link.plant.reset(outside)
    flown.down()
    assert "fence: x" in flown.plant.ended
    assert flown.link.plant.true_state[0] < 1.55


def test_a_tumbled_robot_is_cut_at_once() -> None:
    flown = Flown()
    flown.hover(0.2)
    flown.link.flags.add("tumbled")
    before = len(flown.rows)
    for _ in range(2):
        flown.plant.step(REST)
    assert flown.plant.ended == "the robot says it is tumbled"
    assert len(flown.rows) <= before + 3
    assert flown.link.stopped


def test_a_low_battery_lands_and_a_gust_of_thrust_does_not() -> None:
    flown = Flown()
    state = flown.hover(0.5)
    controller = geometric_controller(CRAZYFLIE, make_task("hover", CRAZYFLIE, goal=PLACE[:3]).reference)
    for step in range(100):
        flown.link.battery = 3.1 if step % 10 < 5 else 3.6  # 0.1 s low, 0.1 s not
        state = flown.plant.step(controller.act(state, step))
    assert not flown.plant.crashed
    flown.link.battery, low = 3.1, flown.clock.now()
    while not flown.plant.crashed:
        state = flown.plant.step(controller.act(state, 0))
    assert "battery" in flown.plant.ended
    assert flown.entered()[0] - low < 0.5


def test_late_actions_are_counted_and_end_the_flight() -> None:
    flown = Flown()
    flown.hover(0.2)
    for _ in range(4):
        flown.clock.time += 0.025  # the controller takes longer than the period
        flown.plant.step(REST)
    flown.plant.step(REST)  # in time: the count begins anew
    assert not flown.plant.crashed
    for _ in range(7):
        flown.clock.time += 0.025
        flown.plant.step(REST)
    assert "in a row were late" in flown.plant.ended


def test_periods_stay_on_the_grid() -> None:
    """An oversleep shifts one period, not all that follow; a period that has gone by is left out and counted."""
    flown = Flown()
    flown.hover(0.1)
    start = flown.rows[-1].reading.time
    for _ in range(10):
        flown.clock.late = 0.004
        flown.plant.step(REST)
    flown.clock.late = 0.065
    flown.plant.step(REST)
    flown.plant.step(REST)
    flown.plant.step(REST)
    times = np.array([row.reading.time for row in flown.rows]) - start
    assert times[-12:-3] == pytest.approx(0.004 + 0.02 * np.arange(2, 11))
    assert flown.plant.missed == 3
    assert times[-1] == pytest.approx(0.02 * round(times[-1] / 0.02))


def test_a_silent_controller_is_landed_and_may_fly_again() -> None:
    flown = Flown()
    flown.hover(0.2)
    silent = flown.clock.now()
    flown.plant.watch()
    assert not flown.plant.crashed
    flown.clock.time += 0.125
    flown.plant.watch()
    assert "no action" in flown.plant.ended
    assert flown.entered()[0] - silent < 0.5
    assert flown.plant.crashed
    assert np.linalg.norm(flown.plant.reset(PLACE)[:3] - PLACE[:3]) < 0.1
    assert not flown.plant.crashed


def test_the_start_is_held_until_the_first_action_comes() -> None:
    """A controller that begins with a second of work finds the robot where it was to start."""
    flown = Flown()
    flown.plant.reset(PLACE)
    for _ in range(50):
        flown.clock.time += 0.021
        flown.plant.watch()
    state = flown.plant.step(REST)
    assert not flown.plant.crashed
    assert np.linalg.norm(state[:3] - PLACE[:3]) < 0.1
    flown.plant.reset(PLACE)
    for _ in range(200):
        flown.clock.time += 0.021
        flown.plant.watch()
    assert flown.plant.ended == "no action in 2 s after the start was reached"


def test_after_a_fault_it_stays_on_the_ground() -> None:
    flown = Flown()
    flown.hover(0.2)
    flown.link.battery = 3.0
    flown.down()
    with pytest.raises(UnreachableError, match="battery"):
        flown.plant.reset(PLACE)


@pytest.mark.parametrize(("error", "reason"), [(KeyboardInterrupt(), "Ctrl-C"), (ValueError("no"), "ValueError: no")])
def test_an_interrupted_flight_lands(error: BaseException, reason: str) -> None:
    flown = Flown()
    with pytest.raises(type(error)), flown.plant:
        flown.hover(0.5)
        raise error
    assert flown.plant.ended == reason
    assert flown.link.plant.true_state[2] < LANDED
    assert not flown.link.emergency


def test_interrupted_while_it_lands_the_motors_are_cut() -> None:
    flown = Flown()

    def interrupted(moment: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), flown.plant:
        flown.hover(0.5)
        flown.clock.sleep_until = interrupted  # type: ignore[method-assign]
        raise KeyboardInterrupt
    assert flown.link.emergency


@pytest.mark.parametrize(("column", "value"), [(0, 5.0), (7, 0.5), (10, 0.5)])
def test_a_start_out_of_reach_is_refused_before_anything_moves(column: int, value: float) -> None:
    flown, state = Flown(), PLACE.copy()
    state[column] = value
    with pytest.raises(UnreachableError):
        flown.plant.reset(state)
    assert not flown.link.armed
    assert not flown.rows


def test_a_start_that_cannot_be_reached_ends_on_the_ground() -> None:
    flown = Flown(("gain:thrust", {"value": 0.3}))
    with pytest.raises(UnreachableError, match="not reached"):
        flown.plant.reset(PLACE)
    assert flown.link.stopped


def test_nothing_is_sent_before_a_reset() -> None:
    flown = Flown()
    with pytest.raises(LinkError, match="reset"):
        flown.plant.step(REST)
    with pytest.raises(ShapeError, match="columns"):
        flown.plant.step(REST[:2])
    flown.plant.land()
    assert not flown.link.sent


def test_no_take_off_on_a_pose_that_has_grown_old() -> None:
    """A finite pose of a minute ago armed the robot, and a blind landing from the floor lifted it up."""
    flown = Flown()
    flown.link.lost["pose"] = flown.clock.now() - 60.0
    with pytest.raises(UnreachableError, match="no take-off: no pose from motion capture for 6"):
        flown.plant.reset(PLACE)
    assert not flown.link.armed
    assert not flown.link.sent


def test_a_take_off_needs_more_battery_than_a_flight() -> None:
    flown = Flown()
    flown.link.battery = 3.4
    with pytest.raises(UnreachableError, match=r"no take-off: battery low: 3\.40 V"):
        flown.plant.reset(PLACE)
    assert not flown.link.armed


@pytest.mark.parametrize(
    ("tilt", "rate", "yaw", "words"),
    [
        (60.0, 0.0, 0.0, "it leans by 60°: stand it on level ground"),
        (12.0, 0.0, 0.0, "it leans by 12°"),
        (0.0, 0.2, 0.0, r"it turns by 0\.14 rad/s: let it stand still"),
        (0.0, 0.0, 20.0, "its yaw is 20° off: turn"),
    ],
)
def test_no_take_off_from_a_hand(tilt: float, rate: float, yaw: float, words: str) -> None:
    """It armed though it leaned by 60° or was turned to and fro; its yaw was looked at before the first flight only."""
    flown = Flown()
    read, half = flown.link.state, math.radians(tilt) / 2.0

    def seen() -> Reading:
        reading = read()
        reading.state[3:7] = [math.cos(half), math.sin(half), 0.0, 0.0]
        reading.state[10] = rate * math.sin(2.0 * math.pi * 2.0 * reading.time)
        return replace(reading, extra={"capture_yaw": math.radians(yaw)})

    flown.link.state = seen  # type: ignore[method-assign]
    with pytest.raises(UnreachableError, match=f"no take-off: {words}"):
        flown.plant.reset(PLACE)
    assert not flown.link.armed


@pytest.mark.parametrize("gain", [1.0, 1.31])
def test_blind_near_the_ground_the_motors_are_cut(gain: float) -> None:
    """There a thrust map that is wrong would lift the robot up for three seconds."""
    flown = Flown(("gain:thrust", {"value": gain}))
    measured = flown.link.state

    def seen() -> Reading:
        if flown.rows and "pose" not in flown.link.lost and flown.link.plant.true_state[2] > 0.03:
            flown.link.lost["pose"] = flown.clock.now() - 0.2
        return measured()

    flown.link.state = seen  # type: ignore[method-assign]
    with pytest.raises(UnreachableError, match="no pose"):
        flown.plant.reset(PLACE)
    assert "blind landing" not in {row.command.phase for row in flown.rows}
    assert flown.link.plant.true_state[2] < 0.15


def test_one_wrong_pose_says_nothing_about_the_ground() -> None:
    """A high one before the take-off had every landing end at its height; a low one cut the motors in the air."""
    flown, measured, count = Flown(), [], 0
    read = flown.link.state

    def seen() -> Reading:
        nonlocal count
        reading, count = read(), count + 1
        first_of_landing = flown.rows and flown.rows[-1].command.phase == "land" and not measured
        if count == 1:
            reading.state[2] = 0.6
        elif first_of_landing:
            measured.append(flown.clock.now())
            reading.state[2] = 0.0
        return reading

    flown.link.state = seen  # type: ignore[method-assign]
    flown.hover(0.5)
    flown.plant.land()
    assert measured
    assert flown.link.plant.true_state[2] < LANDED


@pytest.mark.parametrize(("axis", "value"), [(0, 3.0), (0, -20.0), (2, 5.0)])
def test_a_landing_does_not_go_where_one_wrong_pose_was(axis: int, value: float) -> None:
    """Its line down began at that place, and the robot flew there."""
    flown = Flown()
    flown.hover(1.0)
    read = flown.link.state

    def seen() -> Reading:
        reading = read()
        if flown.rows[-1].command.verdict is Verdict.GO:
            reading.state[axis] = value
        return reading

    flown.link.state = seen  # type: ignore[method-assign]
    flown.down()
    assert "fence" in flown.plant.ended
    way = np.array([row.reading.state[:3] for row in flown.rows if row.command.phase == "land"])[1:]
    assert np.abs(way[:, :2] - PLACE[:2]).max() < 0.3
    assert way[:, 2].max() < PLACE[2] + 0.1
    assert flown.link.plant.true_state[2] < LANDED


@pytest.mark.parametrize("fault", ["pose", "attitude", "tumbled", "slow"])
def test_a_landing_that_was_asked_for_and_went_wrong_is_a_fault(fault: str) -> None:
    """The next reset took off again, with nobody there."""
    flown = Flown()
    flown.hover(0.5)
    read, landing = flown.link.state, False

    def seen() -> Reading:
        if landing and fault == "tumbled":
            flown.link.flags.add(fault)
        elif landing and fault != "slow":
            flown.link.lost.setdefault(fault, flown.clock.now())
        reading = read()
        if landing and fault == "slow":
            reading.state[2] = 0.8
        return reading

    flown.link.state = seen  # type: ignore[method-assign]
    landing = True
    flown.plant.land()
    landing = False
    flown.link.lost.clear()
    flown.link.flags.discard("tumbled")
    words = {"tumbled": "tumbled", "slow": "took too long"}.get(fault, "blind")
    with pytest.raises(UnreachableError, match=words):
        flown.plant.reset(PLACE)
    assert not flown.link.armed
