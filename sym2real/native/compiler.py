"""The system's C compiler, and what a compiled file depends on."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from sym2real.errors import CompilationError

CANDIDATES = ("cc", "gcc", "clang")
# -ffast-math would let the compiler assume that no number is NaN; these are its harmless parts.
COMMON = (
    "-std=gnu11", "-O2", "-shared", "-fPIC", "-fvisibility=hidden", "-w",
    "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math",
)  # fmt: skip
# The text is in a good order already, and a vector of 512 bits is what it asks for. Without the last flag the stack is
# addressed from a pointer that no vector is aligned with, and every such instruction is two bytes longer. Equal parts
# are one value already: with -O3, looking for them is a third of the compiler's time, and gains 2 %.
ONLY_GCC = (
    "-fno-tree-ter", "-mprefer-vector-width=512", "-maccumulate-outgoing-args",
    "-fno-tree-pta", "-fno-tree-pre", "-fno-gcse", "-fno-rerun-cse-after-loop",
)  # fmt: skip
SECONDS = 120.0


@dataclass(frozen=True)
class Compiler:
    """A compiler found on this machine.

    Args:
        path: of the program.
        flags: what it is called with.
        identity: changes whenever its output might: program, flags, processor.
    """

    path: str
    flags: tuple[str, ...]
    identity: str

    def compile(self, source: Path, target: Path) -> None:
        """Make a shared library.

        Raises:
            CompilationError: when the compiler fails, or takes minutes.
        """
        command = [self.path, *self.flags, str(source), "-o", str(target), "-lm"]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise CompilationError(f"{self.path} did not run: {error}") from error
        if done.returncode != 0:
            raise CompilationError(f"{self.path} failed: {done.stderr.strip()[-2000:] or done.returncode}")


def find_compiler() -> Compiler | None:
    """The compiler that ``CC`` names, else the system's; None where there is none."""
    return _found(os.environ.get("CC", ""), os.environ.get("PATH", ""))


@lru_cache(maxsize=8)
def _found(named: str, path: str) -> Compiler | None:
    for name in (named,) if named else CANDIDATES:
        program = shutil.which(name, path=path)
        if program:
            flags = (*COMMON, *_for_this_processor(program))
            return Compiler(program, flags, "\n".join([_version(program), *flags, processor()]))
    return None


def _for_this_processor(program: str) -> tuple[str, ...]:
    native = ("-mcpu=native",) if platform.machine() in ("aarch64", "arm64") else ("-march=native",)
    real = Path(program).resolve().name
    x86 = platform.machine() in ("x86_64", "AMD64")
    return (*native, *(ONLY_GCC if x86 and "clang" not in real else ()))


def _version(program: str) -> str:
    """Name, size and date of the program: asking for its version would take a tenth of the compilation."""
    real = Path(program).resolve()
    about = real.stat()
    return f"{real} {about.st_size} {about.st_mtime_ns}"


@lru_cache(maxsize=1)
def processor() -> str:
    """Model and instruction sets of this processor; caches in a shared home must not mix them."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").split("\n\n", maxsplit=1)[0].splitlines()
    except OSError:
        return f"{platform.machine()} {platform.processor()}"
    return "\n".join(line for line in lines if line.split("\t")[0] in ("model name", "flags", "Features", "CPU part"))
