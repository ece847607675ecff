"""Runs hostile cases and judges them; ``tools/hostile`` prints the table.

A run may end in four ways: with the answer of the undamaged file, with another one that names the damage, with one
clear error, or as a failure.
"""

import argparse
import gc
import hashlib
import json
import os
import re
import shutil
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

import hostile_csv
import hostile_parquet
import hostile_rows
import hostile_text
from forked import Ran, forked
from hostile_case import KINDS, Case
from hostile_options import case_of
from hostile_world import RESULT, World, make_world

MADE_BY = (hostile_csv, hostile_rows, hostile_parquet, hostile_text)  # imported for the kinds that they register
SAME, NAMED, CLEAN, FAILED = "same answer", "damage named", "clean error", "failure"
MOST_LINES = 3
# What was expected and found, or what was typed and the valid ones; the words of an option that is missing are tyro's.
ERROR = re.compile(
    r"^error: (.*\bexpected .+ found .|.*\bunknown .+(\(known: |did you mean )|"
    r".*Expected one of \(|Missing |Unrecognized .*options: )",
    re.DOTALL,
)


@dataclass(frozen=True)
class Outcome:
    """How a case ended.

    Args:
        number: of the case.
        kind: of its damage.
        end: one of the four.
        why: it is a failure, with what was typed and said; else empty.
    """

    number: int
    kind: str
    end: str
    why: str = ""


def run_case(world: World, number: int, seed: int) -> Outcome:
    """Make one case in a folder of its own, run it and judge it."""
    with tempfile.TemporaryDirectory() as above:
        folder = Path(above) / "world"
        shutil.copytree(world.folder, folder)
        kind, case = case_of(number, seed, folder)
        before = contents(folder)
        typed = case.arguments if "--json" in case.arguments or not case.reads else (*case.arguments, "--json", RESULT)
        ran = forked(typed, folder, encoding=case.encoding)
        end, why = judged(case, ran, folder, world.answers)
        after = contents(folder)
        lost = [name for name, content in before.items() if after.get(name) != content]
        left = [name for name in after if ".writing-" in name]
        if lost or left:
            end, why = FAILED, f"inputs changed: {lost}" if lost else f"left behind: {left}"
        if end == FAILED:
            why = f"{why}\n  typed: {' '.join(map(repr, typed))[:300]}\n  status {ran.status}: {ran.err[-600:]}"
        return Outcome(number, kind, end, why)


def contents(folder: Path) -> dict[str, str]:
    """Digest of every file in a folder; links and pipes by what they are."""
    found = {}
    for path in folder.rglob("*"):
        name = str(path.relative_to(folder))
        if path.is_symlink():
            found[name] = f"link to {path.readlink()}"
        elif path.is_file():
            found[name] = hashlib.sha256(path.read_bytes()).hexdigest()
        else:
            found[name] = "folder" if path.is_dir() else "pipe"
    return found


def judged(case: Case, ran: Ran, folder: Path, answers: dict[str, object]) -> tuple[str, str]:
    """How a run ended, and why where that is a failure."""
    if ran.status == 0:
        return _judged_answer(case, ran, folder, answers)
    missing = [pattern for pattern in case.named if not re.search(pattern, ran.err, re.DOTALL)]
    faults = {
        f"ended by signal {-ran.status} (14: it hung)": ran.status < 0,
        "an error that nobody foresaw": "Traceback" in ran.err or ran.status != 2,
        "an error, though nothing is missing": not case.named,
        f"more than {MOST_LINES} lines": ran.err.count("\n") > MOST_LINES,
        "an error without what was expected and found": not ERROR.match(ran.err),
        f"an error without {' and '.join(missing)}": bool(missing),
    }
    return next(((FAILED, why) for why, holds in faults.items() if holds), (CLEAN, ""))


def _judged_answer(case: Case, ran: Ran, folder: Path, answers: dict[str, object]) -> tuple[str, str]:
    if not case.reads:
        return FAILED, "an answer to nothing"
    answer = json.loads((folder / RESULT).read_text(encoding="utf-8"))
    if answer == answers[case.reads]:
        return SAME, ""
    undamaged = answers[case.reads]
    if case.renamed and figures(answer) == figures(undamaged):
        return SAME, ""
    if case.told and re.search(case.told, _words(answer)) and not re.search(case.told, _words(undamaged)):
        return NAMED, ""
    return FAILED, f"another answer, and nothing of {case.told or 'the damage'}"


def _words(answer: object) -> str:
    return json.dumps(answer, ensure_ascii=False)


def figures(answer: object) -> list[str]:
    """Every number in an answer, those in its texts too, in order."""
    return re.findall(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?", _words(answer))


def run_all(numbers: Iterable[int], seed: int, jobs: int) -> Iterator[Outcome]:
    """Run cases in so many processes, each of which makes its world once and forks for every case."""
    chosen = list(numbers)
    with ThreadPoolExecutor(jobs) as threads:
        parts = [threads.submit(_part, chosen[start::jobs], seed) for start in range(jobs)]
        for part in parts:
            yield from part.result()


def _part(numbers: list[int], seed: int) -> list[Outcome]:
    with get_context("spawn").Pool(1) as pool:
        return pool.apply(_outcomes, (numbers, seed))


def _outcomes(numbers: list[int], seed: int) -> list[Outcome]:
    with tempfile.TemporaryDirectory() as above:
        world = make_world(Path(above) / "world")
        gc.freeze()  # a fork that looked through all that the libraries have left would copy it
        return [run_case(world, number, seed) for number in numbers]


def table(outcomes: Iterable[Outcome]) -> str:
    """Cases by kind of damage and how they ended."""
    counts: defaultdict[str, Counter[str]] = defaultdict(Counter)
    for one in outcomes:
        counts[one.kind][one.end] += 1
    rows = [[kind, *(str(counts[kind][end]) for end in ENDS)] for kind in KINDS if kind in counts]
    rows.append(["all", *(str(sum(count[end] for count in counts.values())) for end in ENDS)])
    lines = ["| " + " | ".join(["damage", "cases", *ENDS]) + " |", "|---|" + "---:|" * (len(ENDS) + 1)]
    return "\n".join([*lines, *(f"| {row[0]} | {sum(map(int, row[1:]))} | {' | '.join(row[1:])} |" for row in rows)])


ENDS = (SAME, NAMED, CLEAN, FAILED)


def main() -> None:
    """Run so many cases and print the table and the failures."""
    parser = argparse.ArgumentParser(description="Damaged inputs on the command line: what comes of them.")
    parser.add_argument("--cases", type=int, default=500)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()
    outcomes = list(run_all(range(given.first, given.first + given.cases), given.seed, given.jobs))
    for one in (one for one in outcomes if one.end == FAILED):
        print(f"case {one.number}, {one.kind}: {one.why}\n")
    print(table(outcomes))
    sys.exit(any(one.end == FAILED for one in outcomes))


if __name__ == "__main__":
    main()
