"""The pages in Chromium: formulas, pictures, console, light and dark, narrow screens, search."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from conftest import SITE
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

ROOT = Path(__file__).parents[2]
NARROW, WIDE = 360, 1280
"""Widths of a small phone and of a desktop window, in pixels."""
MOST_SECONDS = 30
"""A page that is not ready by then has failed; on an idle machine it takes a fraction of a second."""

PAGE_SCRIPT = """
const wide = [...document.querySelectorAll("article *")].filter(e => {
  if (e.getBoundingClientRect().right <= innerWidth + 1) return false;
  for (let p = e; p; p = p.parentElement) if (getComputedStyle(p).overflowX != "visible") return false;
  return true;
});
return {
  formulas: document.querySelectorAll(".arithmatex").length,
  rendered: document.querySelectorAll(".arithmatex > :is(.katex, .katex-display)").length,
  errors: document.querySelectorAll(".katex-error").length,
  pictures: [...document.images].filter(i => !i.complete || !i.naturalWidth).map(i => i.src),
  wide: wide.map(e => e.outerHTML.slice(0, 200)),
  text: getComputedStyle(document.querySelector("article h1")).color,
  page: getComputedStyle(document.body).backgroundColor,
};
"""


def names() -> list[str]:
    """Return the pages that the browser opens: all but those of single source files."""
    pages = (file.relative_to(SITE) for file in SITE.rglob("index.html"))
    return sorted(str(page.parent) for page in pages if page.parts[0] != "files")


def look(browser: webdriver.Chrome, url: str, dark: bool, width: int) -> dict[str, object]:
    """Open a page and return what the browser found on it."""
    scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [scheme]})
    metrics = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    browser.get_log("browser")
    browser.get(url)
    # the script of the theme chooses the colours after the page has loaded
    wanted = "slate" if dark else "default"
    themed = "return (document.body.dataset.mdColorScheme || arguments[0]) == arguments[0]"
    WebDriverWait(browser, MOST_SECONDS, poll_frequency=0.02).until(
        lambda b: b.execute_script(themed, wanted)
    )
    seen: dict[str, object] = browser.execute_script(PAGE_SCRIPT)
    seen["console"] = [entry["message"] for entry in browser.get_log("browser")]
    return seen


def brightness(color: str) -> float:
    """Return the mean of red, green and blue of an opaque colour of a style, 0 to 255."""
    return sum(float(value) for value in re.findall(r"[\d.]+", color)[:3]) / 3


def check(seen: dict[str, object]) -> None:
    """Assert that all formulas and pictures are there, nothing is too wide, and the console is empty."""
    assert (seen["console"], seen["pictures"], seen["wide"]) == ([], [], [])
    assert (seen["rendered"], seen["errors"]) == (seen["formulas"], 0)


@pytest.mark.parametrize("name", names())
def test_page(browser: webdriver.Chrome, address: str, name: str) -> None:
    """A page on a phone in dark colours."""
    dark = look(browser, f"{address}/{name}/", dark=True, width=NARROW)
    check(dark)
    assert brightness(dark["page"]) < 60 < 100 < brightness(dark["text"])


@pytest.mark.parametrize("name", ["", "docs/theory/", "docs/gallery/", "api/python/"])
def test_page_in_light(browser: webdriver.Chrome, address: str, name: str) -> None:
    """A page with formulas, with pictures and with code in a window in light colours."""
    light = look(browser, f"{address}/{name}", dark=False, width=WIDE)
    check(light)
    assert brightness(light["page"]) > 200 > 130 > brightness(light["text"])


@pytest.mark.parametrize(
    ("name", "width", "what"),
    [
        ("", WIDE, "pre > code, .md-typeset__scrollwrap"),
        ("docs/how-to/hosts/", WIDE, "pre > code, .md-typeset__scrollwrap"),
        ("", NARROW, "pre > code"),
        ("docs/how-to/start/", NARROW, "pre > code"),
    ],
)
def test_nothing_is_cut(browser: webdriver.Chrome, address: str, name: str, width: int, what: str) -> None:
    """The table of hosts and code fit into a window, the first lines of code of a page on a phone, too."""
    look(browser, f"{address}/{name}", dark=False, width=width)
    shown = browser.find_elements(By.CSS_SELECTOR, f"article :is({what})")
    if width == NARROW:
        shown = shown[:1]
    cut = [e.text[:60] for e in shown if e.get_property("scrollWidth") > e.get_property("clientWidth") + 1]
    assert shown and cut == []


def test_every_formula_of_the_sources_is_there(pages: dict[Path, str]) -> None:
    """A page of the site has as many formulas as its source."""
    total = 0
    for source in set((ROOT / "docs").rglob("*.md")) - {ROOT / "docs" / "paper" / "paper.md"}:
        text = source.read_text(encoding="utf-8")
        blocks = len(re.findall(r"^```math$", text, re.MULTILINE))
        prose = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
        inline = re.sub(r"`[^`]*`", "", prose).count("$") // 2
        name = source.relative_to(ROOT).with_suffix("")
        page = SITE / (name.parent if name.name == "README" else name) / "index.html"
        assert len(re.findall(r'class="arithmatex"', pages[page])) == blocks + inline, name
        total += blocks + inline
    assert total > 300


def wait_for(browser: webdriver.Chrome, selector: str) -> list[str]:
    """Wait until a selector finds something, and return the texts."""
    WebDriverWait(browser, MOST_SECONDS).until(lambda b: b.find_elements(By.CSS_SELECTOR, selector))
    return [element.text for element in browser.find_elements(By.CSS_SELECTOR, selector)]


@pytest.mark.parametrize(
    ("words", "page"),
    [
        ("snap", "docs/solver"),
        ("new_interface", "files/src/law/asperity_interface.f90"),
        ("OOFEM", "docs/how-to/fe-programs"),
    ],
)
def test_search(browser: webdriver.Chrome, address: str, words: str, page: str) -> None:
    """The search finds a word of a page."""
    look(browser, f"{address}/", dark=False, width=WIDE)
    browser.find_element(By.CSS_SELECTOR, "input.md-search__input").send_keys(words)
    wait_for(browser, ".md-search-result__link")
    links = browser.find_elements(By.CSS_SELECTOR, ".md-search-result__link")
    assert any(f"/{page}/" in (link.get_attribute("href") or "") for link in links)
