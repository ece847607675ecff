"""Stages II and III: a target with a hidden effect, interrupted and misled; and recordings in its place."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from adaptation_runs import NARROW, SMALL, adapted_to_wind, windy
from forked import in_fork
from rich.console import Console
from tracked import episode

from sym2real.adaptation import Adaptation, Adapting, Improvement, adapt, improvement
from sym2real.adaptation.episode_report import episode_cost
from sym2real.adaptation.predictions import horizon_errors, in_shares, one_step_error
from sym2real.adaptation.progress import silent
from sym2real.adaptation.round_report import Learned, RoundReport, best_of, lost, settled
from sym2real.adaptation.rounds import Rounds
from sym2real.adaptation.training import Training, unless_withdrawn
from sym2real.control import RandomCommands
from sym2real.dataset import Dataset, Transitions
from sym2real.diagnosis import add
from sym2real.effects import compose, effect
from sym2real.errors import DataError, ModelError
from sym2real.experiments.learners import NoResidual
from sym2real.files import read_as
from sym2real.json_objects import plain
from sym2real.logs import read_log, read_logs
from sym2real.neural import Composed, Descent, EnsembleTraining, ResidualMLP, ResidualTraining
from sym2real.plants import EquationsPlant, MujocoPlant, run_episode
from sym2real.report.adaptation import rounds_report
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.symbolic import Equations
from sym2real.tasks import make_task
from sym2real.trajectory import Trajectory


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("adapted") / "to_wind"


@pytest.fixture(scope="module")
def adapted(folder: Path) -> Adaptation:
    return adapted_to_wind(folder)


def test_a_folder_knows_the_model_that_was_its_target(tmp_path: Path) -> None:
    """Else the drives in one model are gone on with as if they had been in the other."""
    base, settings, task = MUSHR.nominal(), Adapting(rounds=1, steps=20, samples=16), make_task("circle", MUSHR)
    targets = [EquationsPlant(add(base, "offset:steer", {"value": value}), MUSHR) for value in (0.05, 0.2)]
    for target in (targets[0], targets[0]):
        adapt(base, target, task, NoResidual(), settings, folder=tmp_path)
    with pytest.raises(ModelError, match="a run with other settings"):
        adapt(base, targets[1], task, NoResidual(), settings, folder=tmp_path)


def test_seeds_may_be_numpys(tmp_path: Path) -> None:
    """As of ``for seed in np.arange(3)``."""

    def run(one: Any, folder: Path | None = None) -> Adaptation:
        learner = ResidualTraining(widths=(4,), steps=2, penalties=(0.1,), descent=Descent(steps=4), seed=one)
        settings = Adapting(rounds=1, steps=60, samples=16, seed=one)
        task = make_task("circle", MUSHR)
        return adapt(MUSHR.nominal(), MujocoPlant(MUSHR), task, learner, settings, folder=folder)

    theirs, ours = run(np.int64(1), tmp_path), run(1)
    for log, other in zip(theirs.logs, ours.logs, strict=True):
        np.testing.assert_array_equal(log[0].state, other[0].state)
    networks = EnsembleTraining(members=2, widths=(4,), seed=np.int64(1), descent=Descent(steps=2))
    assert networks.fit(Dataset(ours.logs[0]).transitions()).widths == (4,)


def test_errors_fall_with_the_first_trajectory(adapted: Adaptation) -> None:
    zero_shot, first, _ = adapted.reports
    assert first.error < 0.5 * zero_shot.error
    assert first.cost < zero_shot.cost
    assert first.one_step < 0.5 * zero_shot.one_step
    assert first.gain.low > 0.5
    assert not any(report.crashed or report.learned.refused for report in adapted.reports)
    assert [report.learned.rows for report in adapted.reports] == [0, SMALL.steps, 2 * SMALL.steps]
    assert adapted.best > 0


def test_every_log_is_held_out_to_the_model_that_flew_it(adapted: Adaptation) -> None:
    """The same episodes again, one by one: a model knows the logs before its own and no others."""
    again = NARROW.fit(adapted.logs[0].transitions(), CRAZYFLIE.nominal())
    log, rows = adapted.logs[1], np.array([0, 30, 60])
    state, action = (torch.as_tensor(values[rows]).float() for values in (log[0].state, log[0].action))
    kept = adapted.models[1](state, action, torch.zeros(3, 6))  # type: ignore[operator]
    torch.testing.assert_close(again(state, action, torch.zeros(3, 6)), kept, atol=1e-6, rtol=0)


def contents(folder: Path) -> dict[str, Any]:
    """Every file below a folder: its bytes, what JSON says but for the seconds, what ``module.pt`` computes.

    TorchScript numbers the classes of a process, so that its files hold names that nobody chose.
    """
    found: dict[str, Any] = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.name == "module.pt":
            module = torch.jit.load(str(path))
            state, action = torch.linspace(-1.0, 1.0, 13), torch.linspace(0.1, 0.5, 4)
            found[name] = module(state, action, torch.zeros(6)).tolist()
        elif path.suffix == ".json":
            found[name] = comparable(json.loads(path.read_text()))
        elif path.is_file():
            found[name] = path.read_bytes()
    return found


def comparable(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: comparable(part) for name, part in value.items() if name not in ("seconds", "module.pt")}
    return [comparable(part) for part in value] if isinstance(value, list) else value


def test_a_killed_run_goes_on_to_the_same_bytes(folder: Path, adapted: Adaptation, tmp_path: Path) -> None:
    """Killed in flight, then while it learns."""
    killed = in_fork(lambda: adapted_to_wind(tmp_path / "run", "round 1: circle"), tmp_path)
    assert killed.status == -9
    killed = in_fork(lambda: adapted_to_wind(tmp_path / "run", "round 2: learning"), tmp_path)
    assert killed.status == -9
    assert not (tmp_path / "run" / "rounds" / "02" / "round.json").exists()
    kept = (tmp_path / "run" / "rounds" / "00" / "log.parquet").stat().st_mtime_ns
    continued = adapted_to_wind(tmp_path / "run")
    assert (tmp_path / "run" / "rounds" / "00" / "log.parquet").stat().st_mtime_ns == kept
    assert contents(tmp_path / "run") == contents(folder)
    assert continued.best == adapted.best


def test_logs_and_models_of_rounds_open_by_themselves(folder: Path, adapted: Adaptation) -> None:
    log = read_log(folder / "rounds" / "01" / "log.parquet")
    np.testing.assert_array_equal(log.state, adapted.logs[1][0].state)
    answer = json.loads((folder / "adaptation.json").read_text())
    assert answer["best"] == adapted.best
    assert [entry["error"] for entry in answer["rounds"]] == [report.error for report in adapted.reports]
    on_top = folder / "residual.safetensors"
    assert on_top.read_bytes() == (folder / "rounds" / f"{adapted.best:02d}" / on_top.name).read_bytes()


@dataclass(frozen=True)
class Misled:
    """A residual whose training has diverged: its weights are too large by this factor."""

    factor: float

    def fit(self, transitions: Transitions, base: Equations, start: object = None) -> Composed:
        residual = ResidualMLP(transitions.layouts, (8,))
        with torch.no_grad():
            for weight in residual.parameters():
                weight.uniform_(-self.factor, self.factor, generator=torch.Generator().manual_seed(1))
        return Composed(base, residual)


@pytest.mark.parametrize(("factor", "said"), [(0.3, "of its predictions have a"), (1e30, "value that is not finite")])
def test_a_wild_model_does_not_fly(factor: float, said: str, tmp_path: Path) -> None:
    settings = replace(SMALL, rounds=1, steps=80)
    task = make_task("hover", CRAZYFLIE)
    found = adapt(CRAZYFLIE.nominal(), windy(), task, Misled(factor), settings, folder=tmp_path)
    refused = found.reports[1].learned.refused
    assert found.reports[1].gain == Improvement()
    assert said in refused
    assert found.best == 0
    assert not found.reports[1].crashed
    # The model that flew instead is the one before, and so is the one on top.
    assert isinstance(found.models[1], Equations)
    assert found.models[1].to_json() == found.models[0].to_json()
    assert not (tmp_path / "residual.safetensors").exists()


@dataclass(frozen=True)
class WorseThenWild:
    """Learners of one log shift the height a little, learners of more diverge."""

    def fit(self, transitions: Transitions, base: Equations, start: object = None) -> Composed:
        if len(set(transitions.trajectory.tolist())) > 1:
            return Misled(1e30).fit(transitions, base)
        model = Misled(0.0).fit(transitions, base)
        with torch.no_grad():
            model.residual.linears[-1].bias[2] = 1e-2  # m a step
        return Composed(base, model.residual)


def test_where_a_model_must_not_fly_the_best_one_does_and_not_the_one_before() -> None:
    logs = [Dataset([episode(MujocoPlant(CRAZYFLIE), seed=seed)]) for seed in range(3)]
    found = adapt(CRAZYFLIE.nominal(), logs, None, WorseThenWild(), Adapting(rounds=2), robot=CRAZYFLIE)
    assert found.reports[1].gain.value < 0.0
    assert "not finite" in found.reports[2].learned.refused
    assert found.models[2] is found.models[0]


def test_a_log_too_short_to_learn_from_ends_nothing() -> None:
    """Upside down on the ground in no time: training has too few rows, the next round flies again."""
    plant = MujocoPlant(CRAZYFLIE, [effect("gain:thrust", CRAZYFLIE).inject(value=0.05)])
    task = make_task("hover", CRAZYFLIE)
    found = adapt(CRAZYFLIE.nominal(), plant, task, NARROW, replace(SMALL, rounds=1, steps=120))
    assert found.reports[0].crashed
    assert found.reports[0].error > 0.5 * CRAZYFLIE.limits.workspace * (1.0 - found.reports[0].rows / 120)
    assert found.reports[0].cost > found.reports[0].error * 0.5
    assert not settled(found.reports)
    assert [report.best_crashed for report in found.reports] == [False, True]


def recordings(count: int) -> list[Dataset]:
    """Circles in the wind, flown by a controller that needs no model."""
    return [Dataset([episode(windy(), steps=220, seed=k, name=f"f{k}")]) for k in range(count)]


@pytest.mark.slow
def test_recordings_take_the_place_of_flights(tmp_path: Path) -> None:
    logs = recordings(3)
    found = adapt(CRAZYFLIE.nominal(), logs, None, NARROW, Adapting(rounds=9), robot=CRAZYFLIE, folder=tmp_path)
    assert [report.log for report in found.reports] == ["f0", "f1", "f2"][: len(found.reports)]
    assert found.reports[1].prediction < 0.3 * found.reports[0].prediction
    assert found.reports[1].gain.low > 0.0
    assert found.reports[1].error == pytest.approx(found.reports[0].error, rel=0.2)  # nobody flew any better
    assert not (tmp_path / "rounds" / "00" / "log.parquet").exists()
    with pytest.raises(ModelError, match="at least two logs"):
        adapt(CRAZYFLIE.nominal(), logs[:1], None, NARROW)


@pytest.mark.slow
def test_no_step_is_learned_across_a_gap() -> None:
    """Half a second that is missing from logs made in Python: a step of it, taken for one, is 25 times as long."""
    whole = [log for recording in recordings(2) for log in recording]
    rows = np.r_[0:100, 125:220]
    torn = [
        Trajectory(
            *(values[rows] for values in (log.time, log.state, log.action, log.inputs)), log.layouts, name="torn"
        )
        for log in whole
    ]
    found, wanted = (
        adapt(CRAZYFLIE.nominal(), logs, None, NARROW, Adapting(rounds=1), robot=CRAZYFLIE).reports[1].prediction
        for logs in (torn, whole)
    )
    assert found < 1.3 * wanted


def test_measured_drives_are_predicted_better_with_every_trajectory(shared_data: Path) -> None:
    folder = shared_data / "mushr_steering_offset"
    base = MUSHR.nominal()
    paths = sorted(folder.glob("*.csv"))[:3]
    logs = [read_logs([path], spec=folder.name, layouts=base.layouts, dt=base.dt) for path in paths]
    found = adapt(base, logs, None, NARROW, Adapting(rounds=2), robot=MUSHR)
    assert found.best > 0
    assert found.reports[1].gain.low > 0.0


def test_effects_go_below_the_residual() -> None:
    """The callable adds the true wind: nothing is left, and the base that was given stays as it is."""
    base, seen = CRAZYFLIE.nominal(), []

    def inform(logs: Dataset, equations: Equations) -> Equations:
        seen.append(len(logs))
        return compose(equations, [(effect("wind", equations), {"fx": 0.03, "fy": -0.02})])

    task = make_task("circle", CRAZYFLIE)
    found = adapt(base, windy(), task, NoResidual(), SMALL, inform=inform)
    assert seen == [1, 2]
    assert found.reports[1].learned.effects == ("wind",)
    assert found.reports[1].one_step < 0.05 * found.reports[0].one_step
    assert found.reports[1].error < found.reports[0].error
    assert "wind" not in dict(base.effects)
    assert settled([found.reports[0], *[replace(found.reports[2], tracking=Improvement(0.0, -0.1, 0.1))] * 2])


def test_effects_that_flew_worse_are_withdrawn() -> None:
    """From the second log on the callable mistakes the wind for a weak rotor thrust: that flies once, and not again."""
    weak, wind = ("gain:thrust", {"value": 0.85}), ("wind", {"fx": 0.03, "fy": -0.02})

    def inform(logs: Dataset, equations: Equations) -> Equations:
        key, values = wind if len(logs) == 1 else weak
        return compose(equations, [(effect(key, equations), values)])

    task = make_task("circle", CRAZYFLIE)
    found = adapt(CRAZYFLIE.nominal(), windy(), task, NoResidual(), replace(SMALL, rounds=3), inform=inform)
    assert [report.learned.effects for report in found.reports[1:]] == [("wind",), ("gain:thrust",), ("wind",)]
    assert found.reports[2].surely_worse
    assert found.best in (1, 3)
    assert found.reports[3].error < 0.5 * found.reports[2].error


def test_an_effect_that_further_logs_do_not_establish_is_taken_back() -> None:
    """The first log alone makes a push that is not there; with two it is gone, and its model was not on top."""
    base = CRAZYFLIE.nominal()

    def inform(logs: Dataset, equations: Equations) -> Equations:
        assert equations.to_json() == base.to_json()
        wrong = [(effect("wind", equations), {"fx": -0.03})]
        return compose(equations, wrong) if len(logs) == 1 else equations

    logs = recordings(3)
    found = adapt(base, logs, None, NoResidual(), Adapting(rounds=9, until_settled=False), inform=inform)
    assert [report.learned.effects for report in found.reports] == [(), ("wind",), ()]
    assert found.reports[2].best_before == 0
    assert isinstance(found.model, Equations)
    assert found.model.to_json() == base.to_json()


def test_another_run_or_model_in_the_folder_is_refused(folder: Path, adapted: Adaptation, tmp_path: Path) -> None:
    task = make_task("circle", CRAZYFLIE)
    with pytest.raises(ModelError, match=r"changes: .*wind.* there, .* now"):
        adapt(CRAZYFLIE.nominal(), MujocoPlant(CRAZYFLIE), task, NARROW, SMALL, folder=folder)
    with pytest.raises(ModelError, match="steps: 200 there, 130 now"):
        adapt(CRAZYFLIE.nominal(), windy(), task, NARROW, replace(SMALL, steps=130), folder=folder)
    wider = make_task("circle", CRAZYFLIE, radius=0.8)  # the same name, another circle
    with pytest.raises(ModelError, match=r"reference: .* there, .* now"):
        adapt(CRAZYFLIE.nominal(), windy(), wider, NARROW, SMALL, folder=folder)
    (tmp_path / "equations.json").write_text("{}")
    with pytest.raises(ModelError, match="holds a model that was not adapted there"):
        adapt(CRAZYFLIE.nominal(), windy(), task, NARROW, SMALL, folder=tmp_path)
    with pytest.raises(ModelError, match="a robot and a task"):
        adapt(CRAZYFLIE.nominal(), windy(), None, NARROW)
    with pytest.raises(ModelError, match="at least one round"):
        Adapting(rounds=0)


def test_the_interval_covers_the_truth_although_neighbours_are_alike() -> None:
    """Errors with a time constant of ten rows, and a true improvement by 30 %."""
    rng, inside = np.random.default_rng(5), 0
    for _ in range(300):
        common, own = (np.empty(400), np.empty(400))
        for values in (common, own):
            noise = rng.standard_normal(400)
            values[0] = noise[0]
            for k in range(1, 400):
                values[k] = 0.9 * values[k - 1] + math.sqrt(1.0 - 0.81) * noise[k]
        before = 1.0 + 0.2 * common
        after = 0.7 * (1.0 + 0.2 * common + 0.1 * own)
        found = improvement(before, after, 40)
        inside += found.low <= 0.3 <= found.high
    assert inside / 300 > 0.88
    same = improvement(before, before, 40)
    assert (same.value, same.low, same.high) == (0.0, 0.0, 0.0)
    assert same.stalled
    assert not improvement(before[:50], after[:50], 40).stalled  # too short to say anything
    assert improvement(before, 1.5 * before, 40).surely_worse


def round_of(number: int, **changes: Any) -> RoundReport:
    fields: Mapping[str, Any] = {
        "log": "log", "rows": 100, "flown": True, "crashed": False, "error": 0.1, "cost": 0.2, "one_step": 0.1,
        "horizon": 0.8, "prediction": 0.1, "best_before": 0, "gain": Improvement(0.1, 0.0, 0.2),
        "tracking": Improvement(0.1, 0.05, 0.2), "learned": Learned(),
    }  # fmt: skip
    return RoundReport(number=number, **{**fields, **changes})


def test_a_table_has_the_unit_of_the_robots_places_and_says_that_every_episode_crashed() -> None:
    console = Console(width=160, record=True, file=StringIO())
    console.print(rounds_report([round_of(number, unit="rad", crashed=True) for number in range(2)]))
    text = console.export_text()
    assert "error rad" in text
    assert "0.8 s rad" in text
    assert "every episode ended in a crash" in text


def test_the_best_model_predicts_better_and_flies_no_worse() -> None:
    first = round_of(0, gain=Improvement(), tracking=Improvement())
    assert best_of([first]) == 0
    assert best_of([first, round_of(1)]) == 1
    alike = Improvement(0.1, -0.05, 0.2)
    assert best_of([first, round_of(1), round_of(2, gain=Improvement(-0.1, -0.3, 0.1), tracking=alike)]) == 1
    assert best_of([first, round_of(1, crashed=True)]) == 0
    assert best_of([replace(first, crashed=True), round_of(1, crashed=True)]) == 1
    assert best_of([first, round_of(1, tracking=Improvement(-0.5, -0.8, -0.2))]) == 0
    assert best_of([first, round_of(1, gain=Improvement(), tracking=alike)]) == 0  # nothing to compare
    flies = round_of(1, gain=Improvement(-0.3, -0.6, -0.1), tracking=Improvement(0.5, 0.4, 0.6))
    assert best_of([first, flies]) == 1
    assert not flies.surely_worse


def test_a_crash_is_evidence_where_the_best_model_did_not_crash() -> None:
    """Of the episode that it cut short nothing can be compared row by row."""
    unknown = {"gain": Improvement(-0.01, -0.1, 0.08), "tracking": Improvement()}
    whole, crashed = round_of(0, **unknown), round_of(0, crashed=True, **unknown)
    fallen = [round_of(number, crashed=True, **unknown) for number in (1, 2)]
    assert [report.surely_worse for report in fallen] == [True, True]
    assert lost([whole, *fallen])
    assert best_of([whole, *fallen]) == 0
    assert not replace(fallen[0], best_crashed=True).surely_worse
    assert not replace(fallen[0], learned=Learned(refused="it is the best one, again")).surely_worse
    assert best_of([crashed, round_of(1, **unknown)]) == 1
    assert best_of([crashed, round_of(1, gain=Improvement(-0.3, -0.5, -0.1), tracking=Improvement())]) == 0


def test_effects_that_crashed_are_withdrawn() -> None:
    base = CRAZYFLIE.nominal()
    weak = compose(base, [(effect("gain:thrust", base), {"value": 0.5})])
    fallen = round_of(1, crashed=True, tracking=Improvement(), learned=Learned(effects=("gain:thrust",)))
    assert unless_withdrawn(weak, [base, weak], [round_of(0), fallen]) is base


def test_the_loop_stops_when_nothing_gets_better() -> None:
    still = Improvement(0.02, -0.05, 0.09)
    rounds = [round_of(0), round_of(1), round_of(2, tracking=still), round_of(3, tracking=still)]
    assert settled(rounds)
    assert not settled(rounds[:3])
    assert not settled([*rounds[:3], round_of(3)])
    assert not settled([*rounds[:3], round_of(3, tracking=Improvement())])  # a crash says nothing
    assert settled([round_of(number, flown=False, gain=still) for number in range(3)])


def test_the_report_of_a_round_survives_its_file(tmp_path: Path) -> None:
    file = tmp_path / "round.json"
    for report in (round_of(2), round_of(3, gain=Improvement(), tracking=Improvement(0.1))):
        file.write_text(json.dumps(plain(report)))
        assert plain(read_as(file, RoundReport, "a round")) == plain(report)
    assert read_as(file, RoundReport, "a round").gain.high == math.inf
    file.write_text('{"number": 1}')
    with pytest.raises(DataError, match=r"round\.json: expected a round of an adaptation, found .*missing"):
        read_as(file, RoundReport, "a round of an adaptation")


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"rows": "many"}, r"`int`, got `str` - at `\$.rows`"),
        ({"effects": 3}, r"`array`, got `int` - at `\$.effects`"),
        ({"refused": True}, r"`str`, got `bool` - at `\$.refused`"),
    ],
)
def test_a_broken_round_is_one_clear_error(tmp_path: Path, changes: dict[str, Any], said: str) -> None:
    rounds = Rounds(tmp_path, CRAZYFLIE.layouts)
    plain = CRAZYFLIE.nominal()
    assert rounds.model(1, lambda: (plain, Learned(rows=3, effects=("wind",))))[1].effects == ("wind",)
    file = tmp_path / "rounds" / "01" / "learned.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), **changes}))
    with pytest.raises(DataError, match=f"learned.json: expected how a model was learned, found Expected {said}"):
        rounds.model(1, lambda: (plain, Learned()))
    file.write_text("[]")
    with pytest.raises(DataError, match=r"learned.json: expected how a model was learned"):
        rounds.model(1, lambda: (plain, Learned()))


def test_the_true_equations_predict_what_is_measured_through_their_sensors() -> None:
    """A tilted board and late commands: equations that know both are right about the log, those that do not are not."""
    plain = CRAZYFLIE.nominal()
    keys: dict[str, dict[str, float]] = {"mounting_tilt": {"roll": 0.05, "pitch": -0.03}, "delay": {"value": 0.04}}
    plant = MujocoPlant(CRAZYFLIE, [effect(key, CRAZYFLIE).inject(**values) for key, values in keys.items()])
    informed = compose(plain, [(effect(key, plain), values) for key, values in keys.items()])
    task, log = make_task("circle", CRAZYFLIE), episode(plant)
    assert one_step_error(informed, [log]) < 0.1 * one_step_error(plain, [log])
    assert horizon_errors(informed, [log], 20).mean() < 0.1 * horizon_errors(plain, [log], 20).mean()
    assert episode_cost(log, task, CRAZYFLIE, 400) > episode_cost(log, task, CRAZYFLIE, 200)


CRANE = """
<mujoco model="crane">
  <option timestep="0.002" integrator="RK4"/>
  <worldbody>
    <body name="trolley" pos="0 0 2">
      <joint name="rail" type="slide" axis="1 0 0" range="-40 40" limited="true" damping="4"/>
      <inertial pos="0 0 0" mass="3" diaginertia="0.01 0.01 0.01"/>
      <body name="hook">
        <joint name="sway" type="hinge" axis="0 1 0" range="-120 120" limited="true" damping="0.01"/>
        <inertial pos="0 0 -0.8" mass="1" diaginertia="0.01 0.01 0.01"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor name="drive" joint="rail" ctrlrange="-8 8" ctrllimited="true"/></actuator>
</mujoco>
"""


def test_a_joint_in_rad_counts_beside_one_in_m() -> None:
    """A crane whose rail is misread by a noise of centimetres, and whose sway alone has a hidden damping."""
    crane = Robot.from_mjcf(CRANE, name="crane", dt=0.02)
    base, key = crane.nominal(), "joint_damping:sway"
    informed = compose(base, [(effect(key, base), {"value": 0.1})])
    plant, rng = MujocoPlant(crane, [effect(key, crane).inject(value=0.1)]), np.random.default_rng(0)
    logs = []
    for seed in (1, 2):
        log = run_episode(plant, RandomCommands(crane, 0.6, seed), steps=700)
        noisy = log.state + rng.normal(size=log.state.shape) * [0.05, 0.0, 0.0, 0.0]
        logs.append(replace(log, state=noisy))
    found = adapt(base, logs, None, NoResidual(), Adapting(rounds=1), robot=crane, inform=lambda *_: informed)
    assert found.reports[1].gain.low > 0.2
    assert found.best == 1
    worse = adapt(informed, logs, None, NoResidual(), Adapting(rounds=1), robot=crane, inform=lambda *_: base)
    assert worse.reports[1].gain.high < 0.0
    assert worse.best == 0


def test_shares_of_errors_know_no_units() -> None:
    errors, of = np.random.default_rng(0).uniform(0.1, 1.0, size=(2, 50, 2))
    np.testing.assert_allclose(in_shares(errors * [1.0, 1e3], of * [1.0, 1e3]), in_shares(errors, of))
    np.testing.assert_allclose(in_shares(errors[:, :1], of[:, :1]) * of[:, 0].mean(), errors[:, 0])
    assert in_shares(of, of).mean() == pytest.approx(1.0)


def test_what_led_astray_twice_does_not_fly_again() -> None:
    worse, base, wild = Improvement(-0.5, -0.8, -0.2), CRAZYFLIE.nominal(), MUSHR.nominal()
    alike = Improvement(0.1, -0.05, 0.2)
    rounds = [round_of(0), round_of(1, gain=worse, tracking=alike), round_of(2, tracking=worse)]
    assert settled(rounds)
    assert not settled([*rounds[:2], round_of(2), round_of(3, gain=worse, tracking=alike)])
    training = Training(NARROW, None, CRAZYFLIE, 0, silent)
    model, how = training.learn(base, [base, wild, wild], rounds, recordings(1))
    assert model is base
    assert "two models in a row" in how.refused
