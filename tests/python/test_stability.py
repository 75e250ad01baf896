"""Every entry of the catalogue of failure modes has the expected results, and its numbers are checked."""

from __future__ import annotations

import csv
import functools
import re
from collections.abc import Sequence
from itertools import product
from pathlib import Path

import pytest

from harness.studies.stability import MODES, Trial, find, shown, table
from harness.studies.stability.__main__ import main
from harness.studies.stability.branches import steep_snap
from harness.studies.stability.catalogue import agree
from harness.studies.stability.modes import TABLE_2

pytestmark = pytest.mark.long

ROOT = Path(__file__).parents[2]
NAMES = [mode.name for mode in MODES]


@functools.cache
def trials_of(name: str) -> Sequence[Trial]:
    """Trials of an entry, run once."""
    return find([name])[0].run()


def table_of_the_page() -> str:
    """Return the table that docs/results/stability.md shows."""
    page = (ROOT / "docs" / "results" / "stability.md").read_text(encoding="utf-8")
    found = re.search(r"<!-- stability -->\n(.*?)\n<!-- /stability -->", page, re.DOTALL)
    assert found
    return found[1]


@pytest.mark.parametrize("name", NAMES)
def test_failure_and_survival(name: str) -> None:
    """Trials fail or succeed as expected, each entry has both kinds, and the page has its section.

    Numbers may differ as between compilers.
    """
    trials = trials_of(name)
    assert [trial for trial in trials if not trial.holds] == []
    assert any(trial.survives for trial in trials)
    assert not all(trial.survives for trial in trials)
    assert shown(trials)
    entry = table([(find([name])[0], trials)])
    section_of_it = rf"^### {name}\n[\s\S]*?(?=\n\n### |\Z)"
    (section,) = re.findall(section_of_it, table_of_the_page(), re.MULTILINE)
    assert agree(section, entry)


def test_a_snap_is_drawn(tmp_path, capsys) -> None:
    """Jump and whole branch are drawn; without friction the area between both is the released energy."""
    assert main(["run", "snap", "--folder", str(tmp_path)]) == 0
    assert f"{tmp_path / 'stability_snap.png'}" in capsys.readouterr().out
    assert (tmp_path / "stability_snap.png").stat().st_size > 20_000
    snap = steep_snap(0.0)
    # the motion of the jump is accurate to 3e-4 K s_0^2
    assert snap.area == pytest.approx(snap.released, abs=3e-4 * TABLE_2.K * TABLE_2.s_0**2)
    assert len(snap.turns) == 2


# --- numbers that come from elsewhere ----------------------------------------------------------------


# --- maps --------------------------------------------------------------------------------------------


def test_map(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Pictures and CSV are written; the consistent tangent converges wherever the symmetrised one does."""
    assert main(["map", "--folder", str(tmp_path), "--size", "2"]) == 0
    written = [Path(line) for line in capsys.readouterr().out.split()]
    assert [path.suffix for path in written] == [".csv", ".png"]
    assert written[1].read_bytes()[:4] == b"\x89PNG"
    with written[0].open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    places = {(float(row["mu"]), float(row["theta"])) for row in rows}
    assert places == set(product((0.0, 1.6), (0.0, 60.0)))
    assert all(row["consistent"] != "nan" for row in rows if row["symmetrised"] != "nan")
    assert float(rows[0]["determinant"]) < 0.0  # the bond softens
    assert main(["map", "--folder", str(tmp_path), "--size", "1"]) == 1


# --- command -----------------------------------------------------------------------------------------


def test_list(capsys: pytest.CaptureFixture[str]) -> None:
    """The list has every entry."""
    assert main(["list"]) == 0
    out = capsys.readouterr().out
    assert re.findall(r"^(\S+): ", out, re.MULTILINE) == NAMES


def test_run(capsys: pytest.CaptureFixture[str]) -> None:
    """One entry is shown with its measured numbers; the error for an unknown name has the known ones."""
    assert main(["run", "single-precision"]) == 0
    out = capsys.readouterr().out
    assert "fails    single precision, slip of 100 mm" in out
    assert main(["run", "unheard-of"]) == 1
    assert "unheard-of: expected all or names of snap, " in capsys.readouterr().err
    assert main(["run", "single-precision", "--check"]) == 1
