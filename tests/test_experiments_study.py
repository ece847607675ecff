"""The study: its jobs really adapt, its statistics say what they should, and its command line is clear."""

import json
from dataclasses import replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from cli_results import Refused
from rich.console import Console

from sym2real.cli import main
from sym2real.control import RandomCommands
from sym2real.dataset import Dataset
from sym2real.diagnosis import add
from sym2real.errors import DataError
from sym2real.experiments.learning import from_description, trained_dependence
from sym2real.experiments.models import base_folder, cached_base
from sym2real.experiments.study import effort as efforts, zero_shot
from sym2real.experiments.study.adapting import Adapted
from sym2real.experiments.study.case import Case, load_suite, shipped_suites
from sym2real.experiments.study.catalogue import experiment, experiment_names
from sym2real.experiments.study.contestants import MOST_LOGS, WhenDoubled
from sym2real.experiments.study.curves import Curve, ratio
from sym2real.experiments.study.effort import FULL, QUICK
from sym2real.experiments.study.judged import Reference, has_reference, judge, planning_with, planning_with_mujoco
from sym2real.experiments.study.neural_base import cached_ensemble
from sym2real.experiments.study.noisy_logs import NoisyFit
from sym2real.experiments.study.outcome import Outcome
from sym2real.experiments.study.policy import targets, trained
from sym2real.experiments.study.scratch import FromScratch, trajectories_to_converge
from sym2real.experiments.study.suites import contestants_of, suite_outcome
from sym2real.plants import MujocoPlant, run_episode
from sym2real.report.experiment import outcome_figure, outcome_table
from sym2real.report.style import save
from sym2real.robots import CRAZYFLIE, ROBOTS

BASE = CRAZYFLIE.nominal()  # a learned one takes minutes, and whatever is adapted is adapted alike
SMALL = replace(
    QUICK,
    rows=100,
    evaluations=1,
    rounds=1,
    seeds=(1,),
    samples={"crazyflie": 64, "mushr": 32},
    episodes={"crazyflie": 3},
)


def case(name: str) -> Case:
    return next(one for suite in shipped_suites() for one in load_suite(suite).cases if one.name == name)


def test_a_quick_study_asks_what_is_dear_where_a_case_says_so() -> None:
    suite = load_suite("sim2sim")
    quick, full = ({one.name: contestants_of(one, suite, effort) for one in suite.cases} for effort in (QUICK, FULL))
    assert all("sr-tuned" not in asked for asked in quick.values())
    assert [name for name, asked in quick.items() if "nn-nn" in asked] == ["mass-11", "friction"]
    assert all({"sr-tuned", "nn-nn", "nn-sr"} <= set(asked) for asked in full.values())
    assert "sr-true" in quick["mass-26"]
    assert "sr-true" not in quick["reverse-circle"]


def silent(_: str) -> None:
    pass


def told(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """Words of the command line."""
    main(arguments)
    return " ".join("".join(capsys.readouterr()).split())


@pytest.mark.slow
def test_planning_with_the_target_itself_beats_the_plain_base() -> None:
    """The same episodes, samples and noise; only what the model knows differs."""
    target = case("com-3")
    perfect = judge(target, planning_with_mujoco(SMALL), SMALL)
    base = judge(target, planning_with(BASE, SMALL), SMALL)
    assert perfect.errors[0] < 0.7 * base.errors[0]
    assert perfect.costs[0] < base.costs[0]
    assert perfect.crashes == 0


def test_true_equations_fly_as_the_target_itself_plans() -> None:
    """On the same noise, what is left between the two is the error of the equations' form."""
    target, effort = case("mass-26"), replace(SMALL, rows=40)
    informed = add(BASE, target.effects)
    errors = [
        judge(target, make, effort).errors[0]
        for make in (planning_with(informed, effort), planning_with_mujoco(effort))
    ]
    assert errors[0] == pytest.approx(errors[1], rel=0.05)
    other = judge(target, planning_with(BASE, effort), effort).errors[0]
    assert other != pytest.approx(errors[1], rel=0.1)


def test_the_reference_knows_every_target_of_the_judged_cases() -> None:
    suites = [load_suite(name) for name in ("sim2sim", "uncovered", "delay")]
    assert all(has_reference(one) for suite in suites for one in suite.cases)
    assert not has_reference(case("car-plain"))  # a gain of the speed command is a filter


@pytest.mark.slow
@pytest.mark.parametrize("contestant", ["sr-sr", "nn-nn", "nn-sr"])
def test_the_paper_s_other_pairs_adapt_too(contestant: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    base = BASE.to_json()
    monkeypatch.setattr("sym2real.experiments.study.neural_base.base_folder", lambda _: tmp_path / "base")
    effort = replace(SMALL, rows=60, members=2, widths=(16,), neural_flights=2)
    job, told = Adapted(case("mass-26"), contestant, 1, effort, base), list[str]()
    first, last = job.run(told.append)["rounds"]
    assert any("evaluation episode" in line for line in told) and any("learning" in line for line in told)
    assert last["refused"] or last["errors"] != first["errors"]
    if contestant == "sr-sr":  # it repeats itself
        assert [row["errors"] for row in job.run(silent)["rounds"]] == [first["errors"], last["errors"]]
    assert (tmp_path / "ensemble-crazyflie-2-2x16").exists() == contestant.startswith("nn")


@pytest.mark.slow
def test_an_effect_that_the_logs_name_goes_into_the_base() -> None:
    effort = replace(SMALL, rows=250)
    answer = Adapted(case("mass-26"), "sr-effect", 1, effort, BASE.to_json()).run(silent)
    before, after = answer["rounds"]
    assert before["effects"] == [] and "added_mass" in after["effects"]
    assert after["errors"][0] < 0.6 * before["errors"][0]


def test_a_diagnosis_is_asked_again_when_the_logs_have_doubled() -> None:
    asked: list[int] = []

    def inform(data: Dataset, base: Any) -> Any:
        asked.append(len(data))
        return base

    doubled, log = WhenDoubled(inform), run_episode(MujocoPlant(CRAZYFLIE), RandomCommands(CRAZYFLIE), steps=5)
    for count in range(1, 11):
        doubled(Dataset([log] * count), CRAZYFLIE.nominal())
    assert asked == [1, 2, 4] and asked[-1] == MOST_LOGS


def curve(*means: float, seeds: int = 3, spread: float = 0.0) -> Curve:
    noise = np.random.default_rng(0).standard_normal((seeds, len(means), 5))
    errors = np.array(means)[None, :, None] * np.exp(spread * noise)
    return Curve(errors, errors, np.zeros((seeds, len(means))))


def test_how_soon_a_curve_converges() -> None:
    falling = curve(1.0, 0.5, 0.12, 0.105, 0.1, 0.1, 0.1)
    assert falling.trajectories == 3
    assert falling.final.mean() == pytest.approx(0.1)
    assert curve(0.1, 0.1, 0.1, 0.1).trajectories == 0
    assert trajectories_to_converge(np.array([0.5, 0.11, 0.1, 0.1, 0.1])) == 2


@pytest.mark.slow
def test_bases_that_were_being_kept_when_their_process_ended_are_learned_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("platformdirs.user_cache_dir", lambda _: tmp_path)
    effort = replace(SMALL, members=2, widths=(4,), neural_flights=2)
    first = cached_ensemble(ROBOTS["mushr"], effort)
    (kept,) = tmp_path.glob("*/ensemble-mushr-*-2x4")
    (kept / "model.json").unlink()  # the last of its files
    again = cached_ensemble(ROBOTS["mushr"], effort)
    assert all(torch.equal(value, again.state_dict()[name]) for name, value in first.state_dict().items())

    learned, folder = from_description(ROBOTS["cart_pole"]), base_folder(ROBOTS["cart_pole"])
    (folder / "training.json").mkdir(parents=True)  # so that its second file cannot be written
    with pytest.raises(DataError):
        learned.save(folder)
    (folder / "training.json").rmdir()
    cached_base(ROBOTS["cart_pole"])
    assert trained_dependence(folder)


def test_what_is_asked_for_twice_is_asked_once() -> None:
    """A seed that counted twice made an interval of no width."""
    assert QUICK.of_seeds((2, 1, 2)).seeds == (2, 1)
    assert QUICK.of_seeds(()).seeds == QUICK.seeds
    suite = load_suite("sim2sim").only(["com-1", "com-1"], ["sr-nn", "sr-sr", "sr-nn"])
    assert [case.name for case in suite.cases] == ["com-1"]
    assert suite.contestants == ("sr-nn", "sr-sr")


def test_a_ratio_has_the_interval_of_its_seeds() -> None:
    generator = np.random.default_rng(1)
    covered = 0
    for _ in range(200):
        seeds = np.exp(0.1 * generator.standard_normal((3, 1)))
        found = ratio(0.8 * seeds * np.ones((3, 5)), np.ones(5))
        covered += found.low <= 0.8 <= found.high
    assert 180 <= covered <= 200
    alone = ratio(np.full((1, 5), 0.5), np.full((1, 5), 1.0))
    assert alone.value == pytest.approx(0.5) and alone.undecided(1.0)
    assert ratio(np.full((3, 5), 0.5), np.full((3, 5), 1.0)).high < 1.0


def records(effort: efforts.Effort) -> dict[str, dict[str, Any]]:
    """Answers that a sweep might have kept."""
    suite, found = load_suite("uncovered"), {}
    for one in suite.cases:
        found[Reference.name_of(one)] = {"errors": [0.1] * 5, "costs": [0.2] * 5, "crashes": 0}
        for contestant in suite.contestants:
            for seed in effort.seeds:
                rows = [
                    {"errors": [0.1 + 0.3 / (1 + k)] * 5, "costs": [0.5] * 5, "crashes": k == 4, "crashed": False}
                    for k in range(11)
                ]
                found[f"{one.name}_{contestant}_{seed}"] = {"rounds": rows, "seconds": 1.0}
    return found


def test_a_suite_becomes_a_table_and_a_figure(tmp_path: Path) -> None:
    outcome = suite_outcome(load_suite("uncovered"), QUICK, records(QUICK))
    assert len(outcome.rows) == len(load_suite("uncovered").cases) * len(load_suite("uncovered").contestants)
    assert outcome.rows[0][:4] == ("a payload that swings", "SR*+NN", "0.4000", "0.2500")
    assert outcome.rows[0][outcome.columns.index("crashes")] == "3"
    assert outcome_table(outcome).row_count == len(outcome.rows)
    assert outcome.panels[0].level == pytest.approx(0.2)
    assert any("cannot tell SR*+effect" in note for note in outcome.notes)
    assert save(outcome_figure(outcome), tmp_path, "figure").stat().st_size > 10_000
    part = {name: record for name, record in records(QUICK).items() if name.startswith("windup")}
    assert {row[0] for row in suite_outcome(load_suite("uncovered"), QUICK, part).rows} == {
        "motor controller winds up",
        "",
    }


def test_titles_of_a_file_are_words_and_no_markup() -> None:
    titles = ("payload [kg]", "current [A]", "per metre [/m]")
    console = Console(file=StringIO(), width=80)
    console.print(outcome_table(Outcome("bumps [/m]", ("case", "model"), tuple((title, "SR*+NN") for title in titles))))
    assert all(title in console.file.getvalue() for title in ("bumps [/m]", *titles))


@pytest.mark.slow
def test_from_scratch_every_trajectory_is_judged() -> None:
    errors = np.array(FromScratch("crazyflie", "sr", 1, SMALL).run(silent)["errors"])
    assert errors.shape == (3, 6)
    assert errors[-1].mean() < errors[0].mean()


@pytest.mark.slow
def test_equations_reach_a_goal_that_their_training_never_had(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three hovering flights teach a base that flies to the same goal and to one elsewhere."""
    monkeypatch.setattr(zero_shot, "RUNS", 1)
    monkeypatch.setitem(zero_shot.TRAINING, "crazyflie", ("hover", 3))
    assert zero_shot.ZeroShot("crazyflie", "sr", 1, SMALL).run(silent) == {"seen": 100.0, "unseen": 100.0}


@pytest.mark.slow
def test_noise_costs_dependences() -> None:
    """The same flights, fitted from clean logs and from noisy ones."""
    base = BASE.to_json()
    scores = {}
    for clean in (True, False):
        rows = NoisyFit(case("cf-plain"), clean, 1, replace(SMALL, rows=60), base).run(silent)["dependence"]
        scores[clean] = {(row["state"], row["action"], row["meaning"]): row["score"] for row in rows}
    assert scores[True].keys() == scores[False].keys()
    assert scores[True] != scores[False]


@pytest.mark.slow
def test_a_policy_learns_in_the_plain_simulator() -> None:
    pytest.importorskip("stable_baselines3", reason="needs the extra `rl`")
    plain = targets()[0]
    policy = trained(plain.of_task(), 2048, 1, silent)
    action = policy.act(CRAZYFLIE.start, 0)
    assert action.shape == (4,)
    assert (action >= CRAZYFLIE.low).all() and (action <= CRAZYFLIE.high).all()
    np.testing.assert_array_equal(action, policy.act(CRAZYFLIE.start, 7))
    assert len(judge(plain, lambda *_: policy, SMALL).errors) == 1


def test_every_experiment_has_jobs_of_different_names() -> None:
    for name in experiment_names():
        names = [job.name for job in experiment(name).jobs(QUICK)]
        assert len(set(names)) == len(names), name
        assert names or name == "policy"


MINE = """\
title = "mine"
contestants = ["sr-effect"]
[[case]]
name = "heavy"
title = "heavy"
robot = "crazyflie"
task = "circle"
effects = [{ effect = "added_mass", value = 0.007 }]
"""


@pytest.mark.slow
def test_the_command_line_runs_cases_of_ones_own(
    tmp_path: Path, refused: Refused, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(efforts, "QUICK", SMALL)
    file, out = tmp_path / "mine.toml", tmp_path / "out"
    file.write_text(MINE)
    arguments = ["experiment", str(file), "--out", str(out), "--jobs", "1", "--contestants", "sr-nn"]
    said = told(arguments, capsys)
    assert "SR*+NN" in said and "2/2 heavy_sr-nn_1" in said
    assert sorted(path.name for path in out.iterdir()) == ["answers", "figure.png", "outcome.json", "running"]
    assert "2 of 2 were answered before" in told(arguments, capsys)
    zero_shot, learned = json.loads((out / "answers" / "heavy_sr-nn_1.json").read_text())["rounds"]
    assert np.mean(learned["errors"]) < 0.8 * np.mean(zero_shot["errors"])
    rows = json.loads((out / "outcome.json").read_text())["rows"]
    assert [row["model"] for row in rows] == ["SR*+NN"]
    assert "another setting" in refused([*arguments, "--full"])


def test_the_command_line_lists_and_refuses(refused: Refused, capsys: pytest.CaptureFixture[str]) -> None:
    said = told(["experiment", "list"], capsys)
    assert all(name in said for name in (*experiment_names(), "sr-effect-nn"))
    refusals = {
        "sim2sim": "expected --out FOLDER",
        "sim2simm --out x": "did you mean 'sim2sim'",
        "sim2sim --out x --cases mass-12": "unknown case 'mass-12'",
        "sim2sim --out x --contestants sr-mm": "unknown contestant 'sr-mm'",
        "scratch --out x --cases mass-11": "scratch has no cases",
    }
    for arguments, expected in refusals.items():
        assert expected in refused(f"experiment {arguments}")
    assert not Path("x").exists()
