"""Fixtures that several test files share."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

os.environ.setdefault("SYM2REAL_TRACEBACK", "1")  # an error that nobody foresaw is to fail a test with its traceback
BESIDE_THE_CHECKOUT = Path(__file__).resolve().parents[2] / "shared" / "data"


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder with the four measured sets: ``SYM2REAL_DATA``, else ``../shared/data`` beside the checkout."""
    folder = Path(os.environ.get("SYM2REAL_DATA", BESIDE_THE_CHECKOUT))
    if not folder.is_dir():
        pytest.skip(f"the measured sets are not here ({folder}); set SYM2REAL_DATA to their folder")
    return folder
