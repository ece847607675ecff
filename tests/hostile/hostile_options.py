"""Options that mean nothing, places where nothing can be, names that no program expects, streams that show little."""

import os
import re
from pathlib import Path
from random import Random

from hostile_case import KINDS, Case, kind, reading
from hostile_world import READERS

NUMBERS = ("nan", "inf", "-inf", "1e999", "abc", "", "-1", "0", "9" * 400, "1_0_", "0x", "None", "é", "--", "1,5")
NAMES = (
    *("", "no such", "x" * 300, "../../..", "\N{SNOWMAN}", "a\nb", "[bold]"),
    *("%s", "wind:", ":", "-", "nan", "\udcff"),
)


@kind("options: numbers that are none")
def numbers(folder: Path, random: Random) -> Case:
    commands = (
        ("simulate", "crazyflie", "hover", "--out", "new.csv", "--seconds"),
        ("simulate", "crazyflie", "hover", "--out", "new.csv", "--seconds", "0.1", "--seed"),
        ("diagnose", "model", "flight.csv", "--horizon"),
        ("nominal", "car", "--out", "new", "--wheelbase"),
        ("nominal", "quadrotor", "--out", "new", "--interface", "motors", "--mass", "1", "--arm"),
        ("run", "model", "hover", "--samples"),
        ("plan", "crazyflie", "hover", "--yaw-rate"),
        ("learn", "crazyflie", "--out", "new", "--episodes"),
        ("add", "model", "wind", "--out", "new", "--horizon"),
    )
    chosen = random.choice(commands)
    value = random.choice([one for one in NUMBERS if not _is_fine(chosen[-1], one)])
    return Case((*chosen, value), (chosen[-1], _shown(value) if value != "--" else "Missing value"))


def _shown(typed: str) -> str:
    """Pattern of what an error says of what was typed."""
    if not typed:
        return r"''|\.:|'wind:'|of fz|'\.csv'|\.csv:|' '"
    letters = typed.encode("ascii", "backslashreplace").decode() if "\udcff" in typed else typed
    return re.escape(letters[:40]).replace("\\\n", r"(\\n| )").replace("\\\\udcff", r"(\\udcff|\?|\ufffd)")


def _is_fine(option: str, value: str) -> bool:
    return (value == "0" and option in {"--seed", "--yaw-rate"}) or (value == "-1" and option == "--yaw-rate")


@kind("options: names of nothing")
def names(folder: Path, random: Random) -> Case:
    name = random.choice(NAMES)
    commands = (
        ("show", name),
        ("compare", name, "flight.csv"),
        ("compare", "model", f"{name}.csv"),
        ("compare", "model", "flight.csv", "--spec", name or " "),
        ("add", "model", name, "--out", "new"),
        ("add", "model", "wind", f"{name}=1", "--out", "new"),
        ("add", "model", f"wind:{name}", "fx=1", "--out", "new"),
        ("add", "model", f"term:fz={name}(", "--out", "new"),
        ("effects", name),
        ("effects", "--robot", name),
        ("simulate", name, "hover", "--out", "new.csv"),
        ("simulate", "crazyflie", name, "--out", "new.csv"),
        ("run", "model", name),
        ("run", "model", "hover", "--plant", name),
        ("learn", name, "--out", "new"),
        ("learn", "crazyflie", "--out", "new", "--data", "flight.csv", "--engine", name),
        ("export", "model", name, "--out", "new"),
        ("plan", "crazyflie", name),
        ("inspect", f"{name}.csv"),
    )
    return Case(random.choice(commands), (_shown(name),))


@kind("options: too many, too few, unknown")
def counts(folder: Path, random: Random) -> Case:
    whole = random.choice(tuple(READERS.values()))
    how = random.randrange(4)
    if how == 0:
        arguments = whole[: random.randrange(1, 2 if whole[0] != "simulate" else 4)]
        named = f"Missing from sym2real {whole[0]}: .*required|expected one file or more, found none"
    elif how == 1:
        option = random.choice(("--no-such", "--jsn", "--spec=", "--out", "-x", "--json", "---"))
        arguments, named = (*whole, option), f"(^error: |options: |argument '){option}"
    elif how == 2:
        verb = random.choice(("", "-", "compar", "COMPARE", "help", "\udcff", "x" * 500))
        arguments, named = (verb, *whole[1:]), f"verb {_shown(repr(verb)[:40])}" if verb != "-" else "options: -, "
    else:
        arguments, named = (whole[0], *("no_such_thing",) * random.randrange(3, 60)), "no_such_thing"
    return Case(arguments, (named,))


@kind("places: results over what is read")
def over(folder: Path, random: Random) -> Case:
    target = random.choice([name for name in READERS if name != "plant"])
    place = random.choice([name for name in (*READERS[target], target) if (folder / name).exists()])
    how = random.choice(("itself", "absolute", "dots", "symbolic link", "hard link"))
    name = {"absolute": str(folder / place), "dots": f"model/../{place}"}.get(how, place)
    if how == "symbolic link":
        (folder / "link").symlink_to(place)
        name = "link"
    elif how == "hard link" and (folder / place).is_file():
        os.link(folder / place, folder / "link")
        name = "link"
    option = "--json" if (folder / place).is_file() or READERS[target][0] != "inspect" else "--out"
    return Case(
        (*READERS[target], option, name),
        (rf"{re.escape(Path(name).name)}: expected .*(another|not read|name that is free|file, found)",),
    )


@kind("places: where nothing can be written")
def nowhere(folder: Path, random: Random) -> Case:
    target = random.choice([name for name in READERS if name != "plant"])
    place = random.choice(("flight.csv/new", "/proc/new/file", "/dev/null/x", "x" * 300, "plant", "loop/new"))
    (folder / "loop").symlink_to("loop")
    return Case(
        (*READERS[target], "--json", place),
        (f"{place[:60]}.*: expected (a file|a place|a folder|one that can be used, found File name too long)",),
    )


@kind("places: inputs that are no files")
def no_files(folder: Path, random: Random) -> Case:
    log = random.choice(("flight.csv", "flight.parquet", "foreign.csv", "foreign.toml"))
    file = folder / log
    file.unlink()
    how = random.choice(("pipe", "folder", "loop", "nothing", "device", "gone"))
    if how == "pipe":
        os.mkfifo(file)
    elif how == "folder":
        file.mkdir()
    elif how in {"loop", "nothing", "device"}:
        file.symlink_to({"loop": log, "nothing": "no such file", "device": "/dev/zero"}[how])
    found = {"pipe": "a pipe", "device": "a device"}.get(how, "nothing of that name")
    # A folder stands for the logs in it.
    folder_said = "(files that end in .*, found none|a file, found a folder)"
    said = folder_said if how == "folder" else f"a file, found {found}"
    return reading(log, f"{re.escape(log)}: expected {said}")


@kind("places: names that no program expects")
def odd_names(folder: Path, random: Random) -> Case:
    name = random.choice(
        ("a b", "[bold]x", "ψ", "a\nb", "\udcff", "x" * 200, "%s{}", "a'b\"c", "#", "a,b", "--x", "é\u0301")
    )
    log = random.choice(("foreign.csv", "flight.parquet"))
    odd = name + Path(log).suffix
    (folder / log).rename(folder / odd)
    arguments = tuple(one if one != log else f"./{odd}" for one in READERS[log])
    out = ("--out", f"./{name}.toml") if log == "foreign.csv" and random.random() < 0.5 else ()
    return Case((*arguments, *out), (), reads=log, renamed=True)


@kind("streams: encodings that show little")
def encodings(folder: Path, random: Random) -> Case:
    target = random.choice(tuple(READERS))
    encoding = random.choice(("ascii", "cp1252", "latin-1", "cp437", "shift_jis", "utf-16"))
    return Case(READERS[target], (), reads=target, encoding=encoding)


def case_of(number: int, seed: int, folder: Path) -> tuple[str, Case]:
    """Damage a folder as the case of that number does; kinds take turns."""
    kinds = list(KINDS)
    chosen = kinds[number % len(kinds)]
    return chosen, KINDS[chosen](folder, Random(f"{seed}-{number}"))
