"""A verb says that it has begun before it loads what takes seconds, and help loads none of that."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from forked import forked

from sym2real.cli import VERBS

pty = pytest.importorskip("pty", reason="a terminal is made with pty")


def test_help_of_no_verb_loads_torch() -> None:
    code = f"""
import sys
from sym2real.cli import main
for verb in {tuple(VERBS)!r}:
    try:
        main([verb, "--help"])
    except SystemExit:
        pass
print([name for name in ("torch", "sympy", "numpy", "mujoco") if name in sys.modules], file=sys.stderr)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.count("usage:") == len(VERBS)
    assert done.stderr.strip() == "[]"


@pytest.mark.slow
def test_a_terminal_is_told_before_the_libraries_are_loaded() -> None:
    """Standard error is a terminal, and so is standard output: the line comes before torch, the catalogue after it."""
    code = """
import sys
from sym2real.cli import main
class Watch:
    def find_spec(self, name, path=None, target=None):
        if name == "torch":
            sys.stderr.write("<torch>")
            sys.stderr.flush()
sys.meta_path.insert(0, Watch())
main(["effects", "wind"])
"""
    here, there = pty.openpty()
    with subprocess.Popen([sys.executable, "-c", code], stdout=there, stderr=there, env=_environment()) as running:
        os.close(there)
        said = _all_of(here)
    assert running.returncode == 0
    begun, torch, catalogue = (said.index(text) for text in ("effects: loading", "<torch>", "wind"))
    assert begun < torch < catalogue


def test_without_a_terminal_nothing_is_added(tmp_path: Path) -> None:
    ran = forked(["effects", "wind", "--json", "-"], tmp_path)
    assert ran.status == 0
    assert "loading" not in ran.err
    assert ran.out.startswith("{")


def _environment() -> dict[str, str]:
    return {name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "FORCE_COLOR")} | {
        "TERM": "xterm"
    }


def _all_of(terminal: int) -> str:
    said = b""
    try:
        while part := os.read(terminal, 4096):
            said += part
    except OSError:  # Linux's way to say that the other end is closed
        pass
    return said.decode()
