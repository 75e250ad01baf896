"""Pages of docs/how-to whose commands are run in an empty folder: they show the output.

Hosts are not run; the result of the tutorial's one is in docs/images.  After a change of the numbers run
`make hosts`, then `.venv/bin/python tests/python/refresh.py docs/how-to/tutorial.md`.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from asperity.case_files import read_run
from refresh import follow, words_and_numbers

DOCS = Path(__file__).parents[2] / "docs"

DIGITS = {"barton": 5e-3, "bond-slip": 5e-3, "tutorial": 1e-3, "surface": 1e-9, "uncertainty": 5e-3}
"""Relative difference of the numbers of a page on another processor, far below the intervals of fits."""


def followed(name: str, folder: Path) -> str:
    """Text of a page, which has the words of the output of its commands, and their numbers."""
    page = DOCS / "how-to" / f"{name}.md"
    text = page.read_text(encoding="utf-8")
    (words, numbers), (printed, theirs) = map(words_and_numbers, (text, follow(page, folder, hosts=False)))
    assert printed.split() == words.split()
    assert theirs == pytest.approx(numbers, rel=DIGITS[name])
    return text


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("barton", marks=pytest.mark.slow),
        pytest.param("surface", marks=pytest.mark.long),
        pytest.param("uncertainty", marks=pytest.mark.long),
    ],
)
def test_page(name: str, tmp_path: Path) -> None:
    """The page shows the output of its commands."""
    followed(name, tmp_path)


@pytest.mark.slow
def test_strip_of_the_page(tmp_path: Path) -> None:
    """A long bond holds sqrt(2 E t G), and the work is that of strip, bond and rupture, within 1e-3."""
    page = followed("bond-slip", tmp_path)
    rows = re.findall(r"(?m)^\w+ +([\d.]+) of ([\d.]+) N/mm; work ([\d.]+) N: .* sum ([\d.]+)$", page)
    assert len(rows) == 2
    for force, closed, work, spent in (map(float, row) for row in rows):
        # E t = 194.79 kN/mm, 5.2 MPa, 0.26 mm
        assert closed == pytest.approx(np.sqrt(2.0 * 194.79e3 * 0.5 * 5.2 * 0.26), abs=0.005)
        assert force == pytest.approx(closed, rel=1e-3) and work == pytest.approx(spent, rel=1e-3)
    intervals = json.loads((tmp_path / "bond.fit.json").read_text(encoding="utf-8"))["intervals"]
    for name, truth in (("sigma0", 5.2), ("Gc", 0.676), ("eta", 1.0 - 0.045 / 0.26)):
        assert intervals[name][0] <= truth <= intervals[name][1]


@pytest.mark.slow
def test_tutorial(tmp_path: Path) -> None:
    """Prose has the numbers of the output, and the joint with which the host ran is that of the page."""
    page = followed("tutorial", tmp_path)
    # "All five intervals contain the true values"
    behind = re.findall(r"(sigma0|Gc|eta|mu|theta)=([\d.]+)", page.partition("## 2.")[0])
    assert len(behind) == 5
    intervals = json.loads((tmp_path / "joint.fit.json").read_text(encoding="utf-8"))["intervals"]
    for name, value in behind:
        low, high = intervals[name]
        assert low < float(value) < high
    [[flat], [missed]] = (
        re.findall(form, page) for form in (r"(?m)^flat .* (\S+)$", r"by (\d+) %. RT stays")
    )
    assert float(missed) == pytest.approx(100.0 * float(flat), abs=0.5)
    # the column of the material point is that of the case
    host = np.genfromtxt(DOCS / "images" / "tutorial_host.csv", delimiter=",", names=True)
    point = read_run(tmp_path / "joint.nml").interface.confined_slip(0.0, [0.0, *host["slip"]], -0.5)
    assert host["force_point"] == pytest.approx(420.0 * point.traction[1:, 1], rel=DIGITS["tutorial"])
    rise = point.separation[:, 0] - point.separation[0, 0]
    assert host["rise_point"] == pytest.approx(2.0 * rise[1:], abs=DIGITS["tutorial"])
    shown = re.findall(r"(?m)^(?:largest force|force at the end) (\S+) N, .* (\S+) N$", page)
    columns = host["force"], host["force_point"]
    assert shown == [tuple(f"{of(column):.2f}" for column in columns) for of in (np.max, lambda x: x[-1])]
