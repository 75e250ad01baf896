"""Tests of `python -m harness.studies.structures` on the rows of structure_study.py."""

from __future__ import annotations

from pathlib import Path

import matplotlib.image
import pytest

from harness.studies import structures
from harness.studies.tables import refresh

DOCS = Path(__file__).parents[2] / "docs"
CSV, PAGE = DOCS / "images" / "structures.csv", DOCS / "results" / "structures.md"


@pytest.mark.long
def test_tolerance_of_select_in_structures() -> None:
    """What select finds for the load case of a structure keeps its tolerance; the page has these rows."""
    rows = structures.read_rows(CSV)
    by = {(row.structure, row.sides): row for row in rows}
    checked = 0
    for name in structures.TURNS:
        found = structures.selected(name)
        for tolerance, sides in found.items():
            row = by[name, sides]
            assert max(row.force, row.rise) <= tolerance, (name, tolerance)
            checked += 1
    assert checked >= 10
    contents = {
        "structures": lambda: structures.table(rows),
        "structures-select": lambda: structures.check_of_select(rows),
    }
    assert refresh(PAGE, True, contents)


def test_every_structure_has_coarse_and_fine_patterns() -> None:
    """The study has all patterns; errors fall over the number of planes, the law takes a part of the run."""
    for name in structures.TURNS:
        rows = [row for row in structures.read_rows(CSV) if row.structure == name]
        finest = structures.FINEST.get(name, structures.REFERENCE)
        assert {n for n in structures.SIDES if n < finest} <= {row.sides for row in rows}
        assert rows[-1].force < 1e-2 * rows[0].force and rows[-1].rise < 1e-2 * rows[0].rise
        assert all(0.0 < row.law < row.seconds for row in rows)


def test_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The command draws a picture and prints the tables of the rows of one structure."""
    lines = CSV.read_text(encoding="utf-8").splitlines()
    chosen = [line for line in lines if line.startswith(("structure,", "explicit block"))]
    (tmp_path / "rows.csv").write_text("\n".join(chosen) + "\n", encoding="utf-8")
    png = tmp_path / "structures.png"
    assert structures.main([str(tmp_path / "rows.csv"), "-o", str(png)]) == 0
    assert matplotlib.image.imread(png).shape[1] > 300
    shown = capsys.readouterr().out
    assert "| explicit block | RP-9 | 10 |" in shown and "Kratos" not in shown


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("structure,sides\n", r"rows.csv: structures \[\]: expected rows of Kratos triplet"),
        ("pattern,planes\nRT,3\n", "rows.csv: expected a CSV of structure_study.py"),
        (
            "structure,sides,force,rise,seconds,law\nbridge,3,1,1,1,1\n",
            "structures .'bridge'.: expected rows of",
        ),
    ],
)
def test_wrong_files(text: str, message: str, tmp_path: Path) -> None:
    """Files of another kind are refused."""
    (tmp_path / "rows.csv").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        structures.read_rows(tmp_path / "rows.csv")


def test_missing_row(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Rows without what select finds, and a picture of another kind, end with an error."""
    lines = CSV.read_text(encoding="utf-8").splitlines()
    starts = ("structure,", "explicit block,0", "explicit block,3,")
    kept = [line for line in lines if line.startswith(starts)]
    (tmp_path / "rows.csv").write_text("\n".join(kept) + "\n", encoding="utf-8")
    assert structures.main([str(tmp_path / "rows.csv"), "-o", str(tmp_path / "a.png")]) == 1
    assert "explicit block: no row with 7 sides" in capsys.readouterr().err
    assert structures.main([str(CSV), "-o", str(tmp_path / "a.txt")]) == 1
    assert "a.txt: expected a name that ends in .png or .pdf" in capsys.readouterr().err
