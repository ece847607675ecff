"""The cache of compiled libraries: several processes, killed and missing compilers, disks that cannot be written."""

from __future__ import annotations

import logging
import os
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from forked import SECONDS

from sym2real.errors import CompilationError
from sym2real.native import cache, find_compiler, library
from sym2real.robots import MUSHR
from sym2real.symbolic import compile_model
from sym2real.tasks import make_task

TEXT = '__attribute__((visibility("default"))) int answer(void) {{ return {}; }}'
posix = pytest.mark.skipif(os.name != "posix", reason="POSIX signals and permissions")
compiled = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


@pytest.fixture
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(cache, "user_cache_path", lambda _: tmp_path)
    monkeypatch.setattr(cache, "_loaded", {})
    cache._own_folder.cache_clear()
    yield tmp_path / "kernels"
    cache._own_folder.cache_clear()


@compiled
def test_compiles_once_and_finds_it_again(own_cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert library(TEXT.format(42)).answer() == 42
    assert [file.suffix for file in own_cache.iterdir()].count(".so") == 1
    monkeypatch.setattr(cache, "_loaded", {})
    monkeypatch.setattr(cache, "build", lambda *_: pytest.fail("compiled again"))
    assert library(TEXT.format(42)).answer() == 42
    assert not list(own_cache.glob(".compiling-*"))


@compiled
def test_what_was_asked_for_longest_ago_goes_first(own_cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cache, "MOST", 3)
    names = []
    for number in range(5):
        opened = library(TEXT.format(number))
        names.append(cache.name_of(TEXT.format(number), find_compiler()))
        os.utime(own_cache / names[-1], (1e9 + number, 1e9 + number))
        if number == 2:  # the first one is asked for again
            monkeypatch.setattr(cache, "_loaded", {})
            assert library(TEXT.format(0)).answer() == 0
    assert {file.name for file in own_cache.glob("*.so")} == {names[0], names[3], names[4]}
    assert opened.answer() == 4
    monkeypatch.setattr(cache, "_loaded", {})
    assert library(TEXT.format(1)).answer() == 1  # compiled anew


@compiled
def test_processes_that_remove_each_others_libraries_all_get_theirs(tmp_path: Path) -> None:
    code = (
        "import sys; from sym2real.native import cache, library; cache.MOST = 1\n"
        "for n in range(int(sys.argv[1]), int(sys.argv[1]) + 6):\n"
        "    cache._loaded.clear()\n"
        "    assert library(sys.argv[2].format(n % 4)).answer() == n % 4"
    )
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path)}
    started = [subprocess.Popen([sys.executable, "-c", code, str(i), TEXT], env=environment) for i in range(3)]
    assert [process.wait(timeout=SECONDS) for process in started] == [0, 0, 0]
    assert len(list(tmp_path.rglob("*.so"))) <= 3


@compiled
def test_processes_at_once_share_one_library(tmp_path: Path) -> None:
    code = f"from sym2real.native import library; assert library('''{TEXT.format(7)}''').answer() == 7"
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path)}
    running = [subprocess.Popen([sys.executable, "-c", code], env=environment) for _ in range(4)]
    assert [process.wait(timeout=SECONDS) for process in running] == [0, 0, 0, 0]
    assert len(list(tmp_path.rglob("*.so"))) == 1


@posix
@compiled
def test_a_killed_compile_leaves_nothing_in_the_way(tmp_path: Path) -> None:
    slow = tmp_path / "cc"
    slow.write_text("#!/bin/sh\nexec sleep 600\n")
    slow.chmod(0o755)
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache"), "CC": str(slow)}
    code = f"from sym2real.native import library; library('''{TEXT.format(8)}''')"
    running = subprocess.Popen([sys.executable, "-c", code], env=environment, start_new_session=True)
    while not list(tmp_path.rglob(".compiling-*")):
        assert running.poll() is None
        time.sleep(0.05)
    os.killpg(running.pid, signal.SIGKILL)
    running.wait()
    assert not list(tmp_path.rglob("*.so"))
    environment["CC"] = shlex.join(find_compiler().command)
    check = f"from sym2real.native import library; assert library('''{TEXT.format(8)}''').answer() == 8"
    assert subprocess.run([sys.executable, "-c", check], env=environment, timeout=SECONDS, check=False).returncode == 0


@compiled
def test_a_cache_that_cannot_be_written_is_said_once(
    own_cache: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """As root, permissions stop nobody; a file in the folder's place stops everyone."""
    own_cache.parent.mkdir(exist_ok=True)
    own_cache.write_text("not a folder")
    with caplog.at_level(logging.WARNING):
        assert library(TEXT.format(1)).answer() == 1
        assert library(TEXT.format(2)).answer() == 2
    assert caplog.text.count("cannot be used: ") == 1


@posix
@compiled
def test_a_full_disk_falls_back_too(own_cache: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    real = cache.build

    def full(compiler: object, text: str, target: Path) -> None:
        if target.parent == own_cache:
            raise OSError(28, "No space left on device")
        real(compiler, text, target)

    monkeypatch.setattr(cache, "build", full)
    assert library(TEXT.format(3)).answer() == 3
    monkeypatch.setattr(cache, "build", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(CompilationError, match="nowhere to put"):
        library(TEXT.format(4))


@compiled
def test_a_broken_file_in_the_cache_is_mended_there(own_cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine that loses its power may leave a name without a content."""
    own_cache.mkdir(parents=True)
    (own_cache / cache.name_of(TEXT.format(5), find_compiler())).write_bytes(b"no library")
    assert library(TEXT.format(5)).answer() == 5
    monkeypatch.setattr(cache, "_loaded", {})
    monkeypatch.setattr(cache, "build", lambda *_: pytest.fail("compiled again"))
    assert library(TEXT.format(5)).answer() == 5


@compiled
@pytest.mark.parametrize("damage", ["cut short", "emptied", "overwritten"])
def test_a_library_that_was_damaged_later_is_compiled_anew(tmp_path: Path, damage: str) -> None:
    """Of a file that is shorter than its own header says, the loader maps what is not there: SIGBUS ends a process."""
    code = f"from sym2real.native import library; assert library('''{TEXT.format(10)}''').answer() == 10"
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path)}
    for _ in range(2):
        assert (
            subprocess.run([sys.executable, "-c", code], env=environment, timeout=SECONDS, check=False).returncode == 0
        )
        (kept,) = tmp_path.rglob("*.so")
        whole = kept.read_bytes()
        left = {"cut short": whole[:5000], "emptied": b"", "overwritten": whole[:4096] + bytes(len(whole) - 4096)}
        kept.write_bytes(left[damage])


@compiled
def test_a_compiler_that_takes_too_long_is_an_error_in_a_sentence(
    own_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sym2real.native.compiler.SECONDS", 1e-6)
    with pytest.raises(CompilationError, match=r"^\S+ needs more than 1e-06 s for it$"):
        library("int takes_too_long;")


def test_text_that_does_not_compile_is_an_error_with_the_compilers_words(own_cache: Path) -> None:
    with pytest.raises(CompilationError, match="expected"):
        library("int answer(void { return 1; }")


@posix
@compiled
@pytest.mark.parametrize("folder", ["bin", "my programs"])
def test_a_compiler_may_be_named_with_its_wrapper_and_options(
    own_cache: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, folder: str
) -> None:
    """As in ``CC="ccache gcc"``; the wrapper notes what it runs, other options are another compiler."""
    plain, wrapper, noted = find_compiler(), tmp_path / folder / "wrap", tmp_path / "noted"
    wrapper.parent.mkdir()
    wrapper.write_text(f'#!/bin/sh\necho "$@" > {noted}\nexec "$@"\n')
    wrapper.chmod(0o755)
    named = Path(plain.command[0]).name  # found on the path, as a user writes it
    monkeypatch.setenv("CC", f"'{wrapper}' {named} -DWORTH=11")
    assert library(TEXT.format("WORTH")).answer() == 11
    assert noted.read_text().startswith(f"{plain.command[0]} -DWORTH=11 ")
    found = find_compiler()
    assert found.flags == plain.flags
    monkeypatch.setenv("CC", f"'{wrapper}' {named} -DWORTH=12")
    assert find_compiler().identity != found.identity
    monkeypatch.setenv("CC", str(wrapper))  # one word with a space in it, if so
    assert find_compiler().command == (str(wrapper),)


def test_without_a_compiler_torch_plans_with_as_many_samples_as_the_period_holds(
    own_cache: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    from sym2real.control import MPPI

    for named in ("gcc '", " ", "/nonexistent/cc"):
        monkeypatch.setenv("CC", named)
        assert find_compiler() is None
    with pytest.raises(CompilationError, match="no C compiler"):
        library(TEXT.format(6))
    with caplog.at_level(logging.INFO):
        mppi = MPPI(compile_model(MUSHR.nominal()), MUSHR, make_task("circle", MUSHR))
    assert mppi.backend == "torch"
    assert "no C compiler" in caplog.text
    assert 16 <= mppi.samples <= 1024
    assert mppi.act(MUSHR.start, 0).shape == (2,)
