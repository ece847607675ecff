"""What the README shows runs."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path
from typing import Any

import pytest
import tyro
from forked import in_fork

from sym2real.cli import VERBS, main, verbs
from sym2real.data import example_flight

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text()
PAGES = [
    str(page.relative_to(ROOT))
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
    if re.search(r"^sym2real ", page.read_text(), re.MULTILINE)
]


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


def test_the_commands_of_the_readme_say_what_it_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """But for the last digits, which are a machine's."""
    commands, shown = re.findall(r"better model\n\n```\n(.*?)```\n\n```\n(.*?) …\n```", README, re.DOTALL)[0]
    shutil.copy(example_flight(), tmp_path / "flight.csv")
    monkeypatch.chdir(tmp_path)
    for command in re.findall(r"^sym2real (.*?)(?:\s+#.*)?$", commands, re.MULTILINE):
        if not command.startswith("compare"):
            main(shlex.split(command))
    said, promised = (re.sub(r"[\d.]+|\s+", " ", text) for text in (capsys.readouterr().out, shown))
    assert promised in said


def test_the_python_of_a_new_robot_prints_what_its_comments_say(tmp_path: Path) -> None:
    for file in (ROOT / "sym2real" / "robots").glob("*.xml"):
        shutil.copy(file, tmp_path)
    code = "\n".join(re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "new_robot.md").read_text(), re.DOTALL))
    ran = in_fork(lambda: exec(compile(code, "new_robot.md", "exec"), {}), tmp_path)
    assert ran.status == 0, ran.err
    promised = re.findall(r"^print\(.*\)  # (.*)$", code, re.MULTILINE)
    assert len(promised) >= 3
    for line, words in zip(ran.out.splitlines(), promised, strict=True):
        if line.startswith("("):
            assert line == words
        else:
            assert float(line) == pytest.approx(float(words.split()[0]), rel=1e-3)


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
        parsed: object = tyro.cli(verbs(), args=shlex.split(command))
        assert parsed is not None


def test_the_readme_is_short_and_links_to_what_exists() -> None:
    assert len(README.splitlines()) <= 120
    assert "experiments" not in README
    links = re.findall(r"\]\(([^)#]+)", README)
    assert links
    assert [link for link in links if not (ROOT / link).exists()] == []
