"""Draw the gallery of the paper and fill the findings into its page, between markers as <!-- figure02 -->."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from .paper.command import ENTRIES, Entry, write
from .tables import fill

PAGE = Path("docs/gallery/README.md")


def refresh(page: Path, entries: Sequence[Entry]) -> None:
    """Write pictures and numbers of entries beside a page, and their findings into it."""
    findings = write(entries, page.parent)
    page.write_text(fill(page.read_text(encoding="utf-8"), findings), encoding="utf-8")


if __name__ == "__main__":
    refresh(PAGE, ENTRIES)
