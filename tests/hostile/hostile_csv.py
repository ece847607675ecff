"""Damaged CSV files: bytes, lines, cells, columns; and such as mean the same, which must get the same answer."""

from __future__ import annotations

import gzip
import re
from collections.abc import Callable
from pathlib import Path
from random import Random

from hostile_case import Case, kind, reading

LOGS = ("flight.csv", "foreign.csv")
USED = ("time", "x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz", "thrust", "wx_cmd")
BAD_CELLS = (
    "abc",
    "1e300",
    "inf",
    "-inf",
    '"1,5"',
    "1_0",
    '"1.5',
    "9" * 140000,
    "0x10",
    "--1",
    "1.2.3",
    "1 2",
    '"',
    "é",
)
LEFT_OUT = r"left out|rows? (dropped|missing)|gap|held|resampled|pieces?|an empty cell"


def lines_of(folder: Path, log: str) -> list[str]:
    """Lines of a log, the header first."""
    return (folder / log).read_text().splitlines()


def write(folder: Path, log: str, lines: list[str]) -> None:
    """Put lines into a log's place."""
    (folder / log).write_text("\n".join(lines) + "\n")


def _used(lines: list[str], random: Random) -> tuple[int, str]:
    """Place and name of a column that every answer needs."""
    names = lines[0].split(",")
    chosen = random.choice([name for name in names if name.removeprefix("log_") in USED])
    return names.index(chosen), chosen


@kind("CSV: a cell that is no number")
def bad_cell(folder: Path, random: Random) -> Case:
    log, cell = random.choice(LOGS), random.choice(BAD_CELLS)
    lines = lines_of(folder, log)
    row, (place, name) = random.randrange(1, len(lines)), _used(lines, random)
    cells = lines[row].split(",")
    cells[place] = cell
    lines[row] = ",".join(cells)
    write(folder, log, lines)
    where = rf"row {row + 1}\b" + ("" if cell.startswith('"') and cell != '"1,5"' else rf".*'{name}'")
    return reading(log, re.escape(log), where)


@kind("CSV: empty cells")
def empty_cells(folder: Path, random: Random) -> Case:
    log = random.choice(LOGS)
    lines = lines_of(folder, log)
    place, name = _used(lines, random)
    start = random.randrange(1, len(lines))
    for row in range(start, min(len(lines), start + random.choice((1, 5, 30, 200)))):
        cells = lines[row].split(",")
        cells[place] = random.choice(("", "nan", "NaN", "null"))
        lines[row] = ",".join(cells)
    write(folder, log, lines)
    return reading(log, re.escape(log), told=LEFT_OUT + f"|{name}")


@kind("CSV: bytes cut off")
def cut(folder: Path, random: Random) -> Case:
    log = random.choice(LOGS)
    content = (folder / log).read_bytes()
    size = random.randrange(len(content) - 2)
    (folder / log).write_bytes(content[:size])
    # A file that ends with a whole row is a shorter log, and so is one whose last number has lost digits.
    whole_row = len(content[:size].split(b"\n")[-1].split(b",")) == len(content.split(b"\n")[0].split(b","))
    shorter = content[size - 1 : size] == b"\n" or whole_row
    return reading(log, re.escape(log), told=r"\w" if shorter else "")


@kind("CSV: bytes that are no text")
def binary(folder: Path, random: Random) -> Case:
    log = random.choice(LOGS)
    content = bytearray((folder / log).read_bytes())
    place = random.randrange(len(content))
    content[place : place + 1] = random.choice(
        (b"\0", b"\xff", b"\x80\x81", b"\xc3\x28", random.randbytes(30) + b"\xff")
    )
    (folder / log).write_bytes(content)
    return reading(log, re.escape(log))


@kind("CSV: another file under its name")
def other_content(folder: Path, random: Random) -> Case:
    log = random.choice(LOGS)
    text = (folder / log).read_bytes()
    contents: tuple[Callable[[], bytes], ...] = (
        lambda: b"",
        lambda: b"\n\n\n",
        lambda: b" ",
        lambda: gzip.compress(text),
        lambda: text.decode().encode("utf-16"),
        lambda: random.randbytes(2000),
        lambda: b"<html><body>404</body></html>",
        (folder / "model" / "equations.json").read_bytes,
        (folder / "flight.parquet").read_bytes,
        lambda: text.split(b"\n")[0] + b"\n",
        lambda: b"\n".join(text.split(b"\n")[:2]) + b"\n",
        lambda: text.split(b"\n", 1)[1],
        lambda: b"a,b\n" * 100,
        lambda: b'"' * 5000,
        lambda: b"," * 5000,
    )
    (folder / log).write_bytes(random.choice(contents)())
    return reading(log, re.escape(log))


@kind("CSV: another delimiter")
def delimiter(folder: Path, random: Random) -> Case:
    log, other = random.choice(LOGS), random.choice((";", "\t", "|", " "))
    (folder / log).write_text((folder / log).read_text().replace(",", other))
    return reading(log, re.escape(log), "row 1")


@kind("CSV: lines of other lengths")
def lengths(folder: Path, random: Random) -> Case:
    log = random.choice(LOGS)
    lines = lines_of(folder, log)
    row = random.randrange(1, len(lines))
    lines[row] = random.choice((lines[row] + ",1", lines[row].rpartition(",")[0], "", "   ", lines[row] * 2, ","))
    write(folder, log, lines)
    last = row == len(lines) - 1 and not lines[row].strip()
    return reading(log, re.escape(log), *(() if last else (rf"row {row + 1}\b",)), told=r"\w" if last else "")


@kind("CSV: a column gone, twice or without a name")
def columns(folder: Path, random: Random) -> Case:
    log = "flight.csv"
    rows = [line.split(",") for line in lines_of(folder, log)]
    place, name = _used([",".join(rows[0])], random)
    how = random.choice(("gone", "twice", "unnamed", "renamed"))
    for row in rows:
        if how == "gone":
            row.pop(place)
        elif how == "twice":
            row.append(row[place])
    if how in {"unnamed", "renamed"}:
        rows[0][place] = "" if how == "unnamed" else "something_else"
    write(folder, log, [",".join(row) for row in rows])
    return reading(log, re.escape(log), rf"{name}\b|column {place + 1}\b|time", told=r"\w" if name == "time" else "")


@kind("CSV: rows in another order or twice")
def order(folder: Path, random: Random) -> Case:
    log = random.choice(LOGS)
    lines = lines_of(folder, log)
    row = random.randrange(1, len(lines) - 1)
    how = random.choice(("twice", "swapped", "backwards", "shuffled"))
    if how == "twice":
        lines.insert(row, lines[row])
    elif how == "swapped":
        lines[row], lines[row + 1] = lines[row + 1], lines[row]
    else:
        rest = lines[1:]
        random.shuffle(rest) if how == "shuffled" else rest.reverse()
        lines[1:] = rest
    write(folder, log, lines)
    return reading(log, re.escape(log), r"row \d+|column")


@kind("CSV: rows missing")
def rows_missing(folder: Path, random: Random) -> Case:
    log = random.choice(LOGS)
    lines = lines_of(folder, log)
    row = random.randrange(2, len(lines) - 2)
    del lines[row : row + random.choice((1, 2, 10, 60))]
    write(folder, log, lines)
    return reading(log, re.escape(log), told=LEFT_OUT + r"|irregular|apart|interval|rows|ms")


@kind("CSV: stamps in another unit, or that stand")
def stamps(folder: Path, random: Random) -> Case:
    log = "flight.csv"
    rows = [line.split(",") for line in lines_of(folder, log)]
    factor = random.choice((0.0, 1e3, 1e9, -1.0, 1e-6))
    for row in rows[1:]:
        row[0] = repr(float(row[0]) * factor)
    write(folder, log, [",".join(row) for row in rows])
    return reading(log, re.escape(log), "stamp|time|apart")


@kind("CSV: an attitude that is none")
def attitude(folder: Path, random: Random) -> Case:
    log = "flight.csv"
    rows = [line.split(",") for line in lines_of(folder, log)]
    start = rows[0].index("qw")
    row = random.randrange(1, len(rows))
    for one in rows[1:] if random.random() < 0.5 else [rows[row]]:
        one[start : start + 4] = ["0", "0", "0", "0"]
    write(folder, log, [",".join(one) for one in rows])
    return reading(log, re.escape(log), r"row \d+|quaternion")


@kind("CSV: written in another way")
def same(folder: Path, random: Random) -> Case:
    log = random.choice(LOGS)
    text = (folder / log).read_text()
    header, _, rest = text.partition("\n")
    ways: tuple[Callable[[], bytes], ...] = (
        lambda: b"\xef\xbb\xbf" + text.encode(),
        lambda: text.replace("\n", "\r\n").encode(),
        lambda: text.replace("\n", "\r").encode(),
        lambda: text.rstrip("\n").encode(),
        (text + "\n\n").encode,
        ("# " + text).encode,
        lambda: text.replace(",", ", ").encode(),
        (",".join(f'"{name}"' for name in header.split(",")) + "\n" + rest).encode,
        lambda: re.sub(r"([^,\n]+)", r'"\1"', text).encode(),
        (header + "\n" + re.sub(r"e-0?(\d)", r"E-\1", rest)).encode,
        (header + "\n" + re.sub(r"(^|,)(\d)", r"\1+\2", rest, flags=re.MULTILINE)).encode,
    )
    (folder / log).write_bytes(random.choice(ways)())
    return reading(log, must_answer=True)
