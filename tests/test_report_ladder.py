"""The ladder on a terminal of 80 columns: four channels, long intervals, nothing cut off."""

import io
import re

import numpy as np
import pytest
from rich.console import Console
from rich.measure import Measurement

from sym2real.control import RandomCommands
from sym2real.diagnosis import Floor, compare
from sym2real.diagnosis.errors.rungs import Rung, RungError
from sym2real.effects import EFFECTS
from sym2real.experiments.standard_conditions import sensors
from sym2real.plants import MujocoPlant, run_episode
from sym2real.report.comparison import comparison_report
from sym2real.report.ladder import ladder_table
from sym2real.robots import ROBOTS

CHANNELS = {"position": "m", "attitude": "rad", "velocity": "m/s", "rate": "rad/s"}
JOINTS = {"joint displacement": "m", "joint angle": "rad", "joint speed": "m/s", "joint rate": "rad/s"}
HORIZONS = (0.1, 0.2, 0.5, 0.8, 1.0, 2.0)


def stage(name: str, error: float, channels: dict[str, str] = CHANNELS) -> Rung:
    errors = {
        channel: RungError(error, 0.9 * error, 0.92 * error, 1.08 * error, unit) for channel, unit in channels.items()
    }
    return Rung(name, dict.fromkeys(HORIZONS, errors))


def floor(channels: dict[str, str] = CHANNELS) -> list[Floor]:
    return [Floor(horizon, {channel: (1.23e-5, unit) for channel, unit in channels.items()}) for horizon in HORIZONS]


FLOOR = floor()


@pytest.mark.parametrize(("apart", "said"), [(True, "kept aside"), (False, "each left out once")])
def test_the_title_says_whether_logs_were_kept_aside(apart: bool, said: str) -> None:
    table = ladder_table([stage("base", 1.0)], FLOOR, [f"trial_{i}" for i in range(19)], apart=apart)
    assert str(table.title).endswith(f"19 logs, {said}")


def test_a_dash_has_a_reason() -> None:
    table = ladder_table([stage("base", 1.0), stage("+ delay", float("nan")), stage("+ lag", 2.0)], FLOOR, ["trial"])
    assert "predictions there are no numbers" in str(table.caption)
    assert ladder_table([stage("base", 1.0)], FLOOR, ["trial"]).caption is None


@pytest.mark.parametrize("channels", [CHANNELS, JOINTS], ids=["body", "joints"])
@pytest.mark.parametrize("error", [1.234, 0.01234, 0.0001234])
def test_four_channels_fit_80_columns(error: float, channels: dict[str, str]) -> None:
    console = Console(width=200, file=io.StringIO())
    stages = [stage("base", 12.34, channels), stage("+ mounting_tilt", error, channels)]
    table = ladder_table(stages, floor(channels), ["trial_2"])
    assert Measurement.get(console, console.options, table).maximum <= 80


def test_the_two_floors_have_names_of_their_own() -> None:
    """A comparison's is the sensors' noise, a ladder's has the disturbances too."""
    console = Console(width=80, file=io.StringIO())
    robot = ROBOTS["mushr"]
    noise = sensors(robot, np.random.default_rng(0))
    drive = run_episode(MujocoPlant(robot, [noise]), RandomCommands(robot), steps=100)
    comparison = compare(robot.nominal(), drive)
    shown = []
    for report in (comparison_report(comparison), ladder_table([stage("base", 12.34)], FLOOR, ["trial_2"])):
        with console.capture() as said:
            console.print(report)
        shown.append(" ".join(said.get().split()))
    assert "sensors' noise alone" in shown[0]
    assert "disturbances" not in shown[0]
    assert re.search(r"noise and 1\.2e-05.* disturbances$", shown[1])
    assert not any("noise floor" in text for text in shown)


def test_the_longest_name_is_folded_and_no_figure_is_cut_off() -> None:
    console = Console(width=80, file=io.StringIO())
    name = f"+ {max(EFFECTS, key=len)}:speed"
    console.print(ladder_table([stage("base", 12.34), stage(name, 0.0001234)], FLOOR, ["trial_2"]))
    assert isinstance(console.file, io.StringIO)
    shown = console.file.getvalue()
    assert "…" not in shown.replace("0.00011…0.00013", "").replace("11…13", "")
    assert shown.count("0.000123") == len(CHANNELS)


@pytest.mark.parametrize(("errors", "said"), [((0.9, 0.5, 0.2), False), ((0.9, 1.2, 0.2), True)])
def test_a_ladder_that_leads_up_says_why(errors: tuple[float, ...], said: bool) -> None:
    console = Console(width=80, file=io.StringIO())
    stages = [stage(name, error) for name, error in zip(("base", "+ gain:steer", "+ lever_arm"), errors, strict=True)]
    with console.capture() as shown:
        console.print(ladder_table(stages, FLOOR, ["trial_2"]))
    assert ("helps only together with one below it" in " ".join(shown.get().split())) == said


def test_the_ladder_ends_with_the_noise_alone_where_that_is_known() -> None:
    known = [Floor(at.horizon, at.errors, dict.fromkeys(at.errors, 1e-6)) for at in FLOOR]
    console = Console(width=80, file=io.StringIO())
    console.print(ladder_table([stage("base", 1.0)], known, ["trial"]))
    lines = [line for line in console.file.getvalue().splitlines() if line.strip()]
    assert lines[-1].split()[:3] == ["noise", "alone", "1e-06"]
