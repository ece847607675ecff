"""What a run was flown or driven with: the model's hash, the link, the revision of the code."""

import hashlib
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import sym2real
from hardware.interfaces import RobotLink


def about_run(task: str, model: str, link: RobotLink, settings: Mapping[str, Any]) -> dict[str, Any]:
    """What a record says of its run, besides how it ended.

    Args:
        task: its name.
        model: as the user names it.
        link: connected.
        settings: of the pilot.
    """
    from sym2real.cli.model import folder_of  # noqa: PLC0415 — SymPy takes a second to load

    known = {"task": task, "model": model, "model_sha256": hash_of(folder_of(model)), "revision": revision()}
    return known | {**link.about, **settings}


def hash_of(folder: Path) -> str:
    """SHA-256 of the names and contents of a folder's files (those of earlier rounds are left out)."""
    files = sorted(file for file in folder.iterdir() if file.is_file())
    together = hashlib.sha256()
    for file in files:
        together.update(file.name.encode() + b"\0" + hashlib.sha256(file.read_bytes()).digest())
    return together.hexdigest()


def revision() -> str:
    """The git revision of this code, with "+" where files have been changed since; the version outside a checkout."""
    folder = Path(__file__).resolve().parent.parent
    try:
        asked = ["git", "-C", str(folder), "describe", "--always", "--dirty=+", "--abbrev=12"]
        told = subprocess.run(asked, capture_output=True, text=True, check=True, timeout=10.0)
    except (OSError, subprocess.SubprocessError):
        return f"sym2real {sym2real.__version__}"
    return told.stdout.strip()
