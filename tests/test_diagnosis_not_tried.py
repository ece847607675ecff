"""What a diagnosis did not try is listed with the reason: an effect that was left out is not refuted."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from noisy_flights import flights
from quick_engines import Given
from test_effects_groups import ROWS, drive

from sym2real.cli import main
from sym2real.dataset import Dataset
from sym2real.diagnosis.predict.candidate import candidates, library_for
from sym2real.diagnosis.predict.competitors import EXCLUDED, NotTested, competing
from sym2real.effects.catalogue import known
from sym2real.effects.searching import ALONE
from sym2real.layout import Layout, Layouts
from sym2real.logs import write_log
from sym2real.regression import ENGINES
from sym2real.report.diagnosis import lines_by_reason
from sym2real.robots import CRAZYFLIE, MUSHR, Motors, quadrotor
from sym2real.symbolic import Equations, load_model
from sym2real.trajectory import Trajectory

BASE = CRAZYFLIE.nominal()


def reasons(equations: Equations, data: Dataset, exclude: tuple[str, ...] = ()) -> dict[str, str]:
    return {one.effect: one.reason for one in competing(equations, data, exclude)[1]}


def test_every_effect_of_the_robot_competes_or_has_a_reason() -> None:
    keys, others = competing(BASE, flights(), ["wind"])
    left_out = {one.effect: one.reason for one in others}
    assert all(left_out.values())
    assert not left_out.keys() & set(keys)
    assert left_out.keys() | set(keys) == {one.key for one in known(BASE)}
    assert left_out["wind"] == EXCLUDED
    assert left_out["sensor_scale:wx"].startswith("settled")
    assert "added_mass stands for it" in left_out["gain:thrust"]
    library = library_for(BASE, flights(), ["wind"])
    # What the list does not name has a candidate; a swing has one where one is found.
    tried = {library.key(one.name) for one in candidates(library, flights())}
    assert set(keys) - tried <= {"periodic_force"}


def test_a_command_that_never_varies_is_named() -> None:
    still = Dataset(replace(log, action=log.action * [1, 1, 1, 0]) for log in flights())
    found = reasons(BASE, still)
    assert "wz_cmd never varies" in found["gain:wz_cmd"]
    assert "gain:wx_cmd" not in found


def test_effects_that_only_a_change_of_a_command_shows_go_with_it() -> None:
    straight = Dataset(replace(log, action=log.action * 0.0) for log in flights())
    assert reasons(BASE, straight)["delay"] == "no command varies in these logs"
    circle = drive(np.full(ROWS, 0.2), np.full(ROWS, 0.9) + 0.1 * np.sin(np.arange(ROWS)))
    found = reasons(MUSHR.nominal(), Dataset([circle]))
    for key in ("relaxation_length", "understeer", "wheelbase", "gain:steer"):
        assert found[key] == "steer never varies in these logs", key
    assert not {"delay", "lag:speed", "yaw_drag"} & found.keys()


def test_motors_that_all_stay_show_no_map_of_their_thrust() -> None:
    base = quadrotor(0.03, interface="motors")
    log = Trajectory(
        np.arange(50) * base.dt,
        np.tile(CRAZYFLIE.start, (50, 1)),
        np.full((50, 4), 0.5),
        np.zeros((50, 6)),
        base.layouts,
    )
    assert reasons(base, Dataset([log]))["offset:thrust"] == "thrust never varies in these logs"


def test_one_of_two_lateral_commands_competes_where_the_other_stays() -> None:
    only = Dataset(replace(log, action=log.action * [1, 0, 1, 1]) for log in flights())
    found = {one.name for one in candidates(library_for(BASE, only), only)}
    assert {"lag:wx_cmd", "lag:wy_cmd"} & found == {"lag:wy_cmd"}
    both = {one.name for one in candidates(library_for(BASE, flights()), flights())}
    assert {"lag:wx_cmd", "lag:wy_cmd"} <= both


def test_what_brakes_and_what_reacts_competes_where_motors_turn_the_body() -> None:
    by_motors = quadrotor(0.03, interface="motors", motors=Motors(2.9e-8, "rad/s"))
    left_out = {one.key: one.searching.why_not(one.body) for one in known(by_motors)}
    assert not left_out["rate_damping"]
    assert not left_out["rotor_reaction"]
    assert "speeds, which are in the logs" in left_out["battery_sag"]
    told = {one.key: one.searching.why_not(one.body) for one in known(quadrotor(0.03, interface="motors"))}
    assert not told["battery_sag"]
    left_out = {one.key: one.searching.why_not(one.body) for one in known(BASE)}
    assert "rate_loop_gain" in left_out["rate_damping"]
    assert left_out["rotor_reaction"] == ALONE


@pytest.mark.parametrize(("missing", "lost"), [("mass", "wind"), ("jx", "torque_bias"), ("jx", "com_offset")])
def test_a_number_that_is_missing_is_a_reason_and_not_an_error(missing: str, lost: str) -> None:
    """Equations without wrench inputs, as logs give them: a push needs the mass, a torque the inertia."""
    inputs = replace(BASE.substitute(dict.fromkeys(BASE.layouts.inputs, 0.0)), layouts=without_inputs(BASE))
    assert lost not in reasons(inputs, flights())
    bare = replace(inputs, numbers={name: value for name, value in BASE.numbers.items() if name != missing})
    assert missing in reasons(bare, flights())[lost]
    assert lost not in library_for(bare, flights()).effects


def without_inputs(equations: Equations) -> Layouts:
    return Layouts(equations.layouts.state, equations.layouts.action)


def test_a_line_holds_all_effects_of_a_reason() -> None:
    alike = [NotTested(f"lag:motor{i}", "a") for i in (1, 2)] + [NotTested("wind", "b"), NotTested("payload", "a")]
    assert list(lines_by_reason(alike)) == ["lag:{motor1,motor2}, payload: a", "wind: b"]


@pytest.mark.slow
def test_a_model_learned_from_logs_keeps_robot_and_numbers_and_is_diagnosed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It has no wrench inputs and is the measured robot's own: nothing is calibrated, everything competes."""
    still = BASE.substitute(dict.fromkeys(BASE.layouts.inputs, 0.0))
    without_wrench = replace(still, layouts=replace(BASE.layouts, inputs=Layout(())), robot="", numbers={})
    monkeypatch.setitem(ENGINES._entries, "beam", Given(without_wrench))
    logs = [str(tmp_path / f"{number}.csv") for number in range(2)]
    for number, log in enumerate(logs):
        main(["simulate", "crazyflie", "circle", "--seed", str(number), "--seconds", "4", "--noise", "--out", log])
    model, found = str(tmp_path / "base"), tmp_path / "found"
    main(["learn", "crazyflie", "--data", *logs, "--numbers", "mass=0.03", "--out", model])
    learned = load_model(model)
    assert learned.robot == "crazyflie"
    assert learned.numbers == {**CRAZYFLIE.numbers, "mass": 0.03}
    main(["diagnose", model, *logs, "--exclude", "com_offset", "--out", str(found)])
    answer = json.loads((found / "diagnosis.json").read_text())
    left_out = {one["effect"]: one["reason"] for one in answer["not_tried"]}
    assert left_out["com_offset"] == EXCLUDED
    assert not left_out.keys() & {"wind", "linear_drag", "motor_lag", "torque_bias"}
    assert any("no plain simulator" in note for note in answer["notes"])


@pytest.mark.parametrize("typed", ["mass=heavy", "mass", "mass=nan", "weight=1"])
def test_a_number_that_the_robot_does_not_have_or_nobody_can_read_is_refused(typed: str, tmp_path: Path) -> None:
    log, out = str(tmp_path / "log.csv"), tmp_path / "model"
    write_log(flights()[0], log)
    with pytest.raises(SystemExit):
        main(["learn", "crazyflie", "--data", log, "--numbers", typed, "--out", str(out)])
    assert not out.exists()
