"""What goes where: results on standard output, errors on standard error, files before words, and the last net."""

import errno
import json
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from forked import forked

from sym2real.cli import TRACEBACK, main
from sym2real.cli.show import Show
from sym2real.data import example_flight
from sym2real.robots import CRAZYFLIE
from sym2real.symbolic import save_model


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return save_model(CRAZYFLIE.nominal(), tmp_path_factory.mktemp("models") / "quadrotor")


@pytest.mark.parametrize("command", ["show nothing", "compare", "show m --jsn x", "nominal", "export a b"])
def test_an_error_is_on_standard_error_alone(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(command.split())
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("error: ")


@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "latin-1", "utf-8"])
def test_what_a_stream_cannot_show_is_replaced_and_everything_is_written(encoding: str, tmp_path: Path) -> None:
    log = shutil.copy(example_flight(), tmp_path / "flug-ψ.csv")
    out = tmp_path / "flug-ψ.toml"
    arguments = ["inspect", str(log), "--out", str(out), "--json", str(tmp_path / "result.json")]
    done = forked(arguments, tmp_path, encoding=encoding)
    assert (done.status, done.err) == (0, "")
    assert ("flug-ψ" if encoding == "utf-8" else "flug-?") in done.out
    assert "flug-ψ.csv" in out.read_text(encoding="utf-8")
    assert json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))["columns"]


def test_json_on_a_stream_that_lacks_letters_is_the_same_json(tmp_path: Path) -> None:
    log = shutil.copy(example_flight(), tmp_path / "flug-ψ.csv")
    texts = [forked(["inspect", str(log), "--json", "-"], tmp_path, encoding=one).out for one in ("ascii", "utf-8")]
    assert texts[0].isascii()
    assert not texts[1].isascii()
    assert json.loads(texts[0]) == json.loads(texts[1])


@pytest.mark.slow
def test_everything_is_on_disk_before_the_first_word(model: Path, tmp_path: Path) -> None:
    """Whoever reads the first byte finds the files there."""
    result = tmp_path / "result.json"
    code = f"""
import os, sys
from sym2real.cli import main
class Stream:
    encoding = "utf-8"
    def write(self, text):
        os.write(2, str(os.path.exists({str(result)!r}) and os.path.exists({str(tmp_path / "page.html")!r})).encode())
        os._exit(0)
    def flush(self): pass
    def isatty(self): return False
    def fileno(self): return 1
sys.stdout = Stream()
main(["compare", {str(model)!r}, {str(tmp_path / "flight.csv")!r}, "--report", {str(tmp_path / "page.html")!r},
      "--json", {str(result)!r}])
"""
    main(["simulate", "crazyflie", "circle", "--seconds", "2", "--out", str(tmp_path / "flight.csv")])
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert done.stderr == b"True"


@pytest.mark.slow
@pytest.mark.parametrize("streams", ["reader gone", "closed"])
def test_a_reader_that_has_gone_loses_nothing_else(streams: str, model: Path, tmp_path: Path) -> None:
    result = tmp_path / "result.json"
    here, there = os.pipe()
    os.close(here)
    command = f"{sys.executable} -m sym2real show {model} --json {result}" + (" >&-" if streams == "closed" else "")
    done = subprocess.run(["sh", "-c", command], stdout=there, stderr=subprocess.PIPE, check=False)
    os.close(there)
    assert (done.returncode, done.stderr) == (0, b"")
    assert json.loads(result.read_text())["equations"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a stream that takes nothing, /dev/full")
def test_a_stream_that_takes_nothing_is_one_line(model: Path, tmp_path: Path) -> None:
    with Path("/dev/full").open("wb") as full:
        command = [sys.executable, "-m", "sym2real", "show", str(model)]
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, check=False)
    assert done.returncode == 2
    assert done.stderr.decode().count("\n") == 1
    assert os.strerror(errno.ENOSPC) in done.stderr.decode()


@pytest.mark.skipif(sys.platform == "win32", reason="files are limited by POSIX means")
@pytest.mark.parametrize(
    "command",
    [
        "add {model} added_mass value=0.005 --out new",
        "export {model} torchscript --out new.pt",
        "export {model} torch-export --out new.pt2",
        "export {model} python --out new.py",
        "nominal car --wheelbase 0.3 --out new/deep",
        "simulate crazyflie hover --seconds 2 --out new/log.csv",
        "simulate crazyflie hover --seconds 2 --out new/log.parquet",
        "compare {model} {flight} --report new.html",
        "inspect {flight} --out new.toml",
    ],
)
def test_a_full_disk_is_one_line_and_leaves_nothing(command: str, model: Path, tmp_path: Path) -> None:
    flight = model.parent / "short.csv"
    if not flight.exists():
        main(["simulate", "crazyflie", "circle", "--seconds", "2", "--out", str(flight)])
    done = forked(command.format(model=model, flight=flight).split(), tmp_path, most_bytes=100)
    assert done.status == 2, done.err
    assert done.err.count("\n") == 1
    assert "expected a file that can be written, found File too large" in done.err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("failure", [ZeroDivisionError("no such thing"), MemoryError(), RecursionError("too\ndeep")])
def test_what_nobody_foresaw_is_one_line(
    failure: Exception, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(self: Show, console: object) -> None:
        raise failure

    monkeypatch.setattr(Show, "run", fail)
    with pytest.raises(type(failure)):
        main(["show", "a model"])
    monkeypatch.setenv(TRACEBACK, "")
    with pytest.raises(SystemExit) as stopped:
        main(["show", "a model"])
    assert stopped.value.code == 70
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith(f"error: {type(failure).__name__}")
    assert printed.err.count("\n") == 1
    assert "please report it" in printed.err


def test_a_file_does_not_speak_to_the_terminal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A note that would clear the screen and change the window's title is shown without its control characters."""
    notes = ("\x1b]0;mine\x07\x1b[2J\x9b1mhere\rgone",)
    saved = save_model(replace(CRAZYFLIE.nominal(), notes=notes), tmp_path / "model")
    main(["show", str(saved)])
    printed = capsys.readouterr()
    assert "\N{REPLACEMENT CHARACTER}]0;mine" in printed.out
    assert not {"\x1b", "\x07", "\x9b", "\r"} & set(printed.out + printed.err)
