"""The sweep: what is answered stays answered, whatever stops a job, a process, a worker or the whole run."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from threading import Thread

import pytest
from sweep_jobs import Square

from sym2real.errors import DataError, ModelError
from sym2real.experiments.study.sweep import answer_file, run_sweep, running
from sym2real.files import write_text

TESTS = str(Path(__file__).parent)


@pytest.fixture(autouse=True)
def _jobs_are_importable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, (TESTS, os.environ.get("PYTHONPATH")))))


def runs(log: Path) -> list[int]:
    return sorted(int(line.split()[0]) for line in log.read_text().splitlines())


def test_answers_are_kept_and_not_asked_for_again(tmp_path: Path) -> None:
    log = tmp_path / "log"
    jobs = [Square(value, str(log)) for value in range(4)]
    run_sweep(jobs[:2], tmp_path, workers=2)
    told = []
    answers = run_sweep(jobs, tmp_path, workers=2, on_progress=told.append)
    assert {name: record["square"] for name, record in answers.items()} == {f"square-{n}": n**2 for n in range(4)}
    assert runs(log) == [0, 1, 2, 3]
    assert [progress.done for progress in told] == [2, 3, 4]
    assert running(tmp_path) == ()


def test_a_failed_job_is_named_and_the_others_are_kept(tmp_path: Path) -> None:
    log = tmp_path / "log"
    jobs = [Square(value, str(log), fails=value == 1) for value in range(3)]
    with pytest.raises(ModelError, match=r"1 of 3 jobs failed \(square-1: ValueError: no square today"):
        run_sweep(jobs, tmp_path, workers=1)
    assert [answer_file(tmp_path, job.name).exists() for job in jobs] == [True, False, True]
    mended = [Square(value, str(log)) for value in range(3)]
    assert len(run_sweep(mended, tmp_path, workers=1)) == 3
    assert runs(log) == [0, 1, 1, 2]


def test_a_killed_process_loses_nothing(tmp_path: Path) -> None:
    log = tmp_path / "log"
    jobs = [Square(value, str(log), kills=value == 1) for value in range(4)]
    answers = run_sweep(jobs, tmp_path, workers=2)
    assert sorted(record["square"] for record in answers.values()) == [0, 1, 4, 9]
    assert runs(log).count(1) == 2


def test_a_sweep_beside_another_minds_no_line_that_is_gone(tmp_path: Path) -> None:
    lines = [tmp_path / "running" / f"other-{number}.txt" for number in range(300)]
    for line in lines:
        write_text(line, "begins")
    other = Thread(target=lambda: [line.unlink(missing_ok=True) for line in reversed(lines)])
    other.start()
    assert len(run_sweep([Square(2, str(tmp_path / "log"))], tmp_path, workers=1)) == 1
    other.join()


def test_another_question_under_the_same_name_is_refused(tmp_path: Path) -> None:
    log = str(tmp_path / "log")
    run_sweep([Square(3, log)], tmp_path, workers=1)
    with pytest.raises(ModelError, match=r"wait: 0.0 there, 0.5 now.*choose another folder"):
        run_sweep([Square(3, log, wait=0.5)], tmp_path, workers=1)
    answer_file(tmp_path, "square-3").write_text("half an ans")
    with pytest.raises(DataError, match=r"square-3\.json.*answer of a job"):
        run_sweep([Square(3, log)], tmp_path, workers=1)


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """A dask scheduler and two workers, processes of their own."""
    distributed = pytest.importorskip("distributed", reason="needs the extra `cluster`")
    file = tmp_path / "scheduler.json"
    start = [sys.executable, "-m", "dask"]
    options = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    place = ["--scheduler-file", str(file)]
    scheduler = subprocess.Popen([*start, "scheduler", "--port", "0", "--no-dashboard", *place], **options)
    processes = [scheduler]
    try:
        while not (address := address_in(file)):
            assert scheduler.poll() is None
            time.sleep(0.05)
        alone = ["--nthreads", "1", "--no-nanny", "--no-dashboard"]
        processes += [subprocess.Popen([*start, "worker", *place, *alone], **options) for _ in range(2)]
        with distributed.Client(address) as client:
            client.wait_for_workers(2)
        yield address, processes[1:]
    finally:
        for process in processes:
            process.kill()
            process.wait()


def address_in(file: Path) -> str:
    """The scheduler's, empty until it has written it."""
    try:
        return str(json.loads(file.read_text())["address"])
    except (FileNotFoundError, json.JSONDecodeError):
        return ""


def test_a_sweep_on_a_cluster_outlives_a_worker(
    tmp_path: Path, cluster: tuple[str, list[subprocess.Popen[bytes]]]
) -> None:
    address, workers = cluster
    log = tmp_path / "log"
    jobs = [Square(value, str(log), wait=0.3) for value in range(8)]
    killed: list[int] = []

    def kill_one(progress: object) -> None:
        if getattr(progress, "done", 0) >= 2 and not killed:
            killed.append(workers[0].pid)
            os.kill(workers[0].pid, signal.SIGKILL)

    answers = run_sweep(jobs, tmp_path / "sweep", cluster=address, on_progress=kill_one)
    assert killed and workers[0].wait() == -signal.SIGKILL
    assert sorted(record["square"] for record in answers.values()) == [n**2 for n in range(8)]
    assert {int(line.split()[2]) for line in log.read_text().splitlines()} >= {workers[1].pid}
    assert running(tmp_path / "sweep") == ()


def test_no_scheduler_is_one_clear_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed", reason="needs the extra `cluster`")
    monkeypatch.setattr("sym2real.experiments.study.sweep.CONNECT", "1 s")
    with pytest.raises(ModelError, match=r"--cluster: expected the address of a dask scheduler, found 'tcp://127"):
        run_sweep([Square(1, str(tmp_path / "log"))], tmp_path, cluster="tcp://127.0.0.1:9")
