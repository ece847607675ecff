"""Newtons to the firmware's 16-bit number and back."""

import math

import pytest
from hypothesis import given, strategies as st

from hardware.crazyflie.thrust_map import FULL_SCALE, THRUST_MAPS, ThrustMap
from sym2real.errors import ShapeError, UnknownNameError
from sym2real.robots.robot import GRAVITY

MAP = THRUST_MAPS["2025.02"]
maps = pytest.mark.parametrize("thrust_map", THRUST_MAPS.values(), ids=THRUST_MAPS.keys())


@maps
def test_it_is_exact_at_nothing_at_least_and_at_most(thrust_map: ThrustMap) -> None:
    assert (thrust_map.counts(0.0).value, thrust_map.counts(0.0).saturated) == (0, False)
    assert thrust_map.counts(1.0 / thrust_map.per_newton).value == 1
    most = thrust_map.counts(thrust_map.greatest)
    assert (most.value, most.saturated) == (thrust_map.most, False)


@maps
def test_beyond_its_reach_it_saturates_and_says_so(thrust_map: ThrustMap) -> None:
    for thrust in (thrust_map.greatest * 1.001, 1e9, math.inf):
        assert (thrust_map.counts(thrust).value, thrust_map.counts(thrust).saturated) == (thrust_map.most, True)
    for thrust in (-1e-9, -math.inf):
        assert (thrust_map.counts(thrust).value, thrust_map.counts(thrust).saturated) == (0, True)


def test_not_a_number_is_refused() -> None:
    with pytest.raises(ShapeError, match="NaN"):
        MAP.counts(math.nan)


@given(st.floats(allow_nan=False))
def test_any_thrust_gives_sixteen_bits(thrust: float) -> None:
    for one in (MAP, ThrustMap("x", 5.0, 60000)):
        assert 0 <= one.counts(thrust).value <= one.most <= FULL_SCALE


@given(st.integers(0, MAP.most))
def test_the_way_back_is_the_inverse(counts: int) -> None:
    assert MAP.counts(MAP.newtons(counts)).value == counts


def test_presets_are_a_third_apart() -> None:
    """The figures of the firmware's releases: what one calls 0.4 N is 0.52 N to another."""
    assert THRUST_MAPS["2025.09"].per_newton / MAP.per_newton == pytest.approx(1.31, abs=0.005)
    with pytest.raises(UnknownNameError, match="2025"):
        THRUST_MAPS["2025.9"]


def test_a_hover_calibrates_it() -> None:
    """What is sent for the weight is the count that was seen to carry it."""
    calibrated = MAP.calibrated(0.0325, 42345.0)
    assert calibrated.counts(0.0325 * GRAVITY).value == 42345


def test_a_gain_of_the_diagnosis_corrects_it() -> None:
    """A robot that gives 0.79 of what it is asked is asked for 1 / 0.79."""
    corrected = MAP.corrected(0.79)
    given_thrust = 0.79 * MAP.newtons(corrected.counts(0.3).value)
    assert given_thrust == pytest.approx(0.3, abs=1.0 / MAP.per_newton)
    with pytest.raises(ShapeError, match="gain"):
        MAP.corrected(0.0)


def test_a_slip_of_the_decimal_point_is_refused() -> None:
    """A gain of 0.079, or the mass of a tenth, asked the motors for all that they have."""
    for gain in (0.079, 7.9, 79.0):
        with pytest.raises(ShapeError, match=r"gain .*: expected at most 2 times more or less counts per N"):
            MAP.corrected(gain)
    for mass, counts in ((0.00325, 42345.0), (0.0325, 4234.5), (32.5, 42345.0)):
        with pytest.raises(ShapeError, match=r"from hover: expected at most 2 times.*in kg and counts"):
            MAP.calibrated(mass, counts)
