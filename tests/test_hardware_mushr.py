"""The car's link, pilot and fake: limits, filtering, whole drives on a test's clock, and real ones over ROS."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from car_link import CarLink, pose
from hypothesis import given, strategies as st
from ros_peers import PATIENCE, master, rospy_script, wait_for

from hardware.errors import LinkError, UnreachableError
from hardware.fakes.mushr import INPUTS, PERIOD, POSES, TIMEOUT, Car, FakeMushr, Truth
from hardware.interfaces import Pose, Reading, Verdict
from hardware.mushr import CarLimits, DriveLimits, DrivePilot, MushrLink
from hardware.mushr.pose_filter import PoseFilter
from hardware.plant import HardwarePlant
from hardware.ros1 import Node
from hardware.ros1.capture import RosCapture, Topic
from hardware.row import Row
from sym2real.control.pure_pursuit import PurePursuit
from sym2real.effects import effect
from sym2real.errors import ShapeError
from sym2real.plants import run_episode
from sym2real.robots import MUSHR
from sym2real.tasks import make_task
from sym2real.trajectory import Array
from tests.hardware_link import TestClock

ANY = st.floats(allow_nan=True, allow_infinity=True)
FAR_AWAY = DriveLimits(low=(-50.0, -50.0), high=(50.0, 50.0))
# A machine that others use may be late: what is tested is what happens, not how fast.
PATIENT = replace(FAR_AWAY, pose_age=PATIENCE, late=PATIENCE, overruns=10000)


class Driven:
    """A plant on that link, with what it recorded."""

    def __init__(self, limits: DriveLimits = FAR_AWAY, *, put_back: bool = False, **truth: object) -> None:
        self.clock, self.rows, self.put_at = TestClock(), list[Row](), list[list[float]]()
        self.link = CarLink(self.clock, Car(Truth(**truth)))  # type: ignore[arg-type]
        pilot, put = DrivePilot(MUSHR, limits), self._put if put_back else None
        self.plant = HardwarePlant(self.link, pilot, clock=self.clock, record=self.rows.append, guard=False, put=put)

    def _put(self, start: Array) -> None:
        """The person who puts the car back."""
        self.put_at.append(start[:2].tolist())
        self.link.car.put(*start[:2].tolist(), math.atan2(start[2], start[3]))
        self.clock.time += 0.2

    def straight(self, seconds: float) -> None:
        self.plant.reset(MUSHR.start)
        for _ in range(round(seconds / self.plant.dt)):
            self.plant.step([0.05, 0.8])

    def entered(self) -> Row:
        """The first row in which the drive was no longer "go"."""
        return next(row for row in self.rows if row.command.verdict is not Verdict.GO)


@given(st.tuples(ANY, ANY), st.tuples(st.floats(-0.38, 0.38), st.floats(-0.93, 0.93)), st.floats(0.0, 1.0))
def test_nothing_leaves_the_limits_or_changes_faster_than_they_allow(
    wanted: tuple[float, float], before: tuple[float, float], seconds: float
) -> None:
    limits, start = CarLimits(), np.array(before)
    finite = np.nan_to_num(np.array(wanted), posinf=1e300, neginf=-1e300)
    sent = limits.reachable(finite, start, seconds)
    assert np.all(np.abs(sent) <= [limits.steer, limits.forward])
    assert np.all(np.abs(sent - start) <= seconds * np.array([limits.steer_rate, limits.acceleration]) + 1e-12)
    inside = np.clip(finite, [-limits.steer, -limits.reverse], [limits.steer, limits.forward])
    if np.all(np.abs(inside - start) <= seconds * np.array([limits.steer_rate, limits.acceleration])):
        np.testing.assert_array_equal(sent, inside)


def test_limits_by_which_a_car_would_not_brake_are_refused() -> None:
    """With a negative braking it sped up to what its drivers take."""
    for limits, car in (
        (DriveLimits(braking=-2.5), CarLimits()),
        (DriveLimits(low=(2.0, -3.2), high=(-2.0, 3.2)), CarLimits()),
        (DriveLimits(), CarLimits(acceleration=-2.5)),
        (DriveLimits(), CarLimits(steer=math.nan)),
    ):
        with pytest.raises(ShapeError, match="limits: expected"):
            DrivePilot(MUSHR, limits, car)


@given(
    reading=st.tuples(*[ANY] * 7),
    wanted=st.one_of(st.none(), st.tuples(ANY, ANY)),
    age=ANY,
    late=st.tuples(ANY, st.integers(-5, 100)),
    time=ANY,
)
def test_no_input_yields_a_command_outside_the_limits(
    reading: tuple[float, ...], wanted: tuple[float, float] | None, age: float, late: tuple[float, int], time: float
) -> None:
    pilot = DrivePilot(MUSHR)
    worst = Verdict.GO
    for asked in ("", "", "Ctrl-C", ""):
        command = pilot.act(
            Reading(time, np.array(reading), {"pose": age}),
            None if wanted is None else np.array(wanted),
            late=late[0],
            overruns=late[1],
            asked=asked,
        )
        assert np.all((MUSHR.low <= command.action) & (command.action <= MUSHR.high))
        assert command.verdict >= worst, "a verdict is never taken back"
        worst = command.verdict
        if command.verdict is Verdict.CUT:
            assert not command.action.any()


def test_a_state_follows_the_car_round_a_circle_through_the_turn_of_yaw() -> None:
    """Position, yaw and velocities are those of half a window ago, whatever the stamps' jitter."""
    rng, filtered = np.random.default_rng(0), PoseFilter()
    radius, rate, stamp = 1.5, -0.7, 0.0
    for number in range(2000):
        stamp += 0.01 + 0.004 * rng.uniform(-1, 1)
        angle = rate * stamp
        state = filtered.add(pose(stamp, radius * math.cos(angle), radius * math.sin(angle), angle - math.pi / 2))
        if number < 20:
            continue
        assert abs(state[6] - rate) < 1e-3
        assert np.hypot(state[4], state[5]) == pytest.approx(radius * abs(rate), rel=1e-3)
        assert np.hypot(state[0], state[1]) == pytest.approx(radius, rel=1e-3)
        assert np.hypot(state[2], state[3]) == pytest.approx(1.0)


def test_an_outlier_passes_nowhere_and_a_gap_begins_anew() -> None:
    filtered = PoseFilter()
    for number in range(10):
        filtered.add(pose(0.01 * number, 0.0, 0.0, 3.1))
    state = filtered.add(pose(0.1, 5.0, -5.0, 0.0))
    np.testing.assert_allclose(state, [0, 0, math.sin(3.1), math.cos(3.1), 0, 0, 0], atol=1e-12)
    assert filtered.add(pose(0.1, 9.0, 9.0, 0.0)) is state, "a stamp that has been seen changes nothing"
    after = filtered.add(pose(5.0, 1.0, 2.0, -3.1))
    np.testing.assert_allclose(after[:2], [1.0, 2.0])
    assert np.isnan(after[4:]).all()
    silent = Pose(np.array([7.0, 7.0, 0.0]), None, 5.01, 5.01)
    assert filtered.add(silent) is after, "a pose without heading is none of a car"


def test_a_pose_that_comes_behind_its_successor_does_not_turn_the_car_round() -> None:
    """Its third turn, at 2 rad/s: a yaw that is counted from anew was a yaw rate of -120 rad/s for 50 ms."""
    filtered = PoseFilter()
    stamps = 0.01 * np.arange(950)
    for stamp in np.where(np.arange(950) % 100 == 99, stamps - 0.015, stamps).tolist():
        state = filtered.add(pose(stamp, 0.5 * stamp, 0.0, 2.0 * stamp))
        assert np.isnan(state[6]) == (stamp == 0.0)
        assert stamp == 0.0 or (state[4], state[6]) == pytest.approx((0.5, 2.0))


def test_a_task_drives_as_in_simulation() -> None:
    task = make_task("circle", MUSHR, radius=1.5, speed=0.825)
    driven = Driven(start=(1.5, -0.3, 1.4))
    controller = PurePursuit(MUSHR.numbers["wheelbase"], MUSHR.low, MUSHR.high, MUSHR.dt, task.reference)
    begin = np.array([1.5, -0.3, math.sin(1.4), math.cos(1.4), 0.0, 0.0, 0.0])
    trajectory = run_episode(driven.plant, controller, task, start=begin, steps=200)
    driven.plant.land()
    assert len(trajectory) == 200
    missing = trajectory.state[:, :2] - np.stack([trajectory.extra["ref_x"], trajectory.extra["ref_y"]], axis=1)
    assert np.hypot(*missing[100:].T).mean() < 0.1, "the car starts at rest, 0.3 m behind"
    assert driven.plant.ended == "the task is over"
    np.testing.assert_array_equal(driven.link.sent[-1], 0.0)
    assert np.hypot(*driven.link.car.state[4:6]) < 0.1
    sent = np.array([row.sent for row in driven.rows if row.stage == "task"])
    np.testing.assert_array_equal(trajectory.action, sent[: len(trajectory)])


def test_the_start_is_driven_to_and_a_heading_that_is_out_of_reach_is_said() -> None:
    driven = Driven(start=(0.9, 0.1, 0.0))
    state = driven.plant.reset([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    assert np.hypot(*state[:2]) < 0.15
    turned = Driven(start=(0.05, 0.0, math.pi))
    with pytest.raises(UnreachableError, match=r"points -?1(79|80)° elsewhere: turn it by hand"):
        turned.plant.reset([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("start", "reason"),
    [([0, 0, 0, 1, 0.5, 0, 0], "this one moves"), ([9, 0, 0, 1, 0, 0, 0], r"outside the fence: x = 9\.00 m")],
)
def test_a_start_that_moves_or_lies_outside_is_refused_before_anything_moves(start: list[float], reason: str) -> None:
    driven = Driven(DriveLimits())
    with pytest.raises(UnreachableError, match=reason):
        driven.plant.reset(start)
    assert len(driven.link.sent) == 1


def test_lost_poses_brake_the_car_to_a_stand() -> None:
    driven = Driven()
    driven.straight(2.0)
    driven.link.lost = lost = driven.clock.now()
    while not driven.plant.crashed:
        driven.plant.step([0.05, 0.8])
    row = driven.entered()
    assert 0.0 < row.reading.time - lost - 0.3 < 0.06
    assert (row.command.phase, driven.rows[-1].command.phase) == ("brake", "stand")
    speeds = [float(r.sent[1]) for r in driven.rows if r.command.verdict is not Verdict.GO]
    assert np.all(np.diff(speeds) <= 0.0) and speeds[-1] == 0.0
    assert "no pose from motion capture" in driven.plant.ended


def test_the_fence_brakes_the_car_inside_a_metre_of_it() -> None:
    driven = Driven(DriveLimits(low=(-1.0, -1.0), high=(1.0, 1.0)))
    driven.plant.reset(MUSHR.start)
    for _ in range(200):
        driven.plant.step([0.0, 0.9])
    assert driven.plant.ended.startswith("outside the fence: x = 1.0")
    assert driven.link.car.state[0] < 1.6


def test_a_drive_that_ended_by_a_fault_does_not_keep_the_next_from_its_start() -> None:
    """A person puts the car back before each."""
    driven = Driven(DriveLimits(low=(-1.0, -1.0), high=(0.5, 1.0)), put_back=True)
    for _ in range(2):
        state = driven.plant.reset(MUSHR.start)
        assert np.hypot(*state[:2]) < 0.15
        for _ in range(400):
            driven.plant.step([0.0, 0.9])
        assert driven.plant.ended.startswith("outside the fence: x = 0.5")
    assert driven.put_at == [[0.0, 0.0], [0.0, 0.0]]
    assert sum(row.stage == "task" for row in driven.rows) > 20
    np.testing.assert_array_equal(driven.rows[-1].sent, 0.0)


@pytest.mark.parametrize("action", [[math.nan, 0.5], [0.1, math.inf]])
def test_an_action_that_is_no_number_brakes(action: list[float]) -> None:
    driven = Driven()
    driven.straight(0.5)
    driven.plant.step(action)
    assert "finite" in driven.plant.ended


def test_the_multiplexer_heeds_priorities_its_time_out_and_the_button() -> None:
    car = Car(Truth(limits=CarLimits(steer_rate=1e9, acceleration=1e9)))
    drive, stop, joystick = np.array([0.1, 0.5]), np.zeros(2), np.array([-0.2, 0.3])

    def after(now: float) -> list[float]:
        car.advance(now)
        return car.driven.tolist()

    car.command("navigation", drive, 0.0)
    assert after(0.01) == drive.tolist()
    car.command("teleop", joystick, 0.02)
    assert after(0.03) == joystick.tolist()
    car.command("safety", stop, 0.04)
    assert after(0.05) == stop.tolist()
    car.command("navigation", drive, 0.2)
    assert after(0.04 + TIMEOUT + 0.001) == drive.tolist(), "safety and joystick are silent"
    car.button = False
    assert after(0.3) == stop.tolist()
    car.button = True
    assert after(0.2 + TIMEOUT + 0.001) == stop.tolist(), "navigation is silent"


def test_the_servo_and_the_speed_controller_keep_their_limits() -> None:
    car, last = Car(), np.zeros(2)
    limits = Truth().limits
    for number in range(300):
        car.command("navigation", np.array([2.0 * (-1) ** (number // 50), 9.0]), number * PERIOD)
        car.advance(number * PERIOD)
        change = np.abs(car.driven - last) / PERIOD
        assert np.all(change <= np.array([limits.steer_rate, limits.acceleration]) + 1e-9)
        last = car.driven
        assert np.all(np.abs(last) <= [limits.steer, limits.forward])
    assert last[1] == limits.forward


def test_a_hidden_effect_is_felt_and_latency_is_what_it_says() -> None:
    plain = Car(Truth(position_noise=0.0, yaw_noise=0.0))
    late = Car(Truth(position_noise=0.0, yaw_noise=0.0, latency=0.2))
    turned = Car(Truth(position_noise=0.0, yaw_noise=0.0), [effect("offset:steer", MUSHR).inject(value=0.1)])
    paths = {}
    for name, car in {"plain": plain, "late": late, "turned": turned}.items():
        rows = []
        for number in range(200):
            car.command("navigation", np.array([0.0, 0.8]), number * PERIOD)
            rows.append(car.advance(number * PERIOD))
        paths[name] = np.array(rows)
    np.testing.assert_allclose(paths["late"][20:], paths["plain"][:-20], atol=1e-3)
    assert abs(paths["plain"][-1, 2]) < 0.01
    assert paths["turned"][-1, 2] > 0.2


# ——— over ROS ———


@pytest.fixture(scope="module")
def uri() -> Iterator[str]:
    with master() as address:
        yield address


@pytest.fixture
def fake(uri: str) -> Iterator[FakeMushr]:
    with FakeMushr(Node("/fake", uri, "127.0.0.1"), Car()) as robot:
        yield robot


def link_to(uri: str, **settings: bool) -> MushrLink:
    node = Node("/sym2real", uri, "127.0.0.1")
    return MushrLink(node, RosCapture(node, Topic(POSES)), **settings)


def test_a_drive_over_ros_moves_the_car_and_zeros_stop_it(uri: str, fake: FakeMushr) -> None:
    with link_to(uri) as link:
        link.connect()
        with HardwarePlant(link, DrivePilot(MUSHR, PATIENT)) as plant:
            plant.reset(MUSHR.start)
            wait_for(lambda: bool(plant.step([0.2, 0.8])[0] > 0.3 or plant.crashed))
            assert not plant.ended
            moved = plant.step([0.2, 0.8])
    assert moved[0] > 0.3
    assert moved[6] > 0.0, "positive steering is to the left"
    wait_for(lambda: not fake.car.driven[1] and float(np.hypot(*fake.car.state[4:6])) < 0.05)


def test_a_program_that_is_killed_leaves_the_car_to_the_time_out(uri: str, fake: FakeMushr) -> None:
    link = link_to(uri)
    link.connect()

    def driven() -> bool:
        link.send([0.0, 0.8])
        return bool(fake.car.driven[1] > 0.1)

    wait_for(driven)
    wait_for(lambda: not fake.car.driven[1])  # nobody said goodbye, nobody sends
    link.close()


def test_a_link_that_was_not_asked_for_a_while_knows_the_whole_state(uri: str, fake: FakeMushr) -> None:
    """Training takes longer than the filter's gap; every pose counts, whoever reads when."""
    with link_to(uri) as link:
        link.connect()
        stamp = link.state().extra["pose_stamp"]
        heard = len(link._capture.recent())
        wait_for(lambda: link._capture.recent()[-1].stamp > stamp + 0.6)
        reading = link.state()
    assert heard > 0
    assert np.isfinite(reading.state).all()
    # Noise of 0.5 mm and 2 mrad: 0.02 m/s and 0.06 rad/s over the filter's window.
    assert np.all(np.abs(reading.state - MUSHR.start) < [0.01, 0.01, 0.02, 0.02, 0.1, 0.1, 0.4])


def test_dry_nothing_is_sent(uri: str, fake: FakeMushr) -> None:
    with link_to(uri, dry=True) as link:
        link.connect()
        link.arm()
        sent = link.send([0.2, 0.5])
        assert sent[1] > 0.0
    assert not fake.car._inputs


def test_after_an_emergency_stop_nothing_but_zeros_is_sent(uri: str, fake: FakeMushr) -> None:
    with link_to(uri) as link:
        link.connect()
        link.send([0.1, 0.5])
        link.stop(emergency=True)
        np.testing.assert_array_equal(link.send([0.1, 0.5]), 0.0)
        with pytest.raises(LinkError, match="emergency stop"):
            link.arm()


def test_actions_that_are_none_are_refused(uri: str, fake: FakeMushr) -> None:
    with link_to(uri) as link:
        link.connect()
        for action in ([math.nan, 0.0], [0.0], [[0.0, 0.0]]):
            with pytest.raises(ShapeError, match="finite numbers for steer, speed"):
                link.send(action)


def test_without_poses_or_without_a_car_the_error_says_which(uri: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hardware.seen.FIRST_POSE", 0.2)
    with (
        Node("/alone", uri, "127.0.0.1") as node,
        pytest.raises(LinkError, match=f"no pose on {POSES}.*motion capture"),
    ):
        MushrLink(node, RosCapture(node, Topic(POSES))).connect()


LISTEN = """
import sys, time
import rospy
stamps = []
rospy.init_node("listener", disable_signals=True)
rospy.Subscriber(sys.argv[1], rospy.AnyMsg, lambda message: stamps.append(len(message._buff)), queue_size=100)
print("ready")
while len(stamps) < int(sys.argv[2]):
    time.sleep(0.01)
print(min(stamps), max(stamps))
"""


def test_rospy_hears_the_commands(uri: str, fake: FakeMushr) -> None:
    """Sequence, stamp, empty frame, five float32: 36 bytes each."""
    listener = rospy_script(uri, LISTEN, f"{INPUTS}/navigation", "20")
    assert listener.stdout is not None and listener.stdout.readline().strip() == "ready"
    with link_to(uri) as link:
        link.connect()
        wait_for(lambda: link.send([0.1, 0.2]) is not None and listener.poll() is not None)
    assert listener.stdout.readline().split() == ["36", "36"]
    assert listener.returncode == 0
