"""What the README shows runs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import tyro

from sym2real.cli import VERBS, Verb

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text()
PAGES = ("README.md", "docs/diagnosis.md", "docs/tutorial.md")


def test_the_python_of_the_readme_runs(capsys: pytest.CaptureFixture[str]) -> None:
    """The diagnosis of its drive names the one effect that is hidden there, and gives its value."""
    (code,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    names: dict[str, Any] = {}
    exec(compile(code, "README.md", "exec"), names)
    assert "<Comparison" in capsys.readouterr().out
    (finding,) = names["found"].findings
    plain, informed = (names[one].score(names["log"])["position"] for one in ("model", "informed"))
    assert informed > plain
    (hidden,) = re.findall(r"inject\(value=([\d.]+)\)", code)
    assert finding.effect == "offset:steer"
    assert finding.values["value"] == pytest.approx(float(hidden), rel=0.05)


def test_the_verbs_of_the_readme_exist() -> None:
    verbs = re.findall(r"^sym2real (\w+)", README, re.MULTILINE)
    assert len(verbs) >= 8
    assert set(verbs) <= set(VERBS)


@pytest.mark.parametrize("page", PAGES)
def test_every_command_of_the_docs_is_one(page: str) -> None:
    """Options and their order are right; nothing is run."""
    text = (ROOT / page).read_text()
    commands = re.findall(r"^sym2real (.*?)(?:\s+#.*)?$", text, re.MULTILINE)
    assert commands
    for command in commands:
        parsed: object = tyro.cli(Verb, args=command.split())
        assert parsed is not None


def test_the_readme_is_short_and_links_to_what_exists() -> None:
    assert len(README.splitlines()) <= 120
    assert "experiments" not in README
    links = re.findall(r"\]\(([^)#]+)", README)
    assert links
    assert [link for link in links if not (ROOT / link).exists()] == []
