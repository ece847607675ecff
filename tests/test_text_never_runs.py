"""Text that came from a file never runs, and leads to no other file: a payload in every key and value that is read.

The places are found by walking files that the package itself has written, so that a new field is tested without being
listed here. Whether a payload ran shows in the working folder: all of them leave ``RAN`` there.
"""

from __future__ import annotations

import io
import json
import shutil
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import cache
from pathlib import Path

import file_strings
import numpy as np
import pytest
import two_links
from rich.console import Console

from sym2real.adaptation.episode_report import EpisodeReport
from sym2real.adaptation.record import Record
from sym2real.cli import main
from sym2real.cli.results import remove_earlier, write_diagnosis
from sym2real.dataset import Dataset
from sym2real.diagnosis import Diagnosis, add_term
from sym2real.effects import noted
from sym2real.errors import ModelError, Sym2RealError
from sym2real.experiments.learning import Learned, trained_dependence
from sym2real.experiments.models import open_model
from sym2real.field import Field
from sym2real.layout import Layout, Layouts
from sym2real.logs import LogSpec, inspect_logs, read_logs, write_log
from sym2real.neural import Composed, Ensemble, ResidualMLP
from sym2real.neural.model_folder import open_model as open_whole, save_model as save_whole
from sym2real.neural.symbolic_residual import SymbolicResidual
from sym2real.plants import load_plant, save_plant
from sym2real.regression import Dependence
from sym2real.report.tables import dependence_table, equation_table
from sym2real.robots import MUSHR, Robot
from sym2real.robots.own import origin_of, robot_of
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.c_rollout import rollout_text
from sym2real.symbolic.c_source import CLines
from sym2real.symbolic.compile import class_from_source
from sym2real.symbolic.exporting import latex_document
from sym2real.symbolic.program import Instruction, Program
from sym2real.symbolic.source import function_source, model_source
from sym2real.symbolic.storage import training_region
from sym2real.trajectory import Trajectory

RUN = 'open("RAN", "w").close()'
PAYLOADS = {
    "a docstring's end": f'x"""\n{RUN}\n"""',
    "a string's end": f'", {RUN}, "',
    "a quote": f"', {RUN.replace(chr(34), chr(39))}, '",
    "a line": f"x\n{RUN}\n",
    "an expression": '__import__("os").system("touch RAN")',
    "a format": "{0.__class__.__init__.__globals__} ${values} $title %(x)s {",
    "a comment's end": '*/ __attribute__((constructor)) static void run(void) { system("touch RAN"); } /*',
    "an include": '\n#include "RAN"\n',
    "a shell": "$(touch RAN)`touch RAN`;touch RAN|touch RAN",
    "markup": "[link=RAN]x[/] [/bold]",
    "mathtext": "$\\RAN{$",
    "a place": "../../RAN",
    "an absolute place": "/tmp/RAN-by-a-test-of-sym2real",
}
payload_of_each_kind = pytest.mark.parametrize("payload", PAYLOADS.values(), ids=PAYLOADS)
FEW = 40
VISIBLE = ("x", "y", "sin_yaw", "cos_yaw", "vx", "vy")
SETTINGS = {"engine": "beam", "episodes": 3}
CONSOLE = Console(file=io.StringIO(), width=200)


@cache
def equations_with_everything() -> Equations:
    """Nothing that a file of equations can hold is empty."""
    hidden = Field("lagged", ("lagged",), "m/s", "world", hidden=True)
    layouts = Layouts(Layout.of(VISIBLE) + Layout((hidden,)), Layout.of(("steer", "speed")))
    layouts = replace(layouts, inputs=Layout.of(("fx", "vbat")))
    return Equations.parse(
        layouts,
        {
            "x": "x + 0.1*vx",
            "y": "y + 0.1*vy",
            "vx": "vx + fx",
            "vy": "vy + k*push",
            "sin_yaw": "sin_yaw",
            "cos_yaw": "cos_yaw",
            "lagged": "vx*steer*vbat",
        },
        0.1,
        output={"x": "x + 0.01"},
        quantities={"push": "speed*lagged"},
        parameters={"k": 2.0},
        robot="buggy",
        notes=("a note",),
        numbers={"mass": 3.0},
        filters=[("lag:steer", {"value": "0.1"})],
        start={"lagged": "vx"},
        effects=[("lag:steer", {"value": 0.1})],
        origin=origin_of(own_robot()),
    )


def own_robot() -> Robot:
    """One that no registry knows."""
    return Robot.from_mjcf(two_links.MJCF, name="links", title="Two links", numbers={"reach": 0.75})


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Files of every format, written by the package."""
    folder = tmp_path_factory.mktemp("written")
    equations = equations_with_everything()
    report = EpisodeReport(0, "circle", 10, 0, 0.1, 0.1, 0.1, 1.0)
    learned = Learned(equations, (Dependence("x", "speed", 1.0, 0.1, True),), {"x": (0.0, 1.0)}, (report,))
    learned.save(folder / "model")
    visible = Layouts(Layout.of(VISIBLE), equations.layouts.action, equations.layouts.inputs)
    ensemble = Ensemble(visible, 2, (4,), dt=0.1, robot="buggy")
    save_whole(Composed(equations, ResidualMLP(visible, (4,))), folder / "network")
    save_whole(Composed(ensemble, SymbolicResidual(visible, {"vx": 0.1 * symbol("speed")})), folder / "expressions")
    save_plant(MUSHR, [("slope", {"gx": 0.1}), ("lag:steer", {"value": 0.1})], folder / "plant")
    save_plant(own_robot(), [("load:hand", {"value": 0.1})], folder / "own")
    log = drive()
    (folder / "logs").mkdir()
    write_log(log, folder / "logs" / "log.parquet")
    write_log(log, folder / "logs" / "log.csv")
    (folder / "logs" / "spec.toml").write_text(inspect_logs([folder / "logs" / "log.csv"]).toml())
    Record(folder / "run", MUSHR.layouts).claim(SETTINGS)
    write_diagnosis(
        MUSHR.nominal(), Dataset([log]), Diagnosis("NOTHING_MISSING", "Nothing."), folder / "found", CONSOLE
    )
    return folder


def drive() -> Trajectory:
    time, rng = 0.05 * np.arange(60), np.random.default_rng(0)
    state = 0.1 * rng.standard_normal((60, 7)).cumsum(axis=0)
    state[:, 2:4] = np.stack([np.sin(time), np.cos(time)], axis=1)
    action = rng.uniform(0.0, 0.3, (60, 2))
    extra = {"ref_x": state[:, 0], "ref_y": state[:, 1]}
    return Trajectory(
        time, state, action, np.zeros((60, 3)), MUSHR.layouts, extra=extra, name="drive", notes=("a note",)
    )


@cache
def run_generated(text: str) -> None:
    """Generated Python, executed; the same text need not run twice."""
    class_from_source(text, "Dynamics")()


def use_model(folder: Path) -> None:
    plain = equations_with_everything()
    equations = open_model(str(folder))
    run_generated(model_source(equations))
    if set(equations.names) == set(plain.names):
        assert rollout_text(equations, single=True) == rollout_text(plain, single=True) or equations.dt != plain.dt
    CONSOLE.print(equation_table(equations), *noted(equations), markup=False)
    latex_document(equations)
    equations.text()
    robot_of(equations)
    assert Equations.from_json(equations.to_json()).text() == equations.text()


def use_training(folder: Path) -> None:
    training_region(folder)
    CONSOLE.print(dependence_table(trained_dependence(folder)))


def use_plant(folder: Path) -> None:
    plant = load_plant(folder)
    plant.step(plant.robot.rest)


def use_specification(folder: Path) -> None:
    spec = LogSpec.load(folder / "spec.toml")
    assert LogSpec.parse(spec.toml()) == spec
    read_logs(folder / "log.csv", spec=spec)


def use_log(file: Path) -> None:
    (log,) = read_logs(file)
    write_log(log, file.parent / "again.parquet")
    read_logs(file.parent / "again.parquet")


def use_columns(file: Path) -> None:
    use_log(file)
    assert LogSpec.parse(inspect_logs([file]).toml()).columns


USES: dict[str, Callable[[Path], object]] = {
    "model/equations.json": use_model,
    "model/parameters.safetensors": use_model,
    "model/training.json": use_training,
    "network/model.json": open_whole,
    "network/residual.safetensors": open_whole,
    **{f"expressions/{name}": open_whole for name in ("model.json", "ensemble.safetensors", "residual.json")},
    "plant/plant.toml": use_plant,
    "plant/robot.xml": use_plant,
    **{f"own/{name}": use_plant for name in ("plant.toml", "robot.xml", "origin.json")},
    "logs/spec.toml": use_specification,
    "logs/log.parquet": lambda folder: use_log(folder / "log.parquet"),
    "logs/log.csv": lambda folder: use_columns(folder / "log.csv"),
    "run/settings.json": lambda folder: Record(folder, MUSHR.layouts).claim(SETTINGS),
    "found/diagnosis.json": remove_earlier,
}
NOT_READ = (".png", ".pt", ".html")  # figures; a TorchScript archive is for others; pages are for browsers


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A working folder, two folders deep, in which and around which nothing may appear."""
    place = tmp_path / "outside" / "inside"
    place.mkdir(parents=True)
    monkeypatch.chdir(place)
    yield place
    stray = [file for file in tmp_path.rglob("*") if file.name.startswith(("RAN", "_RAN")) and file.is_file()]
    assert not stray
    assert not Path(PAYLOADS["an absolute place"]).exists()


def test_every_file_that_the_package_writes_is_walked(written: Path) -> None:
    found = {file.name for file in written.rglob("*") if file.is_file() and file.suffix not in NOT_READ}
    assert found == {Path(name).name for name in USES}
    equations = json.loads((written / "model" / "equations.json").read_text())
    assert not [key for key, value in equations.items() if not value]  # what is empty has no place for a text
    assert all(equations["layouts"].values())


@pytest.mark.parametrize("share", [4, pytest.param(1, marks=pytest.mark.slow)], ids=["a quarter", "all"])
@pytest.mark.parametrize("name", USES)
@payload_of_each_kind
def test_no_text_of_a_file_runs(name: str, payload: str, share: int, written: Path, here: Path) -> None:
    """Every place of the file: read, used in all ways that this format has, or refused."""
    folder = here / "copy"
    shutil.copytree(written / Path(name).parent, folder, ignore=shutil.ignore_patterns("*.png"))
    file, use = folder / Path(name).name, USES[name]
    original, content = file.read_bytes(), file_strings.read(file)
    use(folder)
    changed = 0
    for place in chosen(content, payload, share):
        file.write_bytes(original)
        try:
            file_strings.write(file, file_strings.replaced(content, place, payload))
            changed += 1
        except (TypeError, KeyError, ValueError, AttributeError):  # no file of that format can hold it
            continue
        with suppress(Sym2RealError):
            use(folder)
        assert not (here / "RAN").exists(), place
    assert changed


def chosen(content: object, payload: str, share: int) -> Iterator[file_strings.Place]:
    """Texts and keys with a share of the payloads, with all where they are few; numbers, read alike, with one each."""
    kind, places = list(PAYLOADS.values()).index(payload), list(file_strings.places(content))
    for index, (place, value) in enumerate(places):
        every = len(PAYLOADS) if file_strings.is_number(value) else 1 if len(places) < FEW else share
        if (index - kind) % every == 0:
            yield place


@payload_of_each_kind
def test_no_name_of_a_file_runs(payload: str, written: Path, here: Path) -> None:
    """Models, logs, specifications, plants and results go by any name that a file can have."""
    name = payload.strip().replace("/", "∕")[-80:]
    shutil.copytree(written / "plant", here / name)
    shutil.copytree(written / "model", here / "models" / name)
    shutil.copy(written / "logs" / "log.csv", here / f"{name}.csv")
    verbs = [
        ["show", str(here / "models" / name)],
        ["inspect", str(here / f"{name}.csv"), "--out", str(here / f"{name}.toml")],
        ["simulate", str(here / name), "circle", "--seconds", "0.2", "--out", str(here / f"again {name}.csv")],
        ["export", str(here / "models" / name), "python", "--out", str(here / f"{name}.py")],
    ]
    for verb in verbs:
        main(verb)
    class_from_source((here / f"{name}.py").read_text(), "Dynamics")()


def test_a_place_is_no_markup(written: Path, here: Path) -> None:
    """A slash inside brackets ends a style, of which there is none."""
    main(["export", str(written / "model"), "python", "--out", "a[/b]c.py"])
    assert (here / "a[" / "b]c.py").exists()


@payload_of_each_kind
def test_no_term_runs(payload: str) -> None:
    equations = MUSHR.nominal()
    for channel, expression in ((payload, "x"), ("fx", payload), ("fx", f"sin({payload})"), ("fx", f"x*{payload}")):
        with pytest.raises(Sym2RealError):
            add_term(equations, channel, expression)


@pytest.mark.parametrize(
    "name", ["../../RAN", *(PAYLOADS[kind] for kind in ("mathtext", "markup", "a docstring's end"))]
)
def test_a_logs_name_in_a_figure_is_text(name: str, here: Path) -> None:
    from sym2real.report.charts import Chart, Line
    from sym2real.report.figures import charts_figure, path_figure
    from sym2real.report.style import save

    write_log(replace(drive(), name=name), here / "log.parquet")
    (log,) = read_logs(here / "log.parquet", layouts=MUSHR.layouts)
    chart = Chart("x", "", "time in s", "x in m", log.time, [Line("measured", "measured", log.column("x"))], "time")
    charts = charts_figure([chart], f"{log.name}: measured")
    assert charts.get_suptitle() == f"{name}: measured"
    for figure in (charts, path_figure(log)):  # drawn without reading a formula in it
        save(figure, here / "figures", "figure")


@payload_of_each_kind
def test_generators_refuse_what_is_no_name(payload: str) -> None:
    """Behind the readers: whoever makes such names in another way gets no text either."""
    with pytest.raises(ModelError, match="name"):
        function_source([symbol("x")], [("x", payload)])
    with pytest.raises(Sym2RealError):
        Layout.of([payload])
    program = Program((payload, "x"), (), (Instruction("add", (0, 1)),), (2,))
    assert payload not in "\n".join(CLines(program, single=True).lines({2}))
