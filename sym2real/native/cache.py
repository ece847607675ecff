"""Compiled libraries by the hash of what they are made of: text, compiler, flags, processor.

A file appears under its name whole or not at all (compiled beside it, then renamed), so a killed compiler leaves
nothing that could be mistaken for a library. Behind every library stands the checksum of its content, which the system
ignores when it opens one: opening a file that was cut short afterwards would kill the process. The folder and its
files are the user's alone (:mod:`sym2real.native.private`): a library runs when it is opened. A lock keeps two
processes from doing the same work; the operating system frees it when its holder dies. Whoever compiles removes what
was asked for longest ago, beyond :data:`MOST` libraries. Where the cache cannot be written (read-only or full disk) or
others may write to it, a temporary folder of this process takes its place, which is said once.
"""

import atexit
import ctypes
import hashlib
import logging
import os
import shutil
import tempfile
import time
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from filelock import FileLock
from platformdirs import user_cache_path

from sym2real.errors import CompilationError, reason
from sym2real.native.compiler import Compiler, find_compiler
from sym2real.native.private import is_own, private_folder

LOGGER = logging.getLogger(__name__)
WAIT = 180.0  # s, for another process that compiles the same text
MOST = 200  # libraries, of about 50 kB each


def library(text: str) -> ctypes.CDLL:
    """The library of a C text, compiled where it is not in the cache.

    Raises:
        CompilationError: when there is no compiler, it fails, or there is nowhere to put its output.
    """
    compiler = find_compiler()
    if compiler is None:
        raise CompilationError("there is no C compiler here (install gcc or clang, or name one by CC)")
    name = name_of(text, compiler)
    loaded = _loaded.get(name)
    if loaded is None:
        loaded = _loaded[name] = _load(compiler, text, name)
    return loaded


_loaded: dict[str, ctypes.CDLL] = {}


def name_of(text: str, compiler: Compiler) -> str:
    """File name of the library of a text."""
    return hashlib.sha256(f"{compiler.identity}\n{text}".encode()).hexdigest()[:32] + ".so"


def cache_folder() -> Path:
    """Where libraries are kept between processes."""
    return user_cache_path("sym2real") / "kernels"


@lru_cache(maxsize=1)
def _own_folder() -> Path:
    folder = Path(tempfile.mkdtemp(prefix="sym2real-kernels-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def _load(compiler: Compiler, text: str, name: str) -> ctypes.CDLL:
    try:
        target = private_folder(cache_folder()) / name
        opened = _opened(target)
        if opened is None:
            with FileLock(target.with_suffix(".lock"), timeout=WAIT):
                opened = _opened(target)
                if opened is None:
                    build(compiler, text, target)
                    prune(target.parent)
                    opened = ctypes.CDLL(str(target))
        return opened
    except OSError as refused:  # also FileLock's time-out, or a file that somebody removed in between
        if not _own_folder.cache_info().currsize:
            warning = "the cache %s cannot be used: %s; kernels are compiled anew in every process"
            LOGGER.warning(warning, cache_folder(), refused.strerror or reason(refused))
        try:
            target = _own_folder() / name
            build(compiler, text, target)
            return ctypes.CDLL(str(target))
        except OSError as error:
            raise CompilationError(f"there is nowhere to put a compiled kernel: {error}") from error


def _opened(target: Path) -> ctypes.CDLL | None:
    """The library, asked for now; None where there is none, or what a crash of the machine left of one."""
    if not target.exists() or not is_own(target) or not _whole(target):
        return None
    with suppress(OSError):  # a file system that is only read
        os.utime(target)
    try:
        return ctypes.CDLL(str(target))
    except OSError:
        return None


def _checksum(content: bytes) -> bytes:
    return hashlib.sha256(content).digest()


def _whole(target: Path) -> bool:
    content = target.read_bytes()
    size = len(content) - hashlib.sha256().digest_size
    return size > 0 and content[size:] == _checksum(content[:size])


def prune(folder: Path) -> None:
    """Remove the libraries that were asked for longest ago, beyond :data:`MOST`, and what killed compilers left.

    Safe beside other processes: one that has a library open keeps it, one that is about to open it compiles it anew,
    and a file that somebody else removed first is gone as well.
    """
    libraries = sorted(folder.glob("*.so"), key=_last_asked_for, reverse=True)
    for library in libraries[MOST:]:
        library.unlink(missing_ok=True)
        library.with_suffix(".lock").unlink(missing_ok=True)  # at worst two compile the same, and rename
    for left in folder.glob(".compiling-*"):
        if time.time() - _last_asked_for(left) > 2 * WAIT:
            shutil.rmtree(left, ignore_errors=True)


def _last_asked_for(file: Path) -> float:
    try:
        return file.stat().st_mtime
    except OSError:  # gone meanwhile
        return 0.0


def build(compiler: Compiler, text: str, target: Path) -> None:
    """Compile beside the target, with the checksum behind the library, and rename.

    Raises:
        OSError: when the folder cannot be written.
        CompilationError: when the compiler fails for another reason.
    """
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=".compiling-") as folder:
        source, made = Path(folder) / "kernel.c", Path(folder) / target.name
        source.write_text(text, encoding="utf-8")
        try:
            compiler.compile(source, made)
        except CompilationError as error:
            if "No space left" in str(error) or "Read-only" in str(error):
                raise OSError(str(error)) from error
            raise
        content = made.read_bytes()
        made.write_bytes(content + _checksum(content))
        made.chmod(0o600)
        made.replace(target)
