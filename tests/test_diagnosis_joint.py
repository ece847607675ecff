"""Several effects as one hypothesis: fitted together, each judged by what it does beside the others."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import pytest
from noisy_flights import LEFT_OUT, flights_with_all

from sym2real.cli import main
from sym2real.diagnosis import add
from sym2real.diagnosis.adding import try_effect
from sym2real.diagnosis.score.hypothesis_test import HypothesisTest
from sym2real.errors import ModelError
from sym2real.logs import write_log
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic import load_model, save_model

BASE = CRAZYFLIE.nominal()
HIDDEN = {"linear_drag": {"cx": 0.02, "cy": 0.02, "cz": 0.0}, "com_offset": {"rx": 0.002, "ry": -0.001}}


@cache
def tried(*keys: str) -> HypothesisTest:
    return try_effect(BASE, keys, flights_with_all(HIDDEN), exclude=LEFT_OUT)


@pytest.mark.slow
def test_two_effects_that_are_there_are_found_together_and_neither_is_enough() -> None:
    both, alone = tried("com_offset", "linear_drag"), tried("linear_drag")
    assert both.supported
    assert both.refused == ()
    found = {one.effect: one.values for one in both.findings}
    assert found["com_offset"]["rx"] == pytest.approx(0.002, rel=0.1)
    assert found["linear_drag"]["cx"] == pytest.approx(0.02, rel=0.15)
    assert both.gain > alone.gain
    # Without an effect the others take what they can of it: parts are at most the whole.
    assert all(0.03 < part <= both.gain + 1e-9 for part in both.beside.values())
    assert both.ladder[-1].model.endswith(both.findings[-1].effect)
    assert len(both.ladder) == 3
    values = {key: dict(given) for key, given in both.apply(BASE).effects}
    assert values.keys() == {"com_offset", "linear_drag"}


@pytest.mark.slow
def test_the_order_in_which_a_hypothesis_is_named_does_not_matter() -> None:
    first, second = tried("com_offset", "linear_drag"), tried("linear_drag", "com_offset")
    assert [one.effect for one in first.findings] == [one.effect for one in second.findings]
    assert first.gain == pytest.approx(second.gain, rel=1e-6)
    for one, other in zip(first.findings, second.findings, strict=True):
        assert one.values == pytest.approx(other.values, rel=1e-4, abs=1e-9)


@pytest.mark.slow
def test_an_effect_that_is_not_there_is_refused_beside_those_that_are() -> None:
    three = tried("com_offset", "linear_drag", "wind")
    assert not three.supported
    assert three.refused == ("wind",)
    assert "wind lowers what the others leave by" in three.summary
    assert {one.effect for one in three.findings} == {"com_offset", "linear_drag", "wind"}


def test_alternatives_are_fitted_in_the_place_of_each() -> None:
    both = tried("com_offset", "linear_drag")
    assert {one.instead_of for one in both.rivals} <= {"com_offset", "linear_drag"}
    assert all(one.gain <= both.beside[one.instead_of] + 0.01 for one in both.rivals)
    answer = both.to_dict()
    assert "finding" not in answer
    assert [one["effect"] for one in answer["findings"]] == [one.effect for one in both.findings]


def test_a_fit_of_several_takes_names_and_no_values() -> None:
    with pytest.raises(ModelError, match="found both"):
        add(BASE, ["wind", ("com_offset", {"rx": 0.001})], fit=flights_with_all(HIDDEN))


@pytest.mark.slow
def test_the_command_fits_several_and_writes_one_model(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    logs = [str(tmp_path / f"{number}.csv") for number in range(4)]
    for log, file in zip(flights_with_all(HIDDEN), logs, strict=True):
        write_log(log, file)
    save_model(BASE, tmp_path / "base")
    model, out, file = str(tmp_path / "base"), tmp_path / "both", tmp_path / "tried.json"
    options = ["--fit", *logs, "--exclude", *LEFT_OUT, "--no-calibrate", "--json", str(file), "--out", str(out)]
    with pytest.raises(SystemExit):
        main(["add", model, "wind", "fx=0.1", "com_offset", *options])
    assert "expected their names alone" in capsys.readouterr().err.replace("\n", " ")
    main(["add", model, "com_offset", "linear_drag", *options])
    assert "SUPPORTED The logs ask for" in capsys.readouterr().out
    answer = json.loads(file.read_text())
    assert {key for key, _ in load_model(out).effects} == {one["effect"] for one in answer["findings"]}
    assert answer["beside"].keys() == {"com_offset", "linear_drag"}
