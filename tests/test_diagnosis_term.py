"""What no effect explains: a term is proposed, marked unverified, lowers errors of fresh flights, and can be added."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy
from standard_set import Case, simulate_case

from sym2real.cli import main
from sym2real.dataset import Dataset
from sym2real.diagnosis import add_term, compare, diagnose
from sym2real.errors import ModelError, UnknownNameError
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic import load_model, save_model
from sym2real.trajectory import Trajectory

# Everything that a drag could be taken for, and much else to keep the test short: mass, thrust's offset and motor lag
# compete.
OUT = (
    *("*drag", "wind", "mounting_tilt", "translational_lift", "flapping_moment", "thrust_curve", "ground_effect"),
    *("gain:*", "limit:*", "delay*", "lag*", "battery_sag", "torque_bias", "com_offset"),
)


@pytest.fixture(scope="module")
def flights() -> Dataset:
    """Flights against a drag that the library has been robbed of."""
    return simulate_case(Case("crazyflie", (("quadratic_drag", {"value": 0.05}),), seed=3), trajectories=10, rows=300)


@pytest.mark.slow
def test_a_term_is_proposed_and_lowers_the_error_of_flights_not_seen(flights: Dataset, tmp_path: Path) -> None:
    base = CRAZYFLIE.nominal()
    logs = list(flights)
    fitted, fresh = Dataset([*logs[:2], *logs[4:]]), Dataset(logs[2:4])
    found = diagnose(base, fitted, exclude=OUT)
    assert found.leftover is not None
    assert " N where " in found.leftover.term
    assert found.proposal is not None
    assert found.proposal.gain > 0.0
    assert found.leftover.channel == found.proposal.channel
    assert any(column in found.proposal.expression for column in ("vx", "vy", "vz"))
    written = found.to_dict()["leftover"]
    assert written["term"] == found.proposal.expression
    assert written["verified"] is False
    informed = add_term(found.apply(base), found.proposal.channel, found.proposal.expression)
    assert any("unverified" in note for note in informed.notes)
    before, after = (compare(model, fresh).at(0.8).errors["position"].value for model in (found.apply(base), informed))
    assert after < 0.95 * before
    save_model(base, tmp_path / "base")
    term, file = f"term:{found.proposal.channel}={found.proposal.expression}", tmp_path / "added.json"
    main(["add", str(tmp_path / "base"), term, "--out", str(tmp_path / "new"), "--json", str(file)])
    assert json.loads(file.read_text())["effects"][0]["expression"] == found.proposal.expression
    assert load_model(tmp_path / "new").latex() == add_term(base, *term.removeprefix("term:").split("=")).latex()


def test_a_term_acts_where_its_channel_stands_and_may_use_time() -> None:
    base = CRAZYFLIE.nominal()
    changed = add_term(base, "fz", "0.01*t - 0.2*vz")
    assert "t" in changed.layouts.inputs
    assert "vz" in {one.name for one in changed.next["vz"].free_symbols}
    assert changed.next["x"] == base.next["x"]


@pytest.mark.parametrize(
    ("channel", "expression", "error", "message"),
    [
        ("fq", "vx", UnknownNameError, "did you mean"),
        ("fz", "vq", UnknownNameError, "vq"),
        ("fz", "vx +", ModelError, "term of fz"),
    ],
)
def test_a_broken_term_gets_one_clear_error(
    channel: str, expression: str, error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        add_term(CRAZYFLIE.nominal(), channel, expression)


@pytest.mark.slow
def test_a_term_beside_a_battery_by_voltage_is_of_the_size_of_what_is_missing() -> None:
    """A sag per volt that is taken for one per second would leave newtons for the term to make up."""
    hidden = (("battery_sag", {"value": 0.01}), ("wind", {"fx": 0.02}))

    def with_voltage(log: Trajectory) -> Trajectory:
        return replace(log, extra={**log.extra, "vbat": 4.1 - 0.05 * (log.time - log.time[0])})

    flights = Dataset(with_voltage(log) for log in simulate_case(Case("crazyflie", hidden, seed=21), 6, 300))
    out = [one for one in OUT if one != "battery_sag"]
    found = diagnose(CRAZYFLIE.nominal(), flights, exclude=out)
    assert found.findings[0].parameters["value"].unit == "1/V"
    assert found.proposal is not None
    # The voltage falls evenly: to depend on it is to depend on time.
    term = sympy.lambdify(sympy.symbols("t vbat"), sympy.sympify(found.proposal.expression))
    assert np.abs(term(flights[0].time, flights[0].extra["vbat"])).max() < 0.1
