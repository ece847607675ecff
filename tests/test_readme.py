"""What the README shows runs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from sym2real.cli import VERBS

README = (Path(__file__).resolve().parent.parent / "README.md").read_text()


def test_the_python_of_the_readme_runs(capsys: pytest.CaptureFixture[str]) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    exec(compile(code, "README.md", "exec"), {})
    assert "ChannelError" in capsys.readouterr().out


def test_the_verbs_of_the_readme_exist() -> None:
    verbs = re.findall(r"^sym2real (\w+)", README, re.MULTILINE)
    assert len(verbs) >= 8
    assert set(verbs) <= set(VERBS)
