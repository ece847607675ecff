"""CSV files whose rows are in disorder or missing, or whose stamps or attitudes cannot be."""

import re
from pathlib import Path
from random import Random

from hostile_case import Case, kind, reading
from hostile_csv import LOGS, lines_of, write


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
    if how == "twice":
        told = rf"1 of {len(lines) - 1} rows left out, which repeat the one before, stamp and all: rows {row + 2}\b"
        return reading(log, told=told)
    stamps = [float(line.split(",")[0]) for line in lines[1:]]
    first = next(i for i in range(1, len(stamps)) if stamps[i] <= stamps[i - 1])
    return reading(log, re.escape(log), rf"row {first + 2}, column '(log_)?time': expected stamps that increase")


@kind("CSV: rows missing")
def rows_missing(folder: Path, random: Random) -> Case:
    log = random.choice(LOGS)
    lines = lines_of(folder, log)
    gone = random.choice((1, 2, 10, 60))
    row = random.randrange(3, len(lines) - gone)  # behind two rows: one alone is a first interval, not a piece
    del lines[row : row + gone]
    write(folder, log, lines)
    bridged = rf"\(20 to {20 * (gone + 1)}\), {100 - gone} rows became 100\b|within 20 to {20 * (gone + 1)}\)"
    pieces = f"rows (2 to {row}|{row + 1} to {len(lines)})"
    cut = rf"cut at a gap of the stamps: {pieces}\b|{(gone + 1) / 50:g} s before row {row + 1} of"
    told = bridged if gone < 3 else cut
    return reading(log, re.escape(log), told, told=told)


@kind("CSV: stamps in another unit, or that stand")
def stamps(folder: Path, random: Random) -> Case:
    log = "flight.csv"
    rows = [line.split(",") for line in lines_of(folder, log)]
    factor, named = random.choice(
        (
            (0.0, "row 3, .*the same stamp"),
            (1e3, "unit .*found 20 s"),
            (1e9, "unit .*found 2e\\+07 s"),
            (-1.0, "row 3, .*an earlier stamp"),
            (1e-6, "unit .*found rows 2e-08 s apart"),
        )
    )
    for row in rows[1:]:
        row[0] = repr(float(row[0]) * factor)
    write(folder, log, [",".join(row) for row in rows])
    return reading(log, re.escape(log), "column 'time': ", named)


@kind("CSV: an attitude that is none")
def attitude(folder: Path, random: Random) -> Case:
    log = "flight.csv"
    rows = [line.split(",") for line in lines_of(folder, log)]
    start = rows[0].index("qw")
    row = random.randrange(1, len(rows))
    everywhere = random.random() < 0.5
    for one in rows[1:] if everywhere else [rows[row]]:
        one[start : start + 4] = ["0", "0", "0", "0"]
    write(folder, log, [",".join(one) for one in rows])
    line = 2 if everywhere else row + 1
    return reading(log, re.escape(log), rf"row {line}: expected a unit quaternion in qw, qx, qy, qz, found a norm of 0")
