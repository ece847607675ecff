"""The page in a real browser: every section, switches that move curves, no request, no error, no violation by axe."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from report_pages import BASE, HOSTILE, PATIENCE, browser, diagnosis, logs, picture

from sym2real.diagnosis.faults.sanity import check
from sym2real.report import html
from sym2real.report.html.observed import observe
from sym2real.report.html.page import Page
from sym2real.report.html.pages import diagnosis_page
from sym2real.report.html.render import write_page
from sym2real.report.html.variants import WithFindings

QUESTIONS = (
    "How good is the model?",
    "Where does it fail?",
    "What is missing?",
    "What happens when it is added?",
    "What remains?",
)


@dataclass
class Opened:
    """A page in the browser, and what it said and asked for."""

    page: Any
    said: list[str] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)


@pytest.fixture(scope="module")
def made() -> Page:
    return diagnosis_page(BASE, logs(), diagnosis(), f"crazyflie {HOSTILE}")


@pytest.fixture(scope="module")
def file(made: Page, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_page(made, tmp_path_factory.mktemp("report") / "report.html")


@pytest.fixture(scope="module")
def chrome() -> Iterator[Any]:
    with browser() as opened:
        yield opened


@contextmanager
def visited(chrome: Any, file: Path, width: int, scheme: str) -> Iterator[Opened]:
    """The page in a window of its own."""
    context = chrome.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)
    context.set_default_timeout(PATIENCE)
    found = Opened(context.new_page())
    found.page.on("console", lambda message: found.said.append(message.text))
    found.page.on("pageerror", lambda error: found.said.append(str(error)))
    found.page.on("request", lambda asked: found.asked.append(asked.url))
    found.page.goto(file.as_uri())
    found.page.wait_for_function("document.documentElement.dataset.ready === 'yes'")
    yield found
    context.close()


@pytest.fixture(scope="module", params=[(1600, "light"), (380, "dark")], ids=["wide", "phone"])
def shared(request: pytest.FixtureRequest, chrome: Any, file: Path) -> Iterator[Opened]:
    with visited(chrome, file, *request.param) as found:
        yield found


AS_OPENED = """() => {
  const form = document.querySelector(".controls");
  form.reset();
  form.dispatchEvent(new Event("input"));
  for (const folded of document.querySelectorAll("details")) folded.open = true;
  window.scrollTo(0, 0);
}"""


@pytest.fixture
def opened(shared: Opened) -> Opened:
    """The page as it opens, all equations unfolded."""
    shared.page.evaluate(AS_OPENED)
    return shared


# A chart that comes into view is drawn some frames later.
DRAWN = """async (canvas) => {
  let same = 0, shown = "";
  for (let frame = 0; same < 3; frame++) {
    if (frame > 600) throw new Error("the chart never comes to rest");
    await new Promise(requestAnimationFrame);
    same = canvas.toDataURL() === shown ? same + 1 : 0;
    shown = canvas.toDataURL();
  }
  return shown;
}"""


def drawn(opened: Opened, title: str) -> str:
    """The pixels of a chart."""
    chart = opened.page.locator("figure", has=opened.page.get_by_text(title, exact=True)).first
    chart.scroll_into_view_if_needed()
    canvas = chart.locator("canvas")
    canvas.wait_for()
    shown: str = canvas.evaluate(DRAWN)
    return shown


def test_every_question_is_answered_without_a_request_or_an_error(opened: Opened) -> None:
    assert opened.page.locator("section h2").all_inner_texts() == list(QUESTIONS)
    charts = opened.page.locator("figure")
    for place in range(charts.count()):
        charts.nth(place).scroll_into_view_if_needed()
        charts.nth(place).locator("canvas").wait_for()
    assert len(opened.asked) == 1  # the file itself
    assert opened.said == []


def test_nothing_is_wider_than_the_window(opened: Opened) -> None:
    width = opened.page.viewport_size["width"]
    assert opened.page.evaluate("document.documentElement.scrollWidth") <= width
    opened.page.screenshot(path=picture(f"{width}_top"))
    opened.page.locator("#failing").scroll_into_view_if_needed()
    opened.page.wait_for_timeout(200)
    opened.page.screenshot(path=picture(f"{width}_failing"))
    opened.page.locator("#added").scroll_into_view_if_needed()
    opened.page.wait_for_timeout(200)
    opened.page.screenshot(path=picture(f"{width}_added"))


def test_axe_finds_no_violation(opened: Opened) -> None:
    from axe_playwright_python.sync_playwright import Axe

    violations = Axe().run(opened.page).response["violations"]
    assert [(one["id"], one["nodes"][0]["html"]) for one in violations] == []


def test_text_of_files_is_shown_and_never_run(opened: Opened) -> None:
    assert opened.page.evaluate("window.broken") is None
    assert "{{7*7}}" in opened.page.title()
    visible = opened.page.locator("body").inner_text()
    assert visible.count("<img src=x onerror=") >= 5  # heading, summary, what decides, remarks, not tried
    assert opened.page.locator("img").count() == 0


def test_the_policy_stops_what_slipped_through(chrome: Any, file: Path) -> None:
    with visited(chrome, file, 800, "light") as opened:
        added = "document.body.append(Object.assign(document.createElement('script'), {text: 'broken = 1'}))"
        opened.page.evaluate(added)
        assert opened.page.evaluate("window.broken") is None
        while not any("Content Security Policy" in text for text in opened.said):
            opened.page.wait_for_event("console")


def errors_shown(opened: Opened, column: str) -> list[float]:
    cells = opened.page.locator(f"table.errors tbody tr td:nth-child({column})").all_inner_texts()
    return [float(one) for one in cells]


def test_switches_move_errors_to_what_python_says(opened: Opened) -> None:
    variants = WithFindings(BASE, diagnosis().findings)
    observed = observe(variants, check(BASE, logs()).data)  # as a diagnosis takes them
    shown = int(abs(observed.horizons - 0.8).argmin())
    boxes = opened.page.locator("input[name=switch]")
    assert boxes.count() == 2
    for on in range(4):
        for place in range(2):
            boxes.nth(place).set_checked(bool(on >> place & 1))
        expected = [observed.by_horizon[name][on, shown] for name in ("position", "attitude", "velocity", "rate")]
        assert errors_shown(opened, "3") == pytest.approx(expected, rel=6e-3)
    assert errors_shown(opened, "2") == pytest.approx(
        [observed.by_horizon[name][0, shown] for name in ("position", "attitude", "velocity", "rate")], rel=6e-3
    )


@pytest.mark.parametrize("title", ["position", "path from above", "z", "position error 0.5 s ahead"])
def test_switches_move_curves_and_back(opened: Opened, title: str) -> None:
    box = opened.page.locator("input[name=switch]").first
    before = drawn(opened, title)
    box.uncheck()
    assert drawn(opened, title) != before
    box.check()
    assert drawn(opened, title) == before


STRETCH = """() => {
  let last = null, longest = 0;
  const about = Path2D.prototype, moved = about.moveTo, drawn = about.lineTo;
  about.moveTo = function (x, y) { last = [x, y]; moved.call(this, x, y); };
  about.lineTo = function (x, y) {
    longest = Math.max(longest, Math.hypot(x - last[0], y - last[1])); last = [x, y]; drawn.call(this, x, y);
  };
  const ends = { 1: [[0, 1, 1, 0, 0], [0, 0, 1, 1, 0].map((y, i) => (i === 2 ? null : y))] };
  stretches({ data: ends, valToPos: (value) => value }, 1);
  Object.assign(about, { moveTo: moved, lineTo: drawn });
  return longest;
}"""


def test_a_path_that_turns_back_has_no_chord_across_a_gap(chrome: Any) -> None:
    """Round a square whose far corner is another class: its sides are drawn, its diagonal is not."""
    page = chrome.new_page()
    text = (Path(html.__file__).parent / "assets" / "charts.js").read_text()
    page.evaluate(text.replace("export class", "class") + "; window.stretches = stretches; null")
    assert page.evaluate(STRETCH) == pytest.approx(1.0)
    page.close()


def test_the_page_works_by_keyboard(opened: Opened) -> None:
    page = opened.page
    page.locator("input[name=switch]").first.focus()
    page.keyboard.press("Space")
    assert not page.locator("input[name=switch]").first.is_checked()
    page.locator("input[name=time]").focus()
    before = drawn(opened, "path from above")
    page.keyboard.press("End")
    assert float(page.locator("output[name=now]").inner_text().split()[0]) == pytest.approx(219 * 0.02, abs=0.02)
    assert drawn(opened, "path from above") != before
    page.locator("select[name=log]").focus()
    page.keyboard.press("ArrowDown")
    assert page.locator("select[name=log]").input_value() == "1"


def test_the_file_alone_is_enough(file: Path) -> None:
    assert file.stat().st_size < 5e6
    text = file.read_text()
    assert "http://" not in text.replace("http://www.w3.org", "").replace("http://github.com", "")
    data = text.split('id="report">')[1].split("</script>")[0]
    assert len(json.loads(data)["charts"]) == text.count("<figure")
