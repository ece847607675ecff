"""The real cflib client against the fake Crazyflie on UDP: signs, telemetry, arming, watchdogs, whole flights.

Nothing here is timed: waits end when what they wait for has come, or after generous limits.
"""

import math
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from cflib.crtp import radiodriver
from ros_peers import PATIENCE, wait_for

from hardware.crazyflie.connection import Connection
from hardware.crazyflie.link import CrazyflieLink
from hardware.crazyflie.routes import ROUTES
from hardware.crazyflie.telemetry import BLOCKS, block_for, read
from hardware.crazyflie.thrust_map import THRUST_MAPS
from hardware.errors import LinkError, UnreachableError
from hardware.fakes.capture import FakeCapture
from hardware.fakes.crazyflie import FakeCrazyflie
from hardware.fakes.tables import compressed
from hardware.fakes.vehicle import Truth, Vehicle
from hardware.frame import Frame
from hardware.interfaces import Pose
from hardware.motion_capture import LaboratoryCapture
from hardware.pilot import FlightPilot
from hardware.plant import HardwarePlant
from hardware.safety import Limits
from sym2real.control import geometric_controller
from sym2real.errors import ShapeError
from sym2real.plants import run_episode
from sym2real.robots import CRAZYFLIE
from sym2real.rotation import from_euler
from sym2real.tasks import make_task
from sym2real.trajectory import Array

MAP = THRUST_MAPS["2025.02"]
HOVER = CRAZYFLIE.rest[0]
# On a machine that others use, data may come late: a test of what happens is not one of how fast.
PATIENT = Limits(pose_age=PATIENCE, attitude_age=PATIENCE, late=PATIENCE, overruns=10000)


@pytest.fixture(autouse=True)
def patient_firmware(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the patience above: no real flight may be that late."""
    monkeypatch.setattr("hardware.safety.LEVELS_AFTER", math.inf)


@contextmanager
def connected(route: str = "packet", **of_the_fake: Any) -> Iterator[tuple[CrazyflieLink, FakeCrazyflie]]:
    capture = FakeCapture()
    with FakeCrazyflie(poses_to=capture.address, **of_the_fake) as fake:
        link = CrazyflieLink(fake.uri, capture, MAP, route=route)
        with link:
            link.connect()
            yield link, fake


@pytest.mark.parametrize("route", ROUTES)
def test_each_route_turns_the_robot_as_it_is_told(route: str) -> None:
    """A command about forward, left or up turns the simulated body about that axis, and the robot says so."""
    with connected(route) as (link, fake):
        link.arm()
        for axis, sign in ((0, 1.0), (1, -1.0), (1, 1.0), (2, 1.0), (2, -1.0)):
            action = np.array([1.1 * HOVER, 0.0, 0.0, 0.0])
            action[1 + axis] = sign * 2.0

            def turns(axis: int = axis, sign: float = sign) -> bool:
                others = np.abs(np.delete(fake.vehicle.state[10:13], axis)).max()  # the turn before may not be over yet
                return bool(fake.vehicle.state[10 + axis] * sign > max(1.0, 2.0 * others))

            def turn(action: Array = action) -> None:
                if abs(fake.vehicle.state[3]) < 0.95:  # a robot that nobody watched for long would tumble
                    fake.do(lambda vehicle: vehicle.plant.reset([0.0, 0.0, 5.0, 1.0, *[0.0] * 9]))
                link.send(action)

            fake.do(lambda vehicle: vehicle.plant.reset([0.0, 0.0, 5.0, 1.0, *[0.0] * 9]))
            wait_for(turns, turn)
            wait_for(lambda a=axis, s=sign: link.state().state[10 + a] * s > 0.5, turn)


@pytest.mark.parametrize("route", ROUTES)
def test_each_route_sends_the_thrust_that_it_says(route: str) -> None:
    """What `send` answers is what the vehicle's motors give, where its firmware is the map's."""
    with connected(route) as (link, fake):
        link.arm()
        for thrust in (0.25, 0.1, 0.0, 0.45):
            sent = link.send([thrust, 0.0, 0.0, 0.0])
            count = round(sent[0] * MAP.per_newton)
            wait_for(lambda count=count: _held(fake) == count, lambda thrust=thrust: link.send([thrust, 0, 0, 0]))
            assert link.state().extra["thrust_count"] == count
        assert link.send(np.zeros(4))[0] == 0.0
        assert not link.state().extra["saturated"]


def _held(fake: FakeCrazyflie) -> int:
    held = fake.vehicle._set_point
    return -1 if held is None else held.counts


def test_the_commander_route_needs_its_unlocking() -> None:
    """Without the packet of no thrust the firmware keeps the motors still; `arm` sends it."""
    with connected("commander") as (link, fake):
        link.connection.arm(True)
        wait_for(lambda: fake.vehicle.supervisor.armed)
        for _ in range(20):
            link.send([0.2, 0.0, 0.0, 0.0])
            time.sleep(0.01)
        assert fake.vehicle.thrust == 0.0
        assert all(fake.firmware.parameters[name] == 0 for name in ROUTES["commander"].parameters)
        link.arm()
        wait_for(lambda: fake.vehicle.thrust > 0.15, lambda: link.send([0.2, 0.0, 0.0, 0.0]))


@pytest.mark.parametrize("protocol", [9, 10, 12])
def test_state_arrives_in_world_axes_whatever_the_firmware(protocol: int) -> None:
    route = "packet" if protocol >= 10 else "commander"
    with connected(route, protocol=protocol) as (link, fake):
        turned = [0.5, -0.3, 1.0, *_attitude(0.2, -0.3, 0.7), 0, 0, 0, 0.4, 0.3, -0.2]
        fake.do(lambda vehicle: _floating(vehicle, turned))
        wait_for(lambda: np.abs(link.state().state[:3] - turned[:3]).max() < 0.01)
        wait_for(lambda: np.abs(link.state().state[10:13] - fake.vehicle.state[10:13]).max() < 0.12)
        assert set(link.connection.logged) > set(link._block.variables)
        assert (link._block is BLOCKS[0]) == (protocol >= 10)
        wait_for(lambda: abs(abs(link.state().state[3:7] @ fake.vehicle.state[3:7]) - 1.0) < 1e-3)
        assert link.state().battery == pytest.approx(4.1, abs=0.01)
        wait_for(lambda: np.abs(np.array(fake.firmware.position) - fake.vehicle.state[:3]).max() < 0.01)


def test_the_filter_begins_anew_where_the_robot_stands() -> None:
    """Since it was switched on it had been led astray: by 8° of tilt, and by 29° of yaw."""
    with FakeCrazyflie(Truth(start=(0.4, -0.3))) as fake:
        assert abs(fake.vehicle.attitude() @ fake.vehicle.state[3:7]) < math.cos(0.25)
    with connected(truth=Truth(start=(0.4, -0.3))) as (link, fake):
        wait_for(lambda: abs(link.state().state[3:7] @ fake.vehicle.state[3:7]) > 1.0 - 1e-4)
        told = [fake.firmware.parameters[f"kalman.initial{column}"] for column in ("X", "Y", "Z", "Yaw")]
        assert told == pytest.approx([*fake.vehicle.state[:3], 0.0], abs=0.005)
        assert fake.firmware.parameters["stabilizer.estimator"] == 2
        assert fake.firmware.parameters["kalman.resetEstimation"] == 0
        wait_for(lambda: len(fake.firmware._blocks) == 1)  # nothing but telemetry goes over the radio in flight


def test_a_filter_that_does_not_settle_ends_the_connection(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hardware.crazyflie.estimator.SETTLING", 1.5)
    monkeypatch.setattr("hardware.fakes.estimator.Estimator.tell", lambda *_: None)  # no position reaches it
    with pytest.raises(LinkError, match=r"no settled estimate of its own position in 1\.5 s"), connected():
        pass


def test_a_parameter_that_is_not_confirmed_is_one_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """The robot that takes angles for rates turned over; whether it had been told was not looked at."""
    monkeypatch.setattr("hardware.crazyflie.connection.CONFIRMING", 0.3)
    with connected() as (link, fake):
        with pytest.raises(LinkError, match=r"no parameter flightmode\.none"):
            link.connection.set_parameters({"flightmode.none": 0})
        fake.deaf = True
        with pytest.raises(LinkError, match=r"no confirmation of flightmode\.stabModeRoll in 0\.3 s"):
            link.connection.set_parameters({"flightmode.stabModeRoll": 0})


def test_the_robot_is_told_its_position_though_nobody_reads_it() -> None:
    """Between two flights its own estimator was told none, and drifted away."""
    with connected() as (link, fake):
        fake.do(lambda vehicle: _floating(vehicle, [0.5, -0.3, 1.0, 1.0, *[0.0] * 9]))
        wait_for(lambda: np.abs(np.array(fake.firmware.position) - fake.vehicle.state[:3]).max() < 0.01)
        assert link.connection.lost == ""


def _floating(vehicle: Vehicle, state: list[float]) -> None:
    """Without weight: it stays where it is, and turns on."""
    vehicle.plant.reset(state)
    vehicle.plant.mj_model.opt.gravity[:] = 0.0


def _attitude(roll: float, pitch: float, yaw: float) -> list[float]:
    return from_euler(*(torch.tensor(angle, dtype=torch.float64) for angle in (roll, pitch, yaw))).tolist()


def test_a_compressed_quaternion_reads_back_in_any_attitude() -> None:
    """The fake packs, cflib unpacks: within the 9 bits of the format, whichever component is the greatest."""
    connection, rng = Connection("udp://127.0.0.1:1"), np.random.default_rng(0)
    values = dict.fromkeys(BLOCKS[0].variables, 0.0)
    for _ in range(200):
        attitude = rng.standard_normal(4)
        attitude /= np.linalg.norm(attitude)
        values["stateEstimateZ.quat"] = compressed(attitude)
        told = read(BLOCKS[0], values, connection.unpack_quaternion, 0, 0.0)
        assert abs(told.attitude @ attitude) > 1.0 - 1e-5


def test_firmware_that_logs_too_little_is_refused() -> None:
    with pytest.raises(LinkError, match=r"gyro\.x"):
        block_for({"pm.vbat"})
    garbled = read(BLOCKS[1], dict.fromkeys(BLOCKS[1].variables, 0.0), lambda _: np.zeros(4), 0, 0.0)
    assert np.isnan(garbled.attitude).all()


def test_an_old_firmware_is_refused_by_the_routes_that_it_does_not_know() -> None:
    with pytest.raises(LinkError, match="'commander'"), connected("packet", protocol=9):
        pass


def test_a_port_where_nobody_answers_is_one_error() -> None:
    """cflib alone would wait for ever."""
    with pytest.raises(LinkError, match=r"udp://127\.0\.0\.1:1"):
        Connection("udp://127.0.0.1:1").open(2.0)
    with FakeCrazyflie() as fake:
        fake.deaf = True
        with pytest.raises(LinkError, match="switched on"):
            Connection(fake.uri).open(1.0)


def test_a_locked_robot_does_not_arm(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hardware.crazyflie.link.ARMING", 0.3)
    with connected() as (link, fake):
        link.stop(emergency=True)
        wait_for(lambda: fake.vehicle.supervisor.locked)
        with pytest.raises(LinkError, match="armed"):
            link.arm()


@pytest.mark.parametrize("protocol", [9, 10, 12])
def test_stop_and_emergency_stop_reach_every_firmware(protocol: int) -> None:
    with connected("packet" if protocol >= 10 else "commander", protocol=protocol) as (link, fake):
        link.arm()
        wait_for(lambda: fake.vehicle.thrust > 0.1, lambda: link.send([0.2, 0, 0, 0]))
        link.stop()
        wait_for(lambda: fake.vehicle.thrust == 0.0 and not fake.vehicle.supervisor.armed)
        link.stop(emergency=True)
        wait_for(lambda: fake.vehicle.supervisor.locked)


@contextmanager
def busy_radio(link: CrazyflieLink) -> Iterator[threading.Event]:
    """The radio takes no packet until the event is set, or the context ends."""
    driver, free, stuck = link.connection.crazyflie.link, threading.Event(), threading.Event()
    send = driver.send_packet

    def late(packet: Any) -> None:
        stuck.set()
        free.wait(PATIENCE)
        send(packet)

    driver.send_packet = late
    try:
        wait_for(stuck.is_set)  # a position is on its way, and all else waits behind it
        yield free
    finally:
        free.set()


def test_a_set_point_does_not_replace_an_emergency_stop_that_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    """The guard's next one took its place, and the second Ctrl-C was lost."""
    with connected() as (link, fake):
        link.arm()
        wait_for(lambda: fake.vehicle.thrust > 0.1, lambda: link.send([0.2, 0, 0, 0]))
        stop, stops = link.connection.emergency_stop, list[float]()
        monkeypatch.setattr(link.connection, "emergency_stop", lambda: (stop(), stops.append(time.monotonic())))
        with busy_radio(link):
            link.stop(emergency=True)
            told = link.send([0.2, 0.0, 0.0, 0.0])
        link._require_sent()
        assert stops, "the watchdog, and nobody else, would lock the robot"
        wait_for(lambda: fake.vehicle.supervisor.locked)
        assert (told == 0.0).all()
        before = fake.firmware.commands
        link.send([0.2, 0.0, 0.0, 0.0])
        link.stop()
        assert fake.firmware.commands == before


def test_a_request_to_arm_that_waits_goes_with_a_stop(monkeypatch: pytest.MonkeyPatch) -> None:
    """It went out after the stop, when the radio came back, and left the robot armed."""
    monkeypatch.setattr("hardware.crazyflie.link.ARMING", 0.3)
    with connected() as (link, fake):
        arm, asked = link.connection.arm, list[bool]()
        monkeypatch.setattr(link.connection, "arm", lambda armed: (asked.append(armed), arm(armed)))
        with busy_radio(link):
            with pytest.raises(LinkError, match="armed"):
                link.arm()
            link.stop()
        link._require_sent()
        assert asked == [False]
        assert not fake.vehicle.supervisor.armed


def test_what_is_no_action_is_not_sent() -> None:
    with connected() as (link, fake):
        link.arm()
        before = fake.firmware.commands
        for wrong in ([0.2, 0.0, np.nan, 0.0], [0.2, 0.0], [np.inf, 0, 0, 0]):
            with pytest.raises(ShapeError, match="finite"):
                link.send(wrong)
        assert fake.firmware.commands == before


def test_the_watchdog_turns_level_and_then_off() -> None:
    """On a clock that the test sets: level half a second after the last set-point, off after two, then locked."""
    vehicle = Vehicle(Truth(), now=0.0)
    vehicle.plant.reset([0.0, 0.0, 20.0, *_attitude(0.5, 0.0, 0.0), *[0.0] * 6])
    vehicle.supervisor.arm(True, 0.0)
    vehicle.command(round(HOVER * 111342), np.zeros(3))
    vehicle.advance(0.49)
    assert vehicle.state[4] == pytest.approx(np.sin(0.25), abs=0.01)
    vehicle.advance(1.5)
    assert abs(vehicle.state[4]) < 0.01
    assert vehicle.thrust > 0.2
    vehicle.advance(2.01)
    assert vehicle.thrust == 0.0
    assert vehicle.supervisor.locked


def test_an_armed_robot_that_does_not_take_off_disarms() -> None:
    vehicle = Vehicle(Truth(), now=0.0)
    vehicle.supervisor.arm(True, 0.0)
    vehicle.advance(29.0)
    assert vehicle.supervisor.armed
    vehicle.advance(31.0)
    assert not vehicle.supervisor.armed


def test_a_tumbled_robot_stops_its_motors() -> None:
    vehicle = Vehicle(Truth(), now=0.0)
    vehicle.plant.reset([0.0, 0.0, 20.0, *_attitude(3.0, 0.0, 0.0), *[0.0] * 6])
    vehicle.supervisor.arm(True, 0.0)
    vehicle.command(30000, np.zeros(3))
    vehicle.advance(0.3)
    assert vehicle.supervisor.tumbled
    assert vehicle.thrust == 0.0


def test_a_load_pulls_the_voltage_down_and_flying_empties_the_battery() -> None:
    vehicle = Vehicle(Truth(), now=0.0)
    vehicle.supervisor.arm(True, 0.0)
    vehicle.command(40000, np.zeros(3))
    vehicle.advance(0.1)
    loaded = vehicle.battery
    assert loaded < 4.0
    vehicle.stop()
    vehicle.advance(0.2)
    assert loaded < vehicle.battery < 4.1


@pytest.mark.parametrize(("protocol", "route"), [(12, "packet"), (9, "commander")])
def test_a_whole_flight_over_udp(protocol: int, route: str) -> None:
    """Take-off, a second of a task by the simulator's own loop, landing: disarmed on the ground."""
    task = make_task("hover", CRAZYFLIE, goal=(0.2, 0.0, 0.5), start=(0.0, 0.0, 0.5))
    with (
        connected(route, protocol=protocol) as (link, fake),
        HardwarePlant(link, FlightPilot(CRAZYFLIE, PATIENT)) as plant,
    ):
        controller = geometric_controller(CRAZYFLIE, task.reference)
        trajectory = run_episode(plant, controller, task, steps=100)
        assert len(trajectory) == 100
        state = trajectory.state[-1]
        for _ in range(3000):  # a minute: a late machine flies worse, for a while
            if np.linalg.norm(state[:3] - [0.2, 0.0, 0.5]) <= 0.1:
                break
            state = plant.step(controller.act(state, 100))
            assert not plant.crashed
        assert np.linalg.norm(state[:3] - [0.2, 0.0, 0.5]) <= 0.1
        plant.land()
        assert plant.ended == "the task is over"
        wait_for(lambda: not fake.vehicle.supervisor.armed)
        assert fake.vehicle.state[2] < 0.06


def test_a_drone_that_leans_in_a_hand_does_not_arm() -> None:
    """The firmware takes up to 60° for a drone that may fly."""
    with connected() as (link, fake), HardwarePlant(link, FlightPilot(CRAZYFLIE, PATIENT)) as plant:
        fake.do(lambda vehicle: _floating(vehicle, [0.0, 0.0, 1.0, *_attitude(0.6, 0.0, 0.0), *[0.0] * 6]))
        wait_for(lambda: link.state().state[4] > 0.2)
        with pytest.raises(UnreachableError, match=r"no take-off: it leans by 3[345]°"):
            plant.reset(_place(0.4))
        assert not fake.vehicle.supervisor.armed


def test_a_drone_out_of_reach_ends_the_flight() -> None:
    limits = replace(PATIENT, attitude_age=2.0)
    with connected() as (link, fake), HardwarePlant(link, FlightPilot(CRAZYFLIE, limits)) as plant:
        plant.reset(_place(0.4))
        fake.muted = fake.deaf = True
        wait_for(lambda: plant.crashed, lambda: plant.step(CRAZYFLIE.rest))
        assert "attitude" in plant.ended
        wait_for(lambda: fake.vehicle.supervisor.locked)  # its own watchdog


def test_a_flight_whose_link_has_ended_says_so() -> None:
    """The record said that no attitude came, which a link that goes on may do as well."""
    with connected() as (link, fake), HardwarePlant(link, FlightPilot(CRAZYFLIE, PATIENT)) as plant:
        plant.reset(_place(0.4))
        link.connection.crazyflie._link_error_cb("Too many packets lost")
        wait_for(lambda: plant.crashed, lambda: plant.step(CRAZYFLIE.rest))
        assert plant.ended == "the link to the robot has ended"
        wait_for(lambda: fake.vehicle.supervisor.locked)


def test_a_gap_of_the_radio_does_not_end_the_link_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """After a hundred packets without an answer, less than a second, cflib closed it for good."""
    monkeypatch.setattr(radiodriver, "_nr_of_retries", 100)
    asked: list[int] = []
    for uri in ("udp://127.0.0.1:1", "radio://0/80/2M"):
        connection = Connection(uri)

        def answer(uri: str, connected: Any = connection.crazyflie.fully_connected) -> None:
            asked.append(radiodriver._nr_of_retries)
            connected.call(uri)

        monkeypatch.setattr(connection.crazyflie, "open_link", answer)
        connection.open(PATIENCE)
    assert asked == [100, 1500]


def test_the_end_of_a_connection_is_told_and_recorded(caplog: pytest.LogCaptureFixture) -> None:
    with connected() as (link, _):
        assert "lost" not in link.state().flags
        link.connection.crazyflie._link_error_cb("Too many packets lost")
        assert "lost" in link.state().flags
    assert "the connection is lost, and nothing is sent any more: Too many packets lost" in caplog.text


def _place(height: float) -> Array:
    place = CRAZYFLIE.start.copy()
    place[2] = height
    return place


def test_motion_capture_by_the_real_client(monkeypatch: pytest.MonkeyPatch) -> None:
    """The library's own mock: the pose that it was told, in the world's axes."""
    settings = {"rigid_bodies": "cf1(1,2,3,1,0,0,0);other(0,0,0,1,0,0,0)", "frequency": "100"}
    capture = LaboratoryCapture("mock", "cf1", settings, Frame(("x", "-z", "y")))
    capture.connect()
    first = capture.latest()
    assert isinstance(first, Pose)
    assert first.position == pytest.approx([1.0, -3.0, 2.0])
    time.sleep(0.1)
    assert capture.latest() is first, "it repeats itself to the last bit, as no camera does"
    capture.close()
    monkeypatch.setattr("hardware.seen.FIRST_POSE", 0.5)
    missing = LaboratoryCapture("mock", "cf2", settings)
    with pytest.raises(LinkError, match="cf1"):
        missing.connect()
    with pytest.raises(LinkError, match="no such system"):
        LaboratoryCapture("no such system", "cf1", {}).connect()
