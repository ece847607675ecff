"""What is said of a finding: its share, what to change, what was settled before, and in the written answer."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from handwritten import boat, sailed
from motor_flights import equations, motor_flights
from noisy_flights import flights
from weighed_problems import weighed_problems

from sym2real.dataset import Dataset
from sym2real.diagnosis.estimate.swing import Swing
from sym2real.diagnosis.predict.candidate import candidates
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.score.finding import AS_SENT, Finding, findings, shares_of, with_details
from sym2real.diagnosis.search.intervals import about
from sym2real.diagnosis.search.select import Selection
from sym2real.effects import effect
from sym2real.effects.voltage import VOLTAGE, with_voltage
from sym2real.experiments.noisy_runs import noisy_runs
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.symbolic import Equations
from sym2real.tasks import make_task

WIND = Finding("wind", {"fx": about(0.02, 0.001, "N"), "fy": about(0.0, 0.001, "N")}, 0.7, group=("wind", "drag"))


@pytest.mark.parametrize(
    ("losses", "freedom", "shares"),
    [
        ([100.0, 60.0, 20.0], 20.0, [0.5, 0.5]),
        ([100.0, 60.0, 20.0], 0.0, [0.4, 0.4]),  # a fifth is left
        ([100.0, 60.0, 20.0], 50.0, [0.5, 0.5]),  # what nobody can explain was explained
        ([100.0, 164.0, 20.0], 20.0, [0.0, 1.0]),
        ([100.0, 100.0], 150.0, [0.0]),
        ([100.0], 20.0, []),
    ],
)
def test_shares_are_parts_of_the_excess(losses: list[float], freedom: float, shares: list[float]) -> None:
    assert shares_of(losses, freedom) == pytest.approx(shares)


def test_a_finding_is_written_with_its_battery_where_it_has_one_and_is_another_at_other_values() -> None:
    written = WIND.to_dict()
    assert written["spread_over_logs"] == {}
    assert {"log_spread", "voltage", "full_battery"}.isdisjoint(written)
    assert replace(WIND, voltage=4.2).to_dict()["full_battery"] == 4.2
    assert not any(written[doubt] for doubt in ("provisional", "small", "doubtful"))
    assert WIND.alternatives == ["drag"]
    moved = WIND.at({"fx": 0.5})
    assert moved.values == {"fx": 0.5, "fy": 0.0}
    assert (moved.parameters["fx"].low, moved.share) == (WIND.parameters["fx"].low, WIND.share)


def test_only_a_finding_that_goes_by_the_voltage_binds_it() -> None:
    base = CRAZYFLIE.nominal()
    assert WIND.bound(base) is base
    assert VOLTAGE in replace(WIND, voltage=4.2).bound(base).layouts.inputs


def chosen(key: str, base: Equations, data: Dataset) -> Selection:
    """One effect, which was found."""
    library = Library.of(base, [effect(key, base)])
    selection = Selection(weighed_problems(library, data), candidates(library, data), library.null)
    (joined,) = selection.ranked(selection.present, selection.candidates)
    selection.put(joined.chosen, joined.fit)
    return selection


@cache
def turned(key: str, value: float) -> Selection:
    """Drives of a car that has it."""
    tasks = [make_task(name, MUSHR) for name in ("circle", "reverse_circle")]
    data = noisy_runs(MUSHR, tasks, [(key, {"value": value})], count=2, rows=120, seed=3)
    return chosen(key, MUSHR.nominal(), data)


def only(selection: Selection, groups: dict[str, tuple[str, ...]] | None = None) -> Finding:
    (found,) = findings(selection, None, groups or {}, None)
    return found


@pytest.mark.parametrize(("key", "voltage"), [("battery_sag", 3.9), ("wind", None)])
def test_a_finding_that_goes_by_the_voltage_says_at_which_the_thrust_map_holds(key: str, voltage: float | None) -> None:
    base, logs = with_voltage(CRAZYFLIE.nominal(), 3.9), []
    for log in flights():
        falling = np.linspace(4.1, 3.7, len(log))[:, None]
        layouts = replace(log.layouts, inputs=base.layouts.inputs)
        logs.append(replace(log, layouts=layouts, inputs=np.hstack([log.inputs, falling])))
    assert only(chosen(key, base, Dataset(logs))).voltage == voltage


def test_a_gain_by_which_a_command_has_another_unit_is_said_to_look_so() -> None:
    slow = only(turned("gain:speed", 1 / 3.6))
    assert slow.fix.endswith("; speed in km/h looks the same")
    some = only(turned("gain:steer", 0.8))
    assert some.fix
    assert "looks the same" not in some.fix
    aside = only(turned("offset:steer", float(np.deg2rad(1.0))))  # a degree, and no unit
    assert "looks the same" not in aside.fix


def test_a_factor_on_a_number_of_the_model_is_said_as_that_number() -> None:
    """A boat of 25 kg that carries 5 kg more."""
    found = only(chosen("parameter:mass", boat(), sailed(12, mass=30.0)))
    factor, given = found.parameters["factor"], boat().parameters["mass"]
    assert factor.low < 30.0 / given < factor.high
    estimate, low, high = (f"{given * end:.4g}" for end in (factor.value, factor.low, factor.high))
    assert found.fix.startswith(f"mass = {estimate} (95 % {low} … {high}) in place of {given:g}; ")


def test_what_stands_for_a_finding_is_named_once_and_what_parts_them_where_something_does() -> None:
    selection = turned("offset:steer", 0.05)
    alone, alike = only(selection), only(selection, {"offset:steer": ("lever_arm", "offset:steer", "lever_arm")})
    assert alone.group == ("offset:steer",)
    assert alike.group == ("offset:steer", "lever_arm")
    assert (alone.separate_by, bool(alike.separate_by)) == ("", True)
    assert alone.provisional is (selection.problems.block_count < 10)
    assert alone.probability is None
    assert alone.share > 0.9


@pytest.mark.parametrize(
    ("every", "scale", "doubtful"),
    [(5, {}, True), (5, {"kz": 0.5}, True), (5, {"kz": 0.2}, False), (1, {"kx": 0.6, "ky": 0.6, "kz": 0.6}, False)],
    ids=["right", "half of one", "a fifth of one", "weak"],
)
def test_torques_that_look_weak_are_doubtful_where_commands_changed_between_rows(
    every: int, scale: dict[str, float], doubtful: bool
) -> None:
    """Held over a row of five they turn the model by more than they turned the robot; not by three times as much."""
    hidden = {"torque_scale": {"kx": 1.0, "ky": 1.0, "kz": 1.0} | scale} if scale else {}
    flights = motor_flights(every=every, period=0.01 / every, seconds=3.0, hidden=hidden, names=("circle", "hover"))
    found = only(chosen("torque_scale", equations(every=1), flights))
    assert (found.doubtful, found.fix == AS_SENT) == (doubtful, doubtful)


def test_what_was_settled_before_the_search_stands_with_what_was_found() -> None:
    """Which rotor is weak; how fast a force swings, and where it began in a single log."""
    base, logs = CRAZYFLIE.nominal(), flights()
    library = Library.of(base, [effect(key, base) for key in ("periodic_force", "wind")])
    swing, few = Swing(7.0, 0.01, (0.5,)), Dataset([logs[0]])
    force = Finding("periodic_force", {"fx": about(0.01, 0.001, "N")}, 0.3, group=("periodic_force", "wind"))
    found, wind = with_details([force, WIND], library, swing, few)
    assert found.values == {"omega": 7.0, "phase": 0.5, "fx": 0.01}
    assert wind.values == WIND.values
    omega, phase = found.parameters["omega"], found.parameters["phase"]
    assert (omega.unit, phase.unit) == ("rad/s", "rad")
    seconds = len(few[0]) * few[0].dt
    assert (phase.high - phase.low) / (omega.high - omega.low) == pytest.approx(seconds / 3**0.5)
    (several,) = with_details([force], library, swing, logs)
    assert several.values == {"omega": 7.0, "fx": 0.01}
    (none,) = with_details([WIND], library, None, logs)
    assert none.values == WIND.values
