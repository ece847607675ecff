"""Damaged texts: specifications, equations, plant files, descriptions, records of a training; and folders of them."""

import hashlib
import json
import os
import re
import shutil
from pathlib import Path
from random import Random
from typing import Any

from hostile_case import Case, kind, reading
from safetensors.torch import load_file, save_file

DEEP = "[" * 3000 + "]" * 3000
VALUES = (None, True, [], {}, "", "nothing known", -1, 0, 10**400, 1e999, float("nan"), [[[[]]]], "1e5", ["x"] * 3)
BROKEN = ("", "{", "[", "null", "[]", '"text"', DEEP, '{"a": ' * 3000, "9" * 5000, "\ufeff{}", "= 3", "\x00")
PARTS = ("equations.json", "parameters.safetensors")


def _leaves(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Paths to everything in a JSON or TOML value."""
    inside = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(leaf for key, one in inside for leaf in _leaves(one, (*path, key)))]


def _kind(value: Any) -> type:
    """Another number may be as good."""
    return float if isinstance(value, int | float) and not isinstance(value, bool) else type(value)


def _changed(value: Any, random: Random) -> Any:
    """The value with something else at a random place in it."""
    *above, last = random.choice(_leaves(value)[1:])
    inner = value
    for key in above:
        inner = inner[key]
    if random.random() < 0.3:
        inner.pop(last)
    else:
        inner[last] = random.choice([one for one in VALUES if _kind(one) is not _kind(inner[last])])
    return value


@kind("TOML: a specification that is damaged")
def specification(folder: Path, random: Random) -> Case:
    file = folder / "foreign.toml"
    text = file.read_text()
    lines = text.splitlines()
    line = random.choice([i for i, one in enumerate(lines) if "=" in one])
    key = lines[line].partition("=")[0].strip()
    literals = (
        *("[]", "{}", "1e400", "nan", "-1", "true", '"no_such"', "9" * 400),
        *(DEEP, "''", '"log_x"', "1979-05-27", '"\\q"'),
    )
    how = random.randrange(6)
    if how == 0:
        text = text[: random.randrange(len(text))]
    elif how == 1:
        text = random.choice(BROKEN)
    elif how == 2:
        lines[line] = f"{key}x = 1"
    elif how == 3:
        lines.insert(line, lines[line])
    else:
        lines[line] = f"{key} = {random.choice(literals)}"
    file.write_text(text if how < 2 else "\n".join(lines))
    if how == 0 and random.random() < 0.3:
        file.write_bytes(file.read_bytes() + b"\xff")
    # What a specification that ends early does not say is missing in its log.
    where = (
        r"line \d|at end of|position \d|column|key|TOML"
        if how < 2
        else rf"\b{key}|line {line + 1}|line {line + 2}|end of document|nested too deeply"
    )
    return reading("foreign.toml", r"foreign\.(toml|csv)", where, renamed=how > 3 and key == "name")


@kind("model: a file cut, changed, emptied, gone or no file")
def model_file(folder: Path, random: Random) -> Case:
    part = random.choice(PARTS)
    _hurt(folder / "model" / part, random)
    return reading("model", re.escape(part) if (folder / "model").exists() else "model")


@kind("model: equations that say something else")
def equations(folder: Path, random: Random) -> Case:
    file, weights = (folder / "model" / name for name in PARTS)
    file.write_text(json.dumps(_changed(json.loads(file.read_text()), random)))
    if random.random() < 0.6:  # as someone would who wants to be read
        digest = hashlib.sha256(file.read_bytes()).hexdigest()
        save_file(load_file(weights), weights, {"equations": digest})
    return reading("model", r"model/(equations\.json|parameters\.safetensors)")


@kind("model: what it was learned from")
def training(folder: Path, random: Random) -> Case:
    whole = {"dependence": [{"action": "thrust", "state": "vz", "effect": 1.0, "holds": True}], "region": {"x": [0, 1]}}
    text = random.choice((*BROKEN, json.dumps(_changed(whole, random)), json.dumps(_changed(whole, random))))
    (folder / "model" / "training.json").write_text(text)
    return reading("model", r"model/training\.json")


@kind("plant: a file cut, changed, emptied, gone or no file")
def plant_file(folder: Path, random: Random) -> Case:
    part = random.choice(("robot.xml", "plant.toml"))
    _hurt(folder / "plant" / part, random)
    return reading("plant", re.escape(part) if (folder / "plant").exists() else "plant")


@kind("plant: a value that no robot has")
def plant_value(folder: Path, random: Random) -> Case:
    file = folder / "plant" / "plant.toml"
    values = ("1e9", "nan", "inf", "-1e300", '"text"', "[]", "true", "9" * 400, DEEP, "1e400")
    text, named = (
        re.sub(r"(?m)^fx = .*$", f"fx = {random.choice(values)}", file.read_text()),
        r"wind|plant\.toml: .*found",
    )
    if random.random() < 0.4:
        effect, value = random.choice(
            (("delay", 1e9), ("lag", -1), ("wind", "nan"), ("no_such", 1), ("added_mass", -9))
        )
        text, named = f'{file.read_text()}\n[[effects]]\neffect = "{effect}"\nvalue = {value}\n', effect
    file.write_text(text)
    return reading("plant", "plant", named)


@kind("diagnosis: an earlier one in the folder")
def diagnosis(folder: Path, random: Random) -> Case:
    """A log that is refused leaves the earlier diagnosis as it was, whatever that says."""
    files = random.choice((["ladder.png", "../flight.csv"], 3, [None, {}], "x" * 999, ["."], ["/etc/passwd", "\0"]))
    text = random.choice((*BROKEN, json.dumps({"files": files}), json.dumps({"files": files})))
    (folder / "diagnosis" / "diagnosis.json").write_text(text)
    (folder / "flight.csv").write_text((folder / "flight.csv").read_text() + "1,2\n")
    return Case(("diagnose", "model", "flight.csv", "--out", "diagnosis"), (r"flight\.csv, row 102: .*found 2 values",))


def _hurt(file: Path, random: Random) -> None:
    content = file.read_bytes()
    how = random.choice(("cut", "changed", "empty", "gone", "folder", "pipe", "link", "broken", "binary"))
    if how == "cut":
        file.write_bytes(content[: random.randrange(len(content))])
    elif how == "changed":
        place = random.randrange(len(content))
        file.write_bytes(content[:place] + bytes([content[place] ^ 0x80]) + content[place + 1 :])
    elif how in {"empty", "broken", "binary"}:
        file.write_bytes({"empty": b"", "broken": random.choice(BROKEN).encode()}.get(how, random.randbytes(500)))
    else:
        file.unlink()
        if how == "folder":
            file.mkdir()
        elif how == "pipe":
            os.mkfifo(file)
        elif how == "link":
            file.symlink_to(file.name)
    if how == "gone" and random.random() < 0.3:
        shutil.rmtree(file.parent)
