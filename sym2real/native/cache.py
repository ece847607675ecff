"""Compiled libraries by the hash of their content: text, compiler, flags, processor.

A file appears under its name whole or not at all (compiled beside it, then renamed), so a killed compiler leaves
nothing that could be mistaken for a library. A lock keeps two processes from doing the same work; the operating system
frees it when its holder dies. Where the cache cannot be written (read-only or full disk), a temporary folder of this
process takes its place, which is said once.
"""

from __future__ import annotations

import atexit
import ctypes
import hashlib
import logging
import shutil
import tempfile
from functools import lru_cache
from pathlib import Path

from filelock import FileLock
from platformdirs import user_cache_path

from sym2real.errors import CompilationError
from sym2real.native.compiler import Compiler, find_compiler

LOGGER = logging.getLogger(__name__)
WAIT = 180.0  # s, for another process that compiles the same text


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


def cached(text: str) -> bool:
    """Whether :func:`library` would find this text compiled."""
    compiler = find_compiler()
    if compiler is None:
        return False
    name = name_of(text, compiler)
    return name in _loaded or (cache_folder() / name).exists()


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
    LOGGER.warning("the cache %s cannot be written; kernels are compiled anew in every process", cache_folder())
    return folder


def _load(compiler: Compiler, text: str, name: str) -> ctypes.CDLL:
    target = cache_folder() / name
    try:
        if not target.exists():
            target.parent.mkdir(parents=True, exist_ok=True)
            with FileLock(target.with_suffix(".lock"), timeout=WAIT):
                if not target.exists():
                    build(compiler, text, target)
        return ctypes.CDLL(str(target))
    except OSError:  # also of a file that another machine's loader wrote, or FileLock's time-out
        try:
            target = _own_folder() / name
            build(compiler, text, target)
            return ctypes.CDLL(str(target))
        except OSError as error:
            raise CompilationError(f"there is nowhere to put a compiled kernel: {error}") from error


def build(compiler: Compiler, text: str, target: Path) -> None:
    """Compile beside the target and rename.

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
        made.replace(target)
