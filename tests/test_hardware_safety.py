"""The verdict on a moment of a flight, and that no input yields a command outside the limits."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra.numpy import arrays

from hardware.interfaces import Reading, Verdict
from hardware.pilot import FlightPilot
from hardware.safety import CUTS, Condition, Limits, judge, tilt_of
from sym2real.errors import ShapeError
from sym2real.robots import CRAZYFLIE
from sym2real.trajectory import Array

UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
GOOD = Condition(0.01, 0.01, np.array([0.0, 0.0, 1.0]), UPRIGHT, 3.9)
LIMITS = Limits()


def rolled(angle: float) -> Array:
    return np.array([math.cos(angle / 2), math.sin(angle / 2), 0.0, 0.0])


def test_a_good_moment_goes_on() -> None:
    assert judge(GOOD, LIMITS).verdict is Verdict.GO


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"pose_age": 0.21}, "motion capture"),
        ({"pose_age": math.nan}, "motion capture"),
        ({"pose_age": -1.0}, "motion capture"),
        ({"attitude_age": 0.21}, "attitude"),
        ({"attitude_age": math.inf}, "attitude"),
        ({"position": np.array([1.51, 0.0, 1.0])}, "fence: x"),
        ({"position": np.array([0.0, 0.0, 1.71])}, "fence: z"),
        ({"position": np.array([0.0, math.nan, 1.0])}, "motion capture"),
        ({"attitude": rolled(math.radians(71.0))}, "tilted"),
        ({"attitude": np.zeros(4)}, "no attitude"),
        ({"flags": frozenset({"lost"})}, "the link to the robot has ended"),
        ({"battery": 3.19}, "battery"),
        ({"battery": math.nan}, "battery"),
        ({"late": 0.11}, "no action"),
        ({"late": math.nan}, "no action"),
        ({"overruns": 6}, "late"),
        ({"action_is_finite": False}, "finite"),
        ({"asked": "Ctrl-C"}, "Ctrl-C"),
    ],
)
def test_every_limit_lands(change: dict[str, object], words: str) -> None:
    judged = judge(replace(GOOD, **change), LIMITS)  # type: ignore[arg-type]
    assert judged.verdict is Verdict.LAND
    assert words in judged.reason


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        (Limits(high=(2.0, 2.0, 5.0)), r"landing above 18\.3 s for a fence 5\.2 m high, found 12"),
        (Limits(descent=0.1), r"landing above 22\.0 s"),
        (Limits(high=(2.0, 2.0, 5.0), landing=20.0), r"blind above 4\.2 s for a fence 5\.2 m high, found 3"),
        (Limits(blind=math.nan), "blind above"),
        (Limits(late=0.5), r"late below 0\.5 s.*, found 0\.5"),
        (Limits(pose_age=200.0), r"pose_age below 0\.5 s.*, found 200"),
        (Limits(attitude_age=math.nan), r"attitude_age below 0\.5 s.*, found nan"),
        (Limits(touchdown=4.0), r"touchdown above 0 and up to 0\.15 m, found 0\.3 and 4"),
        (Limits(descent=30.0), r"descent up to 1 m/s.*, found 30"),
    ],
)
def test_limits_by_which_no_flight_ends_well_are_refused(limits: Limits, words: str) -> None:
    with pytest.raises(ShapeError, match=words):
        FlightPilot(CRAZYFLIE, limits)


@pytest.mark.parametrize("flag", CUTS)
def test_what_the_firmware_has_cut_is_cut(flag: str) -> None:
    assert judge(replace(GOOD, flags=frozenset({flag})), LIMITS).verdict is Verdict.CUT


def test_upside_down_there_is_no_landing() -> None:
    assert judge(replace(GOOD, attitude=rolled(2.0)), LIMITS).verdict is Verdict.CUT
    stale = replace(GOOD, attitude=rolled(2.0), attitude_age=1.0)
    assert judge(stale, LIMITS).verdict is Verdict.LAND  # nobody knows how it lies now


@given(st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi), st.floats(0.8, 1.2))
def test_tilt_is_the_angle_between_the_z_axes(roll: float, heading: float, norm: float) -> None:
    """A heading turns the world's axes about z, and does not tilt."""
    w, x, _, _ = rolled(roll)
    turned = np.array([math.cos(heading / 2) * w, math.cos(heading / 2) * x, math.sin(heading / 2) * x,
                       math.sin(heading / 2) * w])  # fmt: skip
    assert tilt_of(norm * turned) == pytest.approx(abs(roll), abs=1e-6)


wild = st.floats(allow_nan=True, allow_infinity=True)
readings = st.builds(
    lambda time, state, pose, attitude, battery, flags: Reading(
        time, state, {"pose": pose, "attitude": attitude}, battery, frozenset(flags)
    ),
    wild,
    st.one_of(
        arrays(np.float64, 13, elements=wild),
        arrays(np.float64, 13, elements=st.floats(-2.0, 2.0)),
        st.just(np.array([0.0, 0.0, 1.0, 1.0, *[0.0] * 9])),
    ),
    st.one_of(wild, st.just(0.01)),
    st.one_of(wild, st.just(0.01)),
    st.one_of(wild, st.just(4.0)),
    st.sets(st.sampled_from(["armed", "can_fly", *CUTS]), max_size=2),
)
moments = st.tuples(
    readings,
    st.one_of(st.none(), arrays(np.float64, 4, elements=wild)),
    st.one_of(wild, st.just(0.0)),
    st.integers(-5, 50),
    st.sampled_from(["", "", "Ctrl-C"]),
)


@settings(max_examples=300, deadline=None)
@given(st.lists(moments, min_size=1, max_size=12))
def test_whatever_comes_in_what_goes_out_is_within_the_limits(
    sequence: list[tuple[Reading, Array | None, float, int, str]],
) -> None:
    """NaN, infinity, clocks that go backwards: the command is finite and allowed, and no verdict is taken back."""
    pilot, before = FlightPilot(CRAZYFLIE), Verdict.GO
    for reading, wanted, late, overruns, asked in sequence:
        command = pilot.act(reading, wanted, late=late, overruns=overruns, asked=asked)
        if command.verdict is Verdict.CUT:
            assert not command.action.any()
        else:
            assert (command.action >= CRAZYFLIE.low).all()
            assert (command.action <= CRAZYFLIE.high).all()
        assert command.verdict >= before
        assert bool(command.reason) == (command.verdict is not Verdict.GO)
        before = command.verdict
