"""What the pages say stands on what is there: links, files that they name, the textbook's words."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted([*(ROOT / "docs").rglob("*.md"), *(ROOT / name for name in ("README.md", "CONTRIBUTING.md"))])
# Our own words for what the textbook calls disturbance, covariance, tested, confounded.
HOUSE_WORDS = re.compile(r"\b(push along|pushes|pushed|weighing errors|tried|rivals?)\b", re.IGNORECASE)
SEEN_BY_USERS = sorted([*(ROOT / "sym2real" / "report").rglob("*.py"), *(ROOT / "sym2real" / "cli").rglob("*.py")])


def named(page: Path) -> str:
    return str(page.relative_to(ROOT))


def made_or_there(target: Path) -> bool:
    """Pages of tutorials are made from scripts, the catalogue from the registry (docs/site.py); what a page of theirs
    links to, the tutorial writes."""
    if target.name == "report.html":
        return f'"{target.name}"' in target.parent.with_suffix(".py").read_text()
    return target.exists() or target.with_suffix(".py").exists() or target == ROOT / "docs" / "effects.md"


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_a_page_links_to_what_exists_and_has_no_history(page: Path) -> None:
    text = page.read_text()
    links = [link for link in re.findall(r"\]\(([^)#\s]+)", text) if "://" not in link]
    assert [link for link in links if not made_or_there(page.parent / link)] == []
    assert re.findall(r"\bcommit [0-9a-f]{7,}\b|\b(?:DESIGN|DIAGNOSIS)\.md\b", text) == []


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_a_page_uses_the_words_of_the_textbook(page: Path) -> None:
    """Code keeps its names: keys of files that stay are no prose."""
    prose = re.sub(r"```.*?```|`[^`]*`", "", page.read_text(), flags=re.DOTALL)
    assert HOUSE_WORDS.findall(prose) == []


def test_reports_and_help_use_the_words_of_the_textbook() -> None:
    """Sentences in the code that users read: texts with a space in them, docstrings of verbs among them."""
    wrong = []
    for path in SEEN_BY_USERS:
        texts = (node.value for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Constant))
        wrong += [(named(path), t) for t in texts if isinstance(t, str) and " " in t and HOUSE_WORDS.search(t)]
    assert wrong == []


def test_the_glossary_names_code_that_exists() -> None:
    text = (ROOT / "docs" / "glossary.md").read_text()
    places = re.findall(r"`([a-z_]+/[a-z_/]*(?:\.py)?)`", text)
    assert len(places) > 20
    assert [place for place in places if not (ROOT / "sym2real" / place).exists()] == []


@pytest.mark.parametrize("term", ["Fisher information", "identifiable", "confounded", "disturbance", "process noise",
    "multiple shooting", "innovation", "reduced χ²", "M-estimator weight", "unmodelled dynamics"])  # fmt: skip
def test_the_glossary_has_the_terms_of_the_textbook(term: str) -> None:
    assert f"| {term} |" in (ROOT / "docs" / "glossary.md").read_text()
