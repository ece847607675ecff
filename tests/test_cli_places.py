"""No verb writes over what it was given to read; the verbs are walked, so that a new one is tested too."""

import os
import shutil
from collections.abc import Iterator
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, get_args, get_type_hints

import pytest
from cli_results import Refused

from sym2real.cli import VERBS
from sym2real.cli.places import WRITTEN, kept_apart, places_read
from sym2real.cli.results import remove_earlier
from sym2real.data import example_flight
from sym2real.errors import Sym2RealError
from sym2real.files import reading, whole, write_text
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic import save_model

# Options that are texts and never name a place. A new option must go here or be a Place.
NO_PLACES = {
    *("actions", "cases", "cluster", "columns", "contestants", "effects", "engine", "exclude"),
    *("memory", "name", "numbers", "options", "robot", "state", "task"),
}
VERB_CLASSES = [one for kind in VERBS.values() for one in (get_args(kind) if get_args(kind) else (kind,))]
VERB_CLASSES = [get_args(one)[0] if hasattr(one, "__metadata__") else one for one in VERB_CLASSES]


def mentions(hint: Any, kind: type) -> bool:
    return hint is kind or any(mentions(one, kind) for one in get_args(hint) if not isinstance(one, str))


def made(kind: Any, **given: Any) -> Any:
    """A verb with these fields; those it must have besides get a value of their type."""
    hints = get_type_hints(kind)
    for field in fields(kind):
        if field.name not in given and field.default is MISSING:
            hint = hints[field.name]
            name = "nothing_of_that_name"
            simple = {Path: Path(name), str: name, float: 1.0}
            given[field.name] = simple.get(hint, () if "tuple" in str(hint) else name)
    return kind(**given)


def reading_fields() -> Iterator[tuple[Any, str]]:
    for kind in VERB_CLASSES:
        for name in places_read(made(kind)):
            yield kind, name


def is_file(kind: Any, option: str) -> bool:
    return option in ("json", "report") or getattr(kind, "OUT_IS_FILE", False)


def valued(kind: Any, name: str, path: Path) -> Any:
    hint = get_type_hints(kind)[name]
    value = path if mentions(hint, Path) else str(path)
    return (value,) if "tuple" in str(hint) else value


CASES = [
    (kind, name, option)
    for kind, name in reading_fields()
    for option in WRITTEN
    if option in {field.name for field in fields(kind)}
]


def test_every_verb_that_takes_a_path_is_walked() -> None:
    walked = {kind for kind, _, _ in CASES}
    assert {kind.__name__ for kind in set(VERB_CLASSES) - walked} == set()
    assert len(CASES) >= 35


@pytest.mark.parametrize("kind", VERB_CLASSES, ids=lambda kind: kind.__name__)
def test_every_text_is_known_to_name_a_place_or_not(kind: Any) -> None:
    reads = places_read(made(kind))
    for field in fields(kind):
        if mentions(get_type_hints(kind)[field.name], str) and field.name not in reads:
            assert field.name in NO_PLACES, f"{kind.__name__}.{field.name}: a Place, or never one?"


LINKED = [
    (kind, name, option, how)
    for kind, name, option in CASES
    for how in ("itself", "through a folder", "symbolic link", "hard link")
    if how != "hard link" or is_file(kind, option)  # folders have none
]


@pytest.mark.parametrize(
    ("kind", "name", "option", "how"), LINKED, ids=["-".join((kind.__name__, *rest)) for kind, *rest in LINKED]
)
def test_a_place_that_is_read_is_refused(kind: Any, name: str, option: str, how: str, tmp_path: Path) -> None:
    given = tmp_path / "given"
    if is_file(kind, option):
        given.write_text("measured once")
    else:
        given.mkdir()
    out = {"itself": given, "through a folder": tmp_path / "folder" / ".." / "given"}.get(how, tmp_path / "other")
    (tmp_path / "folder").mkdir()
    if how == "symbolic link":
        out.symlink_to(given)
    elif how == "hard link":
        os.link(given, out)
    verb = made(kind, **{name: valued(kind, name, given), option: out})
    with pytest.raises(Sym2RealError, match="which would be lost"), kept_apart(verb):
        pass
    # The other way round: what is read is a link to what is written.
    verb = made(kind, **{name: valued(kind, name, out), option: given})
    with pytest.raises(Sym2RealError, match="which would be lost"), kept_apart(verb):
        pass


@pytest.mark.parametrize("kind", [kind for kind in VERB_CLASSES if getattr(kind, "FOLDERS", ())])
def test_a_folder_inside_out_that_is_read_is_refused(kind: Any, tmp_path: Path) -> None:
    reads = next(name for name in places_read(made(kind)))
    for inside in kind.FOLDERS:
        (tmp_path / inside).mkdir()
        verb = made(kind, **{reads: valued(kind, reads, tmp_path / inside), "out": tmp_path})
        with pytest.raises(Sym2RealError, match="which would be lost"), kept_apart(verb):
            pass


def test_while_a_file_is_read_nothing_is_written_over_it(tmp_path: Path) -> None:
    """The net under the options: a name that a verb itself chose, in a folder that holds what it reads."""
    (tmp_path / "logs").mkdir()
    log = tmp_path / "logs" / "circle.csv"
    log.write_text("measured once")
    for number, places in enumerate(([log], [tmp_path / "logs"])):
        with reading({"logs": places}), pytest.raises(Sym2RealError, match="which would be lost"), whole(log) as beside:
            beside.write_text("lost")
        assert log.read_text() == "measured once"
        with reading({"logs": places}):
            write_text(tmp_path / "logs" / f"new{number}.csv", "new")
    write_text(log, "nobody reads it any more")


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("measured")
    save_model(CRAZYFLIE.nominal(), folder / "model")
    shutil.copy(example_flight(), folder / "flight.csv")
    return folder


@pytest.mark.parametrize(
    "command",
    [
        "inspect flight.csv --out flight.csv",
        "inspect flight.csv --json flight.csv",
        "inspect . --out flight.csv",
        "export model python --out flight.csv",
        "export model latex --out model/equations.json",
        "show model --json flight.csv",
        "show model --json model/parameters.safetensors",
        "compare model flight.csv --spec crazyflie_battery_drag --report model/equations.json",
        "add model wind fx=0.1 --out model",
        "add model wind fx=0.1 --out new --json new/equations.json",
        "export model python --out same --json same",
        "simulate crazyflie hover --out model",
    ],
)
def test_the_command_line_keeps_what_it_is_given(
    command: str, measured: Path, refused: Refused, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(measured)
    before = {file: file.read_bytes() for file in Path().rglob("*") if file.is_file()}
    refused(command)
    assert {file: file.read_bytes() for file in Path().rglob("*") if file.is_file()} == before


def test_an_earlier_diagnosis_cannot_name_what_is_read_for_removal(tmp_path: Path) -> None:
    log = tmp_path / "flight.csv"
    log.write_text("measured once")
    (tmp_path / "old.png").write_text("")
    (tmp_path / "diagnosis.json").write_text('{"files": ["flight.csv", "old.png"]}')
    with reading({"logs": [log]}):
        remove_earlier(tmp_path)
    assert {file.name for file in tmp_path.iterdir()} == {"flight.csv", "diagnosis.json"}


@pytest.mark.parametrize("verb", ["nominal car --wheelbase 0.3", "add mushr wind fx=0.1"])
def test_a_new_model_takes_no_folder_that_holds_something(verb: str, refused: Refused, tmp_path: Path) -> None:
    """Another model, or a folder of other things, as the one that a user stands in."""
    save_model(CRAZYFLIE.nominal(), tmp_path / "other")
    before = (tmp_path / "other" / "equations.json").read_bytes()
    for place in (tmp_path / "other", tmp_path):
        refused(f"{verb} --out {place}")
    assert (tmp_path / "other" / "equations.json").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["other"]
