"""The docs site: its tutorials run, its made pages hold what they are made of, and it builds without a warning."""

from __future__ import annotations

import importlib
import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from xml.etree import ElementTree

import pytest
from forked import in_fork

import sym2real
from sym2real import EFFECTS

ROOT = Path(__file__).resolve().parent.parent
TUTORIALS = sorted((ROOT / "docs" / "tutorials").glob("*.py"))
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "NO_MKDOCS_2_WARNING": "1"}


@pytest.fixture(scope="module")
def loaded() -> None:
    """What tutorials import, before they run in forks of this process."""
    for name in ("sym2real.report.notebook", "sym2real.report.html.pages", *sym2real._OWNERS.values()):
        importlib.import_module(name)
    importlib.import_module("matplotlib.backends.backend_svg")


@pytest.fixture(scope="module")
def site() -> ModuleType:
    spec = importlib.util.spec_from_file_location("site_pages", ROOT / "docs" / "site.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
@pytest.mark.usefixtures("loaded")
@pytest.mark.parametrize("script", TUTORIALS, ids=lambda script: script.stem)
def test_a_tutorial_runs_and_its_page_shows_what_it_draws(script: Path, site: ModuleType) -> None:
    """In an empty folder; what it promises it asserts itself. The site is then built of what it left there."""
    source, folder = script.read_text(), site.RUN / script.stem
    assert "\nassert " in source
    ran = in_fork(lambda: site.executed.execute(script, folder, "--short"), ROOT, seconds=600)
    assert ran.status == 0, ran.err[-2000:]
    done = site.executed.current(script, folder)
    drawn = [name for part in done for name in part["drawn"]]
    assert {name for name in drawn if name.endswith(".svg")} == {path.name for path in folder.glob("*.svg")} != set()
    page = site.tutorial(source, done, script.stem)
    assert [name for name in drawn if f"]({script.stem}/{name})" not in page] == []
    assert all(part["printed"].strip() in page for part in done)
    assert_code_is_shown(page, source)


def assert_code_is_shown(page: str, source: str) -> None:
    """All of it, line by line."""
    shown = "\n".join(re.findall(r"```python\n(.*?)\n```", page, re.DOTALL))
    code = source.split('"""', 2)[2]
    wanted = [line for line in code.splitlines() if line.strip() and not line.startswith("#")]
    assert page.startswith("# ")
    assert [line for line in shown.splitlines() if line.strip() and not line.startswith("#")] == wanted


def test_a_tutorial_that_fails_is_named(tmp_path: Path, site: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "broken.py").write_text('"""# Broken"""\n\nprint("so far")\n\n# Next.\n\nassert 1 == 2\n')
    monkeypatch.setattr(site, "RUN", tmp_path / "run")
    with pytest.raises(RuntimeError, match=r"broken\.py does not run: (.|\n)*AssertionError"):
        site._executed(tmp_path / "broken.py")


def test_the_catalogue_has_every_effect(site: ModuleType) -> None:
    pytest.importorskip("latex2mathml", reason="the site needs the extra docs")
    page = site.catalogue()
    sections = {part.split("\n", 1)[0]: part for part in page.split("\n## ")[1:]}
    assert sections.keys() == EFFECTS.keys()
    for name, kind in EFFECTS.items():
        for text in (kind.summary, kind.confused_with, kind.shown_by, kind.fix):
            assert text in sections[name]
        (formula,) = re.findall(r"<math.*</math>", sections[name])
        assert ElementTree.fromstring(formula).get("alttext") == kind.formula
    assert "| `cx` | N s/m |" in sections["linear_drag"]


def test_errors_that_are_explained_are_those_of_the_code() -> None:
    page = (ROOT / "docs" / "errors.md").read_text()
    quoted = re.findall(r"^\| `([^`]+)` \| [a-z]", page.split("it says")[1], re.MULTILINE)
    assert len(quoted) >= 8
    code = "".join(path.read_text() for path in (ROOT / "sym2real").rglob("*.py"))
    assert [text for text in quoted if text not in code] == []
    classes = re.findall(r"^\| `(\w+Error)`", page, re.MULTILINE)
    assert set(classes) == set(re.findall(r"^class (\w+)\(Sym2RealError", code, re.MULTILINE))


@pytest.mark.slow
def test_the_site_builds_without_a_warning(tmp_path: Path) -> None:
    pytest.importorskip("mkdocs", reason="the site needs the extra docs")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(tmp_path / "site")]
    run = subprocess.run(command, cwd=ROOT, env=ENVIRONMENT, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr[-2000:]
    pages = {path.parent.name for path in (tmp_path / "site").rglob("index.html")}
    assert {"effects", "reference", "02_hidden_effect", "errors"} <= pages
    assert "sym2real.Equations.simulate" in (tmp_path / "site" / "reference" / "index.html").read_text()
