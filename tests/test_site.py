"""The docs site: its tutorials run, its made pages hold what they are made of, and it builds without a warning."""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

from sym2real import EFFECTS

ROOT = Path(__file__).resolve().parent.parent
TUTORIALS = sorted((ROOT / "docs" / "tutorials").glob("*.py"))
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "NO_MKDOCS_2_WARNING": "1"}


@pytest.fixture(scope="module")
def site() -> ModuleType:
    spec = importlib.util.spec_from_file_location("site_pages", ROOT / "docs" / "site.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("script", TUTORIALS, ids=lambda script: script.stem)
def test_a_tutorial_runs(script: Path, tmp_path: Path) -> None:
    """In an empty folder, as a user starts it; what it promises it asserts itself."""
    assert "\nassert " in script.read_text() or script.stem == "08_own_engine"
    command = [sys.executable, str(script), "--short"]
    run = subprocess.run(command, cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr[-2000:]
    assert run.stdout.strip()


@pytest.mark.parametrize("script", TUTORIALS, ids=lambda script: script.stem)
def test_a_page_of_a_tutorial_holds_all_of_its_code(script: Path, site: ModuleType) -> None:
    page = site.tutorial(script.read_text())
    assert page.startswith("# ")
    shown = "\n".join(re.findall(r"```python\n(.*?)\n```", page, re.DOTALL))
    code = script.read_text().split('"""', 2)[2]
    wanted = [line for line in code.splitlines() if line.strip() and not line.startswith("#")]
    assert [line for line in shown.splitlines() if line.strip() and not line.startswith("#")] == wanted


def test_the_catalogue_has_every_effect(site: ModuleType) -> None:
    page = site.catalogue()
    sections = {part.split("\n", 1)[0]: part for part in page.split("\n## ")[1:]}
    assert sections.keys() == EFFECTS.keys()
    for name, kind in EFFECTS.items():
        for text in (kind.summary, kind.formula, kind.confused_with, kind.shown_by, kind.fix):
            assert text in sections[name]
    assert "| `cx` | N s/m |" in sections["linear_drag"]


def test_errors_that_are_explained_are_those_of_the_code() -> None:
    page = (ROOT / "docs" / "errors.md").read_text()
    quoted = re.findall(r"^\| `([^`]+)` \| [a-z]", page.split("it says")[1], re.MULTILINE)
    assert len(quoted) >= 8
    code = "".join(path.read_text() for path in (ROOT / "sym2real").rglob("*.py"))
    assert [text for text in quoted if text not in code] == []
    classes = re.findall(r"^\| `(\w+Error)`", page, re.MULTILINE)
    assert set(classes) == set(re.findall(r"^class (\w+)\(Sym2RealError", code, re.MULTILINE))


def test_the_site_builds_without_a_warning(tmp_path: Path) -> None:
    pytest.importorskip("mkdocs", reason="the site needs the extra docs")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(tmp_path / "site")]
    run = subprocess.run(command, cwd=ROOT, env=ENVIRONMENT, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr[-2000:]
    pages = {path.parent.name for path in (tmp_path / "site").rglob("index.html")}
    assert {"effects", "reference", "02_hidden_effect", "errors"} <= pages
    assert "sym2real.Equations.simulate" in (tmp_path / "site" / "reference" / "index.html").read_text()
