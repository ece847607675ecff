"""The cache of compiled libraries is its user's alone: what others have planted there does not run."""

from __future__ import annotations

import logging
import os
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest

from sym2real.native import cache, find_compiler, library
from sym2real.native.private import private_folder

TEXT = '__attribute__((visibility("default"))) int answer(void) {{ return {}; }}'
PLANTED = """
#include <fcntl.h>
#include <unistd.h>
__attribute__((constructor)) static void run(void) {{ close(open("{}", O_CREAT, 0600)); }}
__attribute__((visibility("default"))) int answer(void) {{ return -1; }}
"""
SOMEBODY_ELSE = 65534

pytestmark = [
    pytest.mark.skipif(os.name != "posix", reason="owners and modes as POSIX has them"),
    pytest.mark.skipif(find_compiler() is None, reason="no C compiler"),
]
two_users = pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can give a file to another user"
)


@pytest.fixture
def kernels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setattr(cache, "user_cache_path", lambda _: tmp_path / "sym2real")
    monkeypatch.setattr(cache, "_loaded", {})
    cache._own_folder.cache_clear()
    before = os.umask(0o022)
    yield tmp_path / "sym2real" / "kernels"
    os.umask(before)
    cache._own_folder.cache_clear()


def planted(folder: Path, text: str, ran: Path) -> Path:
    """A library under the name of another one's text, with its checksum right; it leaves a file when it is opened."""
    compiler = find_compiler()
    assert compiler is not None
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / cache.name_of(text, compiler)
    cache.build(compiler, PLANTED.format(ran), target)
    return target


def mode(place: Path) -> int:
    return stat.S_IMODE(place.stat().st_mode)


@pytest.mark.parametrize("mask", [0o000, 0o002, 0o022, 0o077])
def test_the_cache_is_for_its_user_alone_whatever_the_umask(kernels: Path, mask: int) -> None:
    os.umask(mask)
    assert library(TEXT.format(1)).answer() == 1
    assert mode(kernels) == mode(kernels.parent) == 0o700
    assert not [file for file in kernels.glob("*.so") if mode(file) & 0o077]


def test_a_cache_of_an_earlier_version_is_closed_and_kept(
    kernels: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert library(TEXT.format(2)).answer() == 2
    kernels.chmod(0o755)
    monkeypatch.setattr(cache, "_loaded", {})
    monkeypatch.setattr(cache, "build", lambda *_: pytest.fail("compiled again"))
    assert library(TEXT.format(2)).answer() == 2
    assert mode(kernels) == 0o700


def test_a_planted_library_runs_where_it_is_the_users_own(kernels: Path, tmp_path: Path) -> None:
    """So that the tests below show something: the trap works."""
    planted(kernels, TEXT.format(3), tmp_path / "ran")
    assert library(TEXT.format(3)).answer() == -1
    assert (tmp_path / "ran").exists()


@pytest.mark.parametrize("trap", [pytest.param("another user's", marks=two_users), "writable by others", "a link"])
@pytest.mark.parametrize("folder_mode", [0o700, 0o777, 0o1777])
def test_a_library_that_others_can_have_planted_does_not_run(
    kernels: Path, tmp_path: Path, trap: str, folder_mode: int
) -> None:
    target = planted(kernels, TEXT.format(4), tmp_path / "ran")
    match trap:
        case "another user's":
            os.chown(target, SOMEBODY_ELSE, SOMEBODY_ELSE)
        case "writable by others":
            target.chmod(0o666)
        case "a link":
            target.rename(tmp_path / "elsewhere.so")
            target.symlink_to(tmp_path / "elsewhere.so")
    kernels.chmod(folder_mode)
    assert library(TEXT.format(4)).answer() == 4
    assert not (tmp_path / "ran").exists()
    assert mode(kernels) == 0o700
    assert target.lstat().st_uid == os.geteuid()
    assert not target.is_symlink()


@two_users
def test_a_folder_of_another_user_is_not_used_and_that_is_said_once(
    kernels: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    planted(kernels, TEXT.format(5), tmp_path / "ran")
    os.chown(kernels, SOMEBODY_ELSE, SOMEBODY_ELSE)
    before = sorted(kernels.iterdir())
    with caplog.at_level(logging.WARNING):
        assert library(TEXT.format(5)).answer() == 5
        assert library(TEXT.format(6)).answer() == 6
    assert not (tmp_path / "ran").exists()
    assert sorted(kernels.iterdir()) == before
    assert caplog.text.count(f"belongs to user {SOMEBODY_ELSE}") == 1
    assert mode(cache._own_folder()) == 0o700


@pytest.mark.parametrize("by_link", [False, True])
def test_a_folder_that_others_can_exchange_is_not_used(
    kernels: Path, tmp_path: Path, by_link: bool, caplog: pytest.LogCaptureFixture
) -> None:
    """Their own stands where this user's was, as soon as they have renamed the one above it."""
    shared = tmp_path / "shared" if by_link else kernels.parent.parent
    planted(shared / "kernels" if by_link else kernels, TEXT.format(7), tmp_path / "ran")
    if by_link:
        kernels.parent.mkdir()
        kernels.symlink_to(shared / "kernels")
    shared.chmod(0o777)
    with caplog.at_level(logging.WARNING):
        assert library(TEXT.format(7)).answer() == 7
    shared.chmod(0o755)
    assert not (tmp_path / "ran").exists()
    assert f"others may write to {shared}" in caplog.text


def test_a_private_folder_behind_a_link_is_as_good(kernels: Path, tmp_path: Path) -> None:
    (tmp_path / "disk").mkdir()
    kernels.parent.mkdir(parents=True)
    kernels.symlink_to(tmp_path / "disk")
    assert library(TEXT.format(8)).answer() == 8
    assert list((tmp_path / "disk").glob("*.so"))
    assert mode(tmp_path / "disk") == 0o700


def test_a_planted_lock_empties_no_file(kernels: Path, tmp_path: Path) -> None:
    """A lock is opened for writing, through whatever link has its name."""
    (tmp_path / "precious").write_text("kept")
    compiler = find_compiler()
    assert compiler is not None
    kernels.mkdir(parents=True)
    kernels.chmod(0o777)
    (kernels / cache.name_of(TEXT.format(9), compiler)).with_suffix(".lock").symlink_to(tmp_path / "precious")
    assert library(TEXT.format(9)).answer() == 9
    assert (tmp_path / "precious").read_text() == "kept"


def test_a_link_to_nowhere_and_a_file_are_refused(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    (tmp_path / "file").touch()
    for name in ("link", "file", "file/below"):
        with pytest.raises(OSError, match=r".+"):
            private_folder(tmp_path / name)
