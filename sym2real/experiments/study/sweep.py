"""A sweep: independent jobs on this machine or on a cluster, each of whose answers is kept as a file when it is there.

A job that has been answered is not run again, so a sweep that was stopped goes on where it was. On this machine the
jobs run in processes of joblib; with the address of a dask scheduler its workers run them, and what a lost worker had
begun is begun anew by another. What jobs of this machine say while they run stands in ``running/NAME.txt``.
"""

import json
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeAlias

import torch
from joblib import Parallel, delayed, parallel_config
from joblib.externals.loky.process_executor import TerminatedWorkerError

from sym2real.errors import DataError, ModelError, Sym2RealError, needing, reason
from sym2real.files import make_folder, read_object, write_text

Record: TypeAlias = dict[str, Any]
Tell: TypeAlias = Callable[[str], None]
ANSWERS, RUNNING = "answers", "running"
CONNECT = "10 s"
MOST_LOST = 3  # times that processes of this machine may be lost, to a lack of memory say


class Job(Protocol):
    """One independent part of a study; it travels to another process."""

    @property
    def name(self) -> str:
        """Unlike any other's; names its file."""

    @property
    def asked(self) -> Record:
        """Everything that the answer depends on, as JSON holds it."""

    def run(self, tell: Tell) -> Record:
        """The answer, as JSON holds it; ``tell`` takes a line about what is going on."""


@dataclass(frozen=True)
class Progress:
    """``done`` of ``total`` jobs are answered, the newest of them in so many seconds."""

    done: int
    total: int
    newest: str = ""
    seconds: float = 0.0


OnProgress: TypeAlias = Callable[[Progress], None]


def run_sweep(
    jobs: Sequence[Job],
    folder: Path,
    *,
    workers: int = 2,
    cluster: str = "",
    on_progress: OnProgress = lambda _: None,
) -> dict[str, Record]:
    """Every job's answer by its name.

    Args:
        jobs: with names of their own.
        folder: keeps the answers, ``answers/NAME.json``.
        workers: processes on this machine.
        cluster: address of a dask scheduler instead ("tcp://host:8786").
        on_progress: told of every answer.

    Raises:
        ModelError: when the folder holds a job's answer to another question; when jobs failed, with their errors, once
            all others are answered.
        DataError: when there is no reading or writing there.
        MissingDependencyError: for a cluster without dask.distributed.
    """
    answers = kept(jobs, folder)
    rest = [job for job in jobs if job.name not in answers]
    on_progress(Progress(len(answers), len(jobs)))
    status = make_folder(folder / RUNNING)
    for file in status.glob("*.txt"):
        file.unlink(missing_ok=True)  # of a sweep that was killed, or of one beside this whose job has just ended
    failed: dict[str, str] = {}
    with _on_cluster(cluster) if cluster else nullcontext():
        for name, record in _answers(rest, -1 if cluster else workers, None if cluster else status):
            if "error" in record:
                failed[name] = record["error"]
                continue
            write_text(answer_file(folder, name), json.dumps(record, indent=1))
            answers[name] = record
            on_progress(Progress(len(answers), len(jobs), name, record["seconds"]))
    if failed:
        failures = "; ".join(f"{name}: {error}" for name, error in sorted(failed.items()))
        raise ModelError(f"{len(failed)} of {len(jobs)} jobs failed ({failures}); all other answers are in {folder}")
    return answers


def kept(jobs: Sequence[Job], folder: Path) -> dict[str, Record]:
    """The answers that a folder holds already.

    Raises:
        ModelError: when one of them answers another question.
        DataError: when one cannot be read.
    """
    records: dict[str, Record] = {}
    for job in jobs:
        file = answer_file(folder, job.name)
        if not file.exists():
            continue
        record, asked = read_object(file, "the answer of a job"), json.loads(json.dumps(job.asked))
        there = record.get("asked")
        if not isinstance(there, dict):
            raise DataError(file, "the answer of a job", "no `asked`")
        if there != asked:
            keys = sorted(key for key in there | asked if there.get(key) != asked.get(key))
            shown = ", ".join(f"{key}: {there.get(key)} there, {asked.get(key)} now" for key in keys)
            raise ModelError(f"{file} has another setting ({shown}); choose another folder, or delete the file")
        records[job.name] = record
    return records


def answer_file(folder: Path, name: str) -> Path:
    """Where a job's answer is kept."""
    return folder / ANSWERS / f"{name}.json"


def running(folder: Path) -> tuple[str, ...]:
    """What the jobs that run say of themselves now."""
    words = []
    for file in sorted((folder / RUNNING).glob("*.txt")):
        with suppress(OSError):  # it has just ended
            words.append(f"{file.stem}: {file.read_text(encoding='utf-8')}")
    return tuple(words)


def answered(job: Job, status: Path | None) -> tuple[str, Record]:
    """Run a job in this process: its name and its answer, or ``error`` in its place."""
    torch.set_num_threads(1)
    began = time.perf_counter()

    def tell(text: str) -> None:
        if status is not None:
            write_text(status, text)

    try:
        tell("begins")
        return job.name, {**job.run(tell), "asked": job.asked, "seconds": time.perf_counter() - began}
    except (Sym2RealError, ArithmeticError, LookupError, OSError, RuntimeError, TypeError, ValueError) as error:
        return job.name, {"error": f"{type(error).__name__}: {reason(error)}"}
    finally:
        if status is not None:
            status.unlink(missing_ok=True)


def _answers(jobs: Sequence[Job], workers: int, status: Path | None) -> Iterator[tuple[str, Record]]:
    """Answers as they come; where a process was lost, what it had begun is begun anew."""
    left = {job.name: job for job in jobs}
    for losses in range(MOST_LOST + 1):
        places = {name: None if status is None else status / f"{name}.txt" for name in left}
        runs = (delayed(answered)(job, places[name]) for name, job in list(left.items()))
        try:
            for name, record in Parallel(n_jobs=workers, return_as="generator_unordered", batch_size=1)(runs):
                del left[name]
                yield name, record
            return
        except TerminatedWorkerError:
            if losses == MOST_LOST:
                raise ModelError(f"processes were lost {losses + 1} times: is there enough memory?") from None


@contextmanager
def _on_cluster(address: str) -> Iterator[None]:
    """Joblib's jobs run on dask's workers; the scheduler gives what a lost worker had begun to another."""
    with needing("a cluster needs dask.distributed", "cluster"):
        from distributed import Client  # noqa: PLC0415 — an extra
    try:
        client = Client(address, timeout=CONNECT)
    except (OSError, ValueError) as error:
        raise ModelError(f"--cluster: expected the address of a dask scheduler, found {address!r}: {error}") from error
    with client, parallel_config("dask", n_jobs=-1):
        yield
