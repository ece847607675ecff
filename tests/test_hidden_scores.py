"""Scores of the hidden-effect benchmark, on answers whose worth is known."""

from __future__ import annotations

from typing import Any

import hidden_scores as scores
import pytest


def record(truth: dict[str, dict[str, float]], *found: tuple[str, float], **changes: Any) -> dict[str, Any]:
    findings = [
        {
            "effect": key,
            "group": [key],
            "parameters": {"value": {"value": value, "low": 0.95 * value, "high": 1.05 * value, "unit": ""}},
        }
        for key, value in found
    ]
    kind = ("null", "single", "pair")[min(len(truth), 2)]
    plain: dict[str, Any] = {
        "robot": "crazyflie",
        "kind": kind,
        "yaw": False,
        "truth": truth,
        "excluded": [],
        "null": {key: dict.fromkeys(values, 1.0 if key.startswith("gain") else 0.0) for key, values in truth.items()},
        "verdict": "EFFECT" if found else "NOTHING_MISSING",
        "findings": findings,
        "leftover": None,
        "position_error": [1.0, 0.25],
        "diagnosing": 2.0,
    }
    return plain | changes


MASS = {"added_mass": {"value": 0.005}}


def test_equivalents_count_and_others_do_not() -> None:
    assert scores.first_right(record(MASS, ("gain:thrust", 0.85)))
    assert not scores.first_right(record(MASS, ("ground_effect", 0.1)))
    assert not scores.first_right(record(MASS))


def test_wind_and_tilt_are_one_group_only_without_yaw() -> None:
    wind = {"wind": {"fx": 0.02}}
    assert scores.first_right(record(wind, ("mounting_tilt", 0.02)))
    assert not scores.first_right(record(wind, ("mounting_tilt", 0.02), yaw=True))
    assert scores.first_right(record(wind, ("wind", 0.02), yaw=True))


def test_a_finding_is_of_one_effect_and_an_effect_of_one_finding() -> None:
    """Two members of a group for one effect are one too many; one for two effects of a group is one too few."""
    assert not scores.exact(record(MASS, ("added_mass", 0.005), ("gain:thrust", 0.85)))
    both = {"wind": {"fx": 0.02}, "mounting_tilt": {"roll": 0.02}}
    assert not scores.all_named(record(both, ("wind", 0.02)))
    assert scores.exact(record(both, ("mounting_tilt", 0.02), ("wind", 0.02)))


def test_an_exact_set_has_all_and_nothing_else() -> None:
    pair = MASS | {"delay": {"value": 0.04}}
    assert scores.exact(record(pair, ("delay", 0.04), ("added_mass", 0.005)))
    assert not scores.all_named(record(pair, ("delay", 0.04)))
    more = record(pair, ("delay", 0.04), ("added_mass", 0.005), ("ground_effect", 0.1))
    assert scores.all_named(more)
    assert not scores.exact(more)


def test_parameter_errors_are_relative_to_the_deviation_from_null() -> None:
    assert scores.parameter_errors(record(MASS, ("added_mass", 0.0055))) == pytest.approx([0.1])
    gain = {"gain:thrust": {"value": 0.9}}
    assert scores.parameter_errors(record(gain, ("gain:thrust", 0.91))) == pytest.approx([0.1])
    assert scores.parameter_errors(record(MASS, ("gain:thrust", 0.85))) == []
    half = record({"periodic_force": {"value": 0.03, "omega": 0.04}}, ("periodic_force", 0.03))
    assert scores.parameter_errors(half) == pytest.approx([0.8])  # 4 of 5: one parameter right, one not found
    assert scores.covered(record(MASS, ("added_mass", 0.0051))) == [True]
    assert scores.covered(record(MASS, ("added_mass", 0.006))) == [False]


def test_figures_hold_the_bars_of_right_answers_and_miss_those_of_wrong_ones() -> None:
    good = [record(MASS, ("added_mass", 0.005)) for _ in range(4)] + [record({}) for _ in range(20)]
    bad = [record(MASS, ("ground_effect", 0.1)) for _ in range(4)] + [record({}, ("wind", 0.1)) for _ in range(20)]
    held = {figure.name: figure.holds for figure in scores.figures(good, "crazyflie") if figure.bar}
    missed = {figure.name: figure.holds for figure in scores.figures(bad, "crazyflie") if figure.bar}
    assert all(held.values())
    assert not missed["crazyflie, first effect right: 0 of 4 (95 %: 0.00 to 0.49)"]
    assert not missed["crazyflie, false alarms in 20 null cases"]


def test_calibration_counts_intervals_of_lower_levels_and_what_is_left_beside_wrong_findings() -> None:
    # Intervals are ± 5 %, so that a 50 % interval is ± 1.7 %.
    records = [record(MASS, ("added_mass", 0.005 * (1 + off))) for off in (0.01, -0.01, 0.03, 0.06)]
    records.append(
        record(MASS, ("delay", 0.02), kind="removed", excluded=["added_mass"], leftover={"explained_by": "time"})
    )
    found = {figure.name.partition(" (")[0]: figure.value for figure in scores.calibration(records, "crazyflie")}
    assert found == {
        "crazyflie, 50 % interval holds the truth: 2 of 4": 0.5,
        "crazyflie, 80 % interval holds the truth: 3 of 4": 0.75,
        "crazyflie, finding right where nothing is left over: 4 of 4": 1.0,
        "crazyflie, finding right where something is left over: 0 of 1": 0.0,
    }
