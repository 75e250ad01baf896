"""Links, names and formulas of HTML pages."""

from __future__ import annotations

import os
import re
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

FROM_ELSEWHERE = re.compile(r"^(?:https?:)?//")


class Page(HTMLParser):
    """Names, links and loaded files of a page."""

    def __init__(self, text: str) -> None:
        """Read the page."""
        super().__init__()
        self.names: set[str] = set()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.formulas = 0
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take what the tag has."""
        values = {name: value or "" for name, value in attrs}
        self.names |= {values[name] for name in ("id", "name") if values.get(name)}
        self.formulas += "arithmatex" in values.get("class", "").split()
        if tag == "a" and "href" in values:
            self.links.append(values["href"])
        elif "src" in values:
            self.loaded.append(values["src"])
        elif tag == "link" and "href" in values:
            self.loaded.append(values["href"])


def read_pages(folder: Path) -> dict[Path, Page]:
    """Read every page of a folder."""
    return {file: Page(file.read_text(encoding="utf-8")) for file in sorted(folder.rglob("*.html"))}


def target_of(file: Path, link: str) -> tuple[Path, str] | None:
    """Return file and anchor that a link of a page leads to; None if it leads elsewhere."""
    parts = urlsplit(link)
    if parts.scheme or parts.netloc:
        return None
    target = file
    if parts.path:
        target = Path(os.path.normpath(file.parent / unquote(parts.path)))
        if parts.path.endswith("/") or parts.path in (".", "..") or target.is_dir():
            target /= "index.html"
    return target, unquote(parts.fragment)


def broken(pages: dict[Path, Page]) -> list[str]:
    """Return links, anchors and loaded files that do not exist."""
    bad = []
    for file, page in pages.items():
        for link in [*page.links, *page.loaded]:
            found = target_of(file, link)
            if found is None:
                continue
            target, anchor = found
            if not target.is_file():
                bad.append(f"{file}: {link}: no such file")
            elif anchor and target in pages and anchor not in pages[target].names:
                bad.append(f"{file}: {link}: no such anchor")
    return bad


def from_elsewhere(folder: Path, pages: dict[Path, Page]) -> list[str]:
    """Return what pages and style sheets load from another place."""
    bad = [
        f"{file}: {name}"
        for file, page in pages.items()
        for name in page.loaded
        if FROM_ELSEWHERE.match(name)
    ]
    for sheet in folder.rglob("*.css"):
        urls = re.findall(r"(?:url\(|@import\s+)[\"']?([^\"')\s]+)", sheet.read_text(encoding="utf-8"))
        bad += [f"{sheet}: {url}" for url in urls if FROM_ELSEWHERE.match(url)]
        local = [sheet.parent / re.sub(r"[?#].*", "", url) for url in urls if not re.match(r"\w+:|//|#", url)]
        bad += [f"{sheet}: {file.name}: no such file" for file in local if not file.is_file()]
    return bad
