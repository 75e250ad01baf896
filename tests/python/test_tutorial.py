"""Test of docs/how-to/tutorial.md: its commands are run in an empty folder.

The host is not run; its result is in docs/images.  After a change of the fit run `make hosts`, then
`.venv/bin/python tests/python/refresh.py docs/how-to/tutorial.md`.  This command runs the whole page, with
the host, and fills in the printed output.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from asperity.case_files import read_run

DOCS = Path(__file__).parents[2] / "docs"

DIGITS = 1.0e-3
"""Relative difference of a fit on another processor, far below its intervals."""

NUMBER = r"-?\d+\.\d+(?:e-?\d+)?"


def parts(page: str, language: str) -> list[tuple[str, str]]:
    """Return every block of a language and the text block after it; prose may stand between them."""
    pattern = rf"^```{language}\n(.*?)^```$.*?^```text\n(.*?)^```$"
    return re.findall(pattern, page, re.MULTILINE | re.DOTALL)


@pytest.mark.slow
@pytest.mark.usefixtures("folder")
def test_tutorial(said: Callable) -> None:
    """The commands record, fit, select and card print the output that the page shows."""
    page = (DOCS / "how-to" / "tutorial.md").read_text(encoding="utf-8")
    [(code, shown)], [(again, of_fit)] = parts(page, "python"), parts(page, "py")
    assert run(code) == shown

    (fit, table), (select, pattern), (card, remarks) = parts(page, "console")
    out = said(fit.removeprefix("asperity "))[0]
    for line in table.splitlines()[1:]:
        name = line.split()[0]
        found = re.search(rf"^{name} .*$", out, re.MULTILINE)
        assert found, name
        assert numbers(found[0]) == pytest.approx(numbers(line), rel=DIGITS)
    assert Path("tutorial_fit.png").exists()
    # "all five intervals hold the values behind the record"
    behind = re.findall(r"(sigma0|Gc|eta|mu|theta)=([\d.]+)", code)
    assert len(behind) == 5
    for name, value in behind:
        _, low, high = numbers(re.search(rf"^{name} .*$", table, re.MULTILINE)[0])
        assert low < float(value) < high

    assert numbers(run(again)) == pytest.approx(numbers(of_fit), rel=DIGITS, abs=DIGITS)

    out = said(select.removeprefix("asperity "))[0]
    for line in pattern.splitlines():
        same = [
            one for one in out.splitlines() if re.sub(NUMBER, "", one)[:20] == re.sub(NUMBER, "", line)[:20]
        ]
        assert same, line
        # The error of the reference is a rounding error and differs between machines.
        if not line.startswith("reference"):
            assert numbers(same[0]) == pytest.approx(numbers(line), rel=0.05, abs=1e-6)

    # "would miss the residual strength by ..."
    missed = re.search(r"by (\d+) %. RT stays", page)
    assert missed and float(missed[1]) == pytest.approx(
        100.0 * numbers(pattern.splitlines()[-2])[-1], abs=0.5
    )

    said(card.removeprefix("asperity "))
    block = Path("joint.xml").read_text(encoding="utf-8")
    for line in remarks.splitlines():
        assert line.split("=")[0] in block

    # The host ran with this joint: its column of the material point equals that of the case.
    shutil.copy(DOCS / "images" / "tutorial_host.csv", "tutorial_host.csv")
    host = np.genfromtxt("tutorial_host.csv", delimiter=",", names=True)
    joint = read_run(Path("joint.nml")).interface
    point = joint.confined_slip(0.0, host["slip"], -0.5)
    pressed = joint.confined_slip(0.0, [0.0], -0.5).separation[0, 0]
    assert host["force_point"] == pytest.approx(420.0 * point.traction[:, 1], rel=DIGITS)
    assert host["rise_point"] == pytest.approx(2.0 * (point.separation[:, 0] - pressed), abs=DIGITS)
    forces = re.findall(r"^(?:largest force|force at the end) .*$", page, re.MULTILINE)
    assert numbers("\n".join(forces)) == [
        float(f"{value:.2f}")
        for of in (np.max, lambda column: column[-1])
        for value in (of(host["force"]), of(host["force_point"]))
    ]


def run(code: str) -> str:
    """Return the output of a script that is run in the current folder."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def numbers(line: str) -> list[float]:
    """Return the numbers with a decimal point in a line."""
    return [float(text) for text in re.findall(NUMBER, line)]
