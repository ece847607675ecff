"""Makes or reuses ``.venv`` with the project installed; needs nothing but Python ≥ 3.11.

python3 tools/environment.py test docs      # with these extras
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ENVIRONMENT = ROOT / ".venv"
CONSTRAINTS = ROOT / "tools" / "constraints.txt"
OLDEST = (3, 11)
USED = ("sym2real.cli", "sym2real.control", "sym2real.diagnosis", "sym2real.logs", "sym2real.report")


def python_with(extra: str) -> Path:
    """Path of a Python in ``.venv`` that has the project, editable, with extras ("" for none, several with commas).

    Installation is skipped when it was done before for the same setup.cfg and constraints.
    """
    if sys.version_info < OLDEST:
        sys.exit(
            f"sym2real needs Python ≥ 3.11, this is {sys.version.split()[0]}: run this script with a newer python3"
        )
    python = ENVIRONMENT / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    if not python.exists():
        print(f"making {ENVIRONMENT.name}", flush=True)
        venv.create(ENVIRONMENT, with_pip=True)
    stamp = ENVIRONMENT / f"installed-{extra or 'plain'}"
    wanted = _fingerprint()
    if not stamp.exists() or stamp.read_text() != wanted:
        _install(python, extra)
        stamp.write_text(wanted)
    return python


def _fingerprint() -> str:
    content = (ROOT / "setup.cfg").read_bytes() + CONSTRAINTS.read_bytes() + str(ROOT).encode()
    return hashlib.sha256(content).hexdigest()


def _install(python: Path, extra: str) -> None:
    print("installing sym2real and what it needs; the first time takes a few minutes", flush=True)
    target = f"{ROOT}[{extra}]" if extra else str(ROOT)
    # Python compiles what it imports; pip would compile all that torch and SymPy have.
    quiet = ["--quiet", "--no-compile", "--constraint", str(CONSTRAINTS)]
    command = [str(python), "-m", "pip", "install", *quiet, "--editable", target]
    if subprocess.run(command, check=False).returncode != 0:
        sys.exit("installation failed; pip's message above says why")
    # Where machines keep no bytecode, every command would compile for five seconds what it imports.
    kept = {**os.environ, "PYTHONDONTWRITEBYTECODE": ""}
    subprocess.run([str(python), "-c", f"import {', '.join(USED)}"], env=kept, cwd=ROOT, check=True)


if __name__ == "__main__":
    python_with(",".join(sys.argv[1:]))
