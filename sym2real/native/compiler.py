"""The system's C compiler, and what a compiled file depends on."""

import os
import platform
import shlex
import shutil
import subprocess
from collections.abc import Sequence
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
# For x86 GCC leaves the order of a long text as it stands, and so each operation waiting for the one before.
SCHEDULED = ("-fschedule-insns", "-fsched-pressure")
ONLY_GCC = ("-mprefer-vector-width=512", *SCHEDULED)
# Bytes beyond which it does not: an arm of seven joints has 1.5 MB, and takes a minute more; one of six half a second.
LONG = 500_000
SECONDS = 120.0


@dataclass(frozen=True)
class Compiler:
    """A compiler found on this machine.

    Args:
        command: path of the program; with a wrapper such as ccache, the wrapper's and then the compiler's.
        flags: what it is called with.
        identity: changes whenever its output might: programs, flags, processor.
    """

    command: tuple[str, ...]
    flags: tuple[str, ...]
    identity: str

    def compile(self, source: Path, target: Path) -> None:
        """Make a shared library.

        Raises:
            CompilationError: when the compiler fails, or takes minutes.
        """
        left_out = SCHEDULED if source.stat().st_size > LONG else ()
        flags = [flag for flag in self.flags if flag not in left_out]
        command = [*self.command, *flags, str(source), "-o", str(target), "-lm"]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
        except subprocess.TimeoutExpired:
            raise CompilationError(f"{shlex.join(self.command)} needs more than {SECONDS:g} s for it") from None
        except OSError as error:
            raise CompilationError(f"{shlex.join(self.command)} did not run: {error}") from error
        if done.returncode != 0:
            message = done.stderr.strip()[-2000:] or done.returncode
            raise CompilationError(f"{shlex.join(self.command)} failed: {message}")


def find_compiler() -> Compiler | None:
    """The compiler that ``CC`` names, a wrapper and options included, else the system's; None where there is none."""
    return _located(os.environ.get("CC", ""), os.environ.get("PATH", ""))


@lru_cache(maxsize=8)
def _located(named: str, path: str) -> Compiler | None:
    for name in (named,) if named else CANDIDATES:
        try:
            words = [name] if shutil.which(name, path=path) else shlex.split(name)  # a path may have spaces
        except ValueError:  # a quotation without its end
            continue
        programs = [shutil.which(word, path=path) for word in words]
        if programs and programs[0]:
            command = tuple(program or word for program, word in zip(programs, words, strict=True))
            flags = (*COMMON, *_for_this_processor(command))
            versions = [_version(program) for program in programs if program]
            return Compiler(command, flags, "\n".join([*versions, *command[1:], *flags, processor()]))
    return None


def _for_this_processor(command: Sequence[str]) -> tuple[str, ...]:
    native = ("-mcpu=native",) if platform.machine() in ("aarch64", "arm64") else ("-march=native",)
    clang = any("clang" in Path(word).resolve().name for word in command)
    x86 = platform.machine() in ("x86_64", "AMD64")
    return (*native, *(ONLY_GCC if x86 and not clang else ()))


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
