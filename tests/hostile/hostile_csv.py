"""Damaged CSV files: bytes, lines, cells, columns; and such as mean the same, which must get the same answer."""

import gzip
import re
from collections.abc import Callable
from pathlib import Path
from random import Random

from hostile_case import Case, kind, reading

LOGS = ("flight.csv", "foreign.csv")
USED = ("time", "x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz", "thrust", "wx_cmd")
BAD_CELLS = (
    *("abc", "1e300", "inf", "-inf", '"1,5"', "1_0", '"1.5', "9" * 140000),
    *("0x10", "--1", "1.2.3", "1 2", '"', "é"),
)


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
    emptied = range(start, min(len(lines), start + random.choice((1, 5, 30, 200))))
    for row in emptied:
        cells = lines[row].split(",")
        cells[place] = random.choice(("", "nan", "NaN", "null"))
        lines[row] = ",".join(cells)
    write(folder, log, lines)
    where = f"{start + 1}" + (f" to {emptied[-1] + 1}" if len(emptied) > 1 else "")
    told = rf"{len(emptied)} of {len(lines) - 1} rows left out, for want of numbers in {name}: rows {where}\b"
    return reading(log, re.escape(log), rf"{told}|'{name}'|in all of {name}, found none", told=told)


@kind("CSV: bytes cut off")
def cut(folder: Path, random: Random) -> Case:
    log = random.choice(LOGS)
    content = (folder / log).read_bytes()
    # Within a row, before its last cell: a file that ends with a whole row is a shorter log.
    row = random.choice([line for line in content.splitlines(keepends=True) if line])
    start = content.index(row)
    kept = content[: start + random.randrange(1, row.rindex(b",") + 1)]
    (folder / log).write_bytes(kept)
    line = kept.count(b"\n") + 1
    return reading(log, re.escape(log), rf"row {line}\b" if line > 1 else "row 1|column names only")


@kind("CSV: bytes that are no text")
def binary(folder: Path, random: Random) -> Case:
    log = random.choice(LOGS)
    content = bytearray((folder / log).read_bytes())
    place = random.randrange(len(content))
    line = content[:place].count(b"\n") + 1
    content[place : place + 1] = random.choice(
        (b"\0", b"\xff", b"\x80\x81", b"\xc3\x28", b"\xff" + random.randbytes(30))
    )
    (folder / log).write_bytes(content)
    return reading(log, re.escape(log), rf"row {line}: expected text, found (bytes that are no UTF-8|a zero byte)")


@kind("CSV: another file under its name")
def other_content(folder: Path, random: Random) -> Case:
    log = random.choice(LOGS)
    text = (folder / log).read_bytes()
    model, parquet = folder / "model" / "equations.json", folder / "flight.parquet"
    no_text, no_columns = "row 1: .*bytes that are no UTF-8", "row 1: expected two or more columns"
    chosen, named = random.choice(
        (
            (b"", "an empty file"),
            (b"\n\n\n", "an empty file"),
            (b" ", "an empty file"),
            (gzip.compress(text), no_text),
            (text.decode().encode("utf-16"), no_text),
            (b"\xf5" + random.randbytes(2000), no_text),
            (b"<html><body>404</body></html>", no_columns),
            (model.read_bytes(), no_columns),
            (parquet.read_bytes(), no_text),
            (text.split(b"\n")[0] + b"\n", "column names only"),
            (b"\n".join(text.split(b"\n")[:2]) + b"\n", "rows .*found 1\\b"),
            (text.split(b"\n", 1)[1], "row 1: expected column names"),
            (b"a,b\n" * 100, "row 2: expected a column of numbers, found text"),
            (b'"' * 5000, no_columns),
            (b"," * 5000, "row 1: expected a name for every column"),
        )
    )
    (folder / log).write_bytes(chosen)
    return reading(log, re.escape(log), named)


@kind("CSV: another delimiter")
def delimiter(folder: Path, random: Random) -> Case:
    log = random.choice(LOGS)
    other, found = random.choice(((";", "semicolons"), ("\t", "tabs"), ("|", "bars"), (" ", "'(log_)?time (log_)?x ")))
    (folder / log).write_text((folder / log).read_text().replace(",", other))
    return reading(log, re.escape(log), f"row 1: expected .*columns separated by commas, found {found}")


@kind("CSV: lines of other lengths")
def lengths(folder: Path, random: Random) -> Case:
    log = random.choice(LOGS)
    lines = lines_of(folder, log)
    row = random.randrange(1, len(lines) - 1)  # an empty last line is nothing
    lines[row] = random.choice((lines[row] + ",1", lines[row].rpartition(",")[0], "", "   ", lines[row] * 2, ","))
    write(folder, log, lines)
    return reading(
        log, re.escape(log), rf"row {row + 1}: expected 37 values, one per column, found (\d+ values|an empty)"
    )


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
    lacking = (
        "a column 't' of time stamps" if name == "time" else rf"expected columns of the model: .*\b{name}\b.*found"
    )
    named = {"twice": f"row 1, column '{name}': .*twice", "unnamed": f"row 1: .*found none for column {place + 1}$"}
    return reading(log, re.escape(log), named.get(how, lacking))


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
    return reading(log)
