"""The files of the site: pages, search index, pictures.

MkDocs has looked at links and anchors when it built it; the browser of test_browser.py reports files that are
missing, or asked for from elsewhere.
"""

from __future__ import annotations

import re
from pathlib import Path

from conftest import SITE

ROOT = Path(__file__).parents[2]


def test_every_page_of_the_repository_is_there(pages: dict[Path, str]) -> None:
    """Each Markdown page has a page of the site, as have the C header and the public Fortran sources."""
    sources = {*ROOT.glob("[A-Z]*.md"), *(ROOT / "docs").rglob("*.md")} - {ROOT / "docs/paper/paper.md"}
    names = [re.sub(r"(^|/)README$", r"\1index", str(s.relative_to(ROOT).with_suffix(""))) for s in sources]
    fortran = [f"law/asperity_{name}" for name in ("interface", "arrays", "contract", "kinds")]
    fortran += ["joint/asperity_initial", "adapters/asperity_umat", "adapters/asperity_vumat"]
    names += [f"files/src/{name}.f90" for name in fortran] + ["files/src/asperity.h", "api/python"]
    wanted = {SITE / (f"{name}.html" if name.endswith("index") else f"{name}/index.html") for name in names}
    assert len(wanted) > 50 and wanted - set(pages) == set()


def test_api_has_comments() -> None:
    """Comments of Fortran, C and Python are in the reference."""
    for name, words in {
        "files/src/law/asperity_arrays.f90": ["Checked entry to the law", "first bad point", "update_points"],
        "files/src/asperity.h": ["Update n points over one increment", "tangent", "asperity_update"],
        "api/python": ["Take n points over one increment", "EquilibriumLost", "confined_slip"],
    }.items():
        text = (SITE / name / "index.html").read_text(encoding="utf-8")
        assert [word for word in words if word not in text] == [], name
