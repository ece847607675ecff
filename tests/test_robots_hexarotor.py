"""Six motors that are commanded themselves: the whole way, and five effects that nobody is told of."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
import whole_way

from sym2real.cli import main
from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.effects import effect
from sym2real.errors import ModelError
from sym2real.experiments.noisy_runs import noisy_runs
from sym2real.experiments.standard_conditions import sensors
from sym2real.plants import MujocoPlant
from sym2real.protocols import Change
from sym2real.robots import CRAZYFLIE, ROBOTS, Motors
from sym2real.symbolic import Equations, compile_model, symbol
from sym2real.tasks import make_task

HEXAROTOR = ROBOTS["hexarotor"]
HIDDEN = [
    ("added_mass", {"value": 0.15}, set()),
    ("rotor_loss", {"rotor": 5, "value": 0.1}, set()),
    ("com_offset", {"rx": 0.01}, set()),
    ("wind", {"fx": 0.5}, set()),
    ("motor_lag", {"value": 0.05}, {"lag"}),
]


@pytest.fixture(scope="module")
def base() -> Equations:
    return HEXAROTOR.nominal()


def noisy_flights(key: str = "", values: dict[str, float] | None = None, count: int = 4) -> Dataset:
    tasks = [make_task(name, HEXAROTOR) for name in ("circle", "lemniscate")]
    return noisy_runs(HEXAROTOR, tasks, [(key, values or {})] if key else [], count=count, rows=250, seed=5)


def test_equations_of_six_rotors_are_the_simulator(base: Equations) -> None:
    """Thrust and torques come from MuJoCo's sites and gears there, from arms, angles and spins here."""
    model, plant, rng = compile_model(base, dtype=torch.float64), MujocoPlant(HEXAROTOR), np.random.default_rng(0)
    for _ in range(5):
        state, action = HEXAROTOR.start.copy(), HEXAROTOR.rest + rng.uniform(-0.2, 0.2, 6)
        state[7:] = rng.uniform(-0.5, 0.5, 6)
        push = 0.2 * rng.uniform(-1.0, 1.0, 6)
        plant.reset(state)
        plant.push(push)
        after = plant.step(action)
        found = model(*map(torch.as_tensor, (state, action, push))).numpy()
        assert np.abs(found - after).max() < 2e-3 * np.abs(after - state).max()


@pytest.mark.slow
def test_weak_rotors_are_no_mass(base: Equations) -> None:
    """Their torques fall with their thrusts, which one number says; a mass would need three levers beside it."""

    def weaken(spec: Any) -> None:
        for actuator in spec.actuators:
            actuator.gear = [0.9 * gear for gear in actuator.gear]

    def weak(rng: np.random.Generator) -> MujocoPlant:
        return MujocoPlant(HEXAROTOR, (sensors(HEXAROTOR, rng), Change("weak", edit=weaken)))

    tasks = [make_task(name, HEXAROTOR) for name in ("circle", "lemniscate")]
    found = diagnose(base, noisy_runs(HEXAROTOR, tasks, count=4, rows=250, plant=weak))
    assert [finding.effect for finding in found.findings] == ["gain:thrust"], found.summary
    assert "added_mass" not in found.findings[0].group
    value = found.findings[0].parameters["value"]
    assert value.low < 0.9 < value.high


@pytest.mark.slow
@pytest.mark.parametrize(("key", "values", "alike"), HIDDEN, ids=[key for key, *_ in HIDDEN])
def test_a_hidden_effect_of_the_hexarotor_is_named(
    key: str, values: dict[str, float], alike: set[str], base: Equations
) -> None:
    found = diagnose(base, noisy_flights(key, values))
    assert found.verdict == "EFFECT", found.summary
    first = found.findings[0]
    assert first.effect in {key, *alike} or key in first.group, found.summary
    if key == "rotor_loss":
        assert first.values["rotor"] == 5


def test_a_plain_hexarotor_misses_nothing(base: Equations) -> None:
    found = diagnose(base, noisy_flights())
    assert (found.verdict, found.findings) == ("NOTHING_MISSING", ())


@pytest.mark.slow
def test_the_whole_way_from_the_command_line(tmp_path: Path) -> None:
    main(["learn", "hexarotor", "--out", str(tmp_path / "base")])
    log = noisy_flights("added_mass", {"value": 0.15}, count=1)[0]
    whole_way.go(tmp_path / "base", log, "hover", ["added_mass", "value=0.15"], channel="position", folder=tmp_path)


def test_a_rotor_that_a_robot_has_not_is_refused(base: Equations) -> None:
    for robot, rotors in ((HEXAROTOR, 6), (CRAZYFLIE, 4)):
        with pytest.raises(ModelError, match=f"or {rotors}, found {rotors + 1}"):
            effect("rotor_loss", robot).inject(rotor=rotors + 1, value=0.1)


def test_four_rotors_by_their_angles_are_the_firmwares_mixer() -> None:
    """Roll and pitch of X: a force times arm/√2 each, left and back positive (the firmware's power distribution)."""
    forces = [symbol(f"motor{number}") for number in range(1, 5)]
    roll, pitch, yaw = Motors(1.0, arm=0.046).torques(forces)
    lever = 0.046 / np.sqrt(2.0)
    signs = {roll: (-1, -1, 1, 1), pitch: (-1, 1, 1, -1)}
    for torque, sides in signs.items():
        assert [float(torque.coeff(force)) for force in forces] == pytest.approx([lever * side for side in sides])
    assert [float(yaw.coeff(force)) for force in forces] == pytest.approx([-0.00596, 0.00596, -0.00596, 0.00596])


def test_rotors_without_a_spin_or_an_angle_are_refused() -> None:
    with pytest.raises(ModelError, match="found 6 and 4"):
        Motors(1.0, spin=(-1, 1, -1, 1, -1, 1))
