"""Where a model fails: planted failures are found with their bounds, and nothing is said of what is not there."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset
from sym2real.diagnosis import compare
from sym2real.diagnosis.errors.by_window import WindowErrors, window_errors
from sym2real.diagnosis.errors.regions import locate, where_of, worst_segments
from sym2real.errors import DataError, ShapeError
from sym2real.logs.conditions import UNITS, features, over_windows, training_range
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic.storage import training_region


def planted(factor: float = 4.0, logs: int = 4, seed: int = 0) -> WindowErrors:
    """Errors that are ``factor`` times larger below 0.3 m, beside a feature without any meaning."""
    rng, windows = np.random.default_rng(seed), 80
    height, speed = rng.uniform(0.0, 1.0, (2, logs * windows))
    size = np.abs(rng.normal(0.02, 0.004, logs * windows)) * np.where(height < 0.3, factor, 1.0)
    log = np.repeat(np.arange(logs), windows)
    start = np.tile(0.1 * np.arange(windows), logs)
    return WindowErrors(
        errors={"z": size},
        floor={"z": 0.001},
        features={"height": height, "speed": speed},
        log=log,
        group=log,
        start=start,
        end=start + 0.5,
        names=tuple(f"log_{index}" for index in range(logs)),
        units=UNITS,
    )


def test_a_planted_region_is_found_with_its_bound_ratio_and_coverage() -> None:
    (where,) = where_of(planted())
    assert (where.channel, where.feature) == ("z", "height")
    assert where.low == pytest.approx(0.0, abs=0.02)
    assert 0.28 < where.high < 0.32
    assert where.ratio == pytest.approx(4.0, rel=0.1)
    assert where.coverage == pytest.approx(0.3, abs=0.05)
    assert "height is below" in where.statement
    assert where.inside_training is None


def test_errors_without_a_pattern_give_no_statement() -> None:
    assert not [seed for seed in range(5) if where_of(planted(factor=1.0, seed=seed))]


def test_the_training_region_is_compared() -> None:
    assert where_of(planted(), {"z": (0.5, 1.5)})[0].inside_training is False
    inside = where_of(planted(), {"z": (0.0, 1.5)})[0]
    assert inside.inside_training is True
    assert "inside the training region" in inside.statement


def test_the_object_has_the_names_of_the_design() -> None:
    names = ["statement", "channel", "feature", "low", "high", "ratio", "coverage", "inside_training"]
    entry = asdict(where_of(planted())[0])
    assert list(entry) == names
    json.dumps(entry)


def test_worst_segments_do_not_overlap_and_come_in_order() -> None:
    segments = worst_segments(planted(), 5)
    assert [one.error for one in segments] == sorted((one.error for one in segments), reverse=True)
    assert segments[0].error == planted().errors["z"].max()
    for i, one in enumerate(segments):
        for other in segments[:i]:
            assert one.log != other.log or one.end <= other.start or other.end <= one.start


def test_logs_of_one_name_are_different_logs_when_the_worst_seconds_are_sought() -> None:
    errors = planted()
    unnamed = worst_segments(replace(errors, names=("",) * len(errors.names)), 20)
    assert unnamed == tuple(replace(one, log="") for one in worst_segments(errors, 20))


def test_the_worst_seconds_are_those_that_stand_out_from_the_noise_whatever_the_unit() -> None:
    """An attitude that is off by 0.3 rad, of which noise makes 0.1, is nothing beside a height off by 0.08 m."""
    errors = planted()
    turned = np.full_like(errors.errors["z"], 0.3)
    both = replace(errors, errors={**errors.errors, "attitude": turned}, floor={**errors.floor, "attitude": 0.1})
    assert worst_segments(both) == worst_segments(errors)


def test_a_comparison_says_which_seconds_of_which_log_to_look_at() -> None:
    """A gust that no model knows moves the second of three flights by 0.3 m from its 2nd second on, within 0.5 s."""
    logs = [replace(simulate_case(Case("crazyflie", seed=seed), 1, 200)[0], name=f"log_{seed}") for seed in range(3)]
    place, gust = logs[1].layouts.state.index("x"), np.clip((logs[1].time - logs[1].time[0] - 2.0) / 0.5, 0.0, 1.0)
    state = logs[1].state.copy()
    state[:, place] += 0.3 * gust
    found = compare(CRAZYFLIE.nominal(), Dataset([logs[0], replace(logs[1], state=state), logs[2]]))
    worst = found.worst[0]
    assert (worst.log, worst.channel) == ("log_1", "xy")
    assert worst.start < 2.5
    assert worst.end > 2.0
    where, what = (
        f"log_1 from {worst.start:.1f} to {worst.end:.1f} s",
        f"horizontal position off by {worst.error:.2g} m",
    )
    assert worst.statement == f"{where}: {what}"
    assert found.to_dict()["worst"][0]["unit"] == "m"


@pytest.mark.slow
def test_ground_effect_is_located_near_the_ground_in_flights() -> None:
    flights = simulate_case(Case("crazyflie", (("ground_effect", {"value": 0.35}),), 1), 6, 200)
    found = locate(CRAZYFLIE.nominal(), flights, {"z": (0.5, 1.5)})
    assert found[0].channel == "z"
    assert found[0].feature == "height"
    assert found[0].high < 0.25
    assert found[0].inside_training is False


def test_window_errors_refuse_logs_that_are_too_short() -> None:
    flight = simulate_case(Case("crazyflie"), 1, 8)
    with pytest.raises(ShapeError, match="10 rows"):
        window_errors(CRAZYFLIE.nominal(), flight)


def test_features_are_what_they_say() -> None:
    log = simulate_case(Case("crazyflie", seed=2), 1, 20)[0]
    said = features(log)
    assert np.array_equal(said["height"], log.column("z"))
    velocity = np.stack([log.column(name) for name in ("vx", "vy", "vz")], axis=1)
    assert np.allclose(said["speed"], np.sqrt((velocity**2).sum(1)))
    lowest = 2 * (log.column("qw") * log.column("qy") + log.column("qx") * log.column("qz"))
    across = 2 * (log.column("qy") * log.column("qz") - log.column("qw") * log.column("qx"))
    assert np.allclose(np.sin(said["tilt"]), np.hypot(lowest, across), atol=1e-9)
    means = over_windows(said["time"], np.array([0, 5]), 4)
    assert np.allclose(means, [said["time"][0:4].mean(), said["time"][5:9].mean()])


def test_training_ranges_of_norms_reach_the_farthest_corner() -> None:
    assert training_range("speed", {"vx": (-3.0, 1.0), "vy": (0.0, 4.0)}) == (0.0, 5.0)
    car = {"vx": (-0.8, 0.6), "vy": (-0.6, 0.1), "speed": (-1.0, 3.0)}  # the last is a command
    assert training_range("speed", car) == (0.0, 1.0)
    assert training_range("speed command", car) == (-1.0, 3.0)
    assert training_range("time", {"vx": (0.0, 1.0)}) is None
    reach = training_range("tilt", {"qx": (-np.sin(0.25), 0.1), "qy": (0.0, 0.0)})
    assert reach == pytest.approx((0.0, 0.5))


def test_a_model_folder_tells_its_region(tmp_path: Path) -> None:
    assert training_region(tmp_path) is None
    (tmp_path / "training.json").write_text('{"region": {"z": [0.2, 1.4]}}')
    assert training_region(tmp_path) == {"z": (0.2, 1.4)}
    (tmp_path / "training.json").write_text("{broken")
    with pytest.raises(DataError, match=r"training\.json"):
        training_region(tmp_path)
