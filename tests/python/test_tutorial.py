"""docs/tutorial.md: its commands in an empty folder, but for the host run, whose result is in docs/images."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from asperity.cli import main

pytest.importorskip("scipy")  # asperity[fit]

DOCS = Path(__file__).parents[2] / "docs"

DIGITS = 1.0e-3
"""Relative difference of a fit on another processor, far below its intervals."""

NUMBER = r"-?\d+\.\d+(?:e-?\d+)?"


def parts(page: str, language: str) -> list[tuple[str, str]]:
    """Blocks of a language and the text block that follows, with prose between them or not."""
    pattern = rf"^```{language}\n(.*?)^```$.*?^```text\n(.*?)^```$"
    return re.findall(pattern, page, re.MULTILINE | re.DOTALL)


def test_tutorial(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Record, fit, select, card and comparison give what is shown."""
    monkeypatch.chdir(tmp_path)
    page = (DOCS / "tutorial.md").read_text(encoding="utf-8")
    [(code, shown)] = parts(page, "python")
    assert run(code) == shown

    (fit, table), (select, pattern), (card, remarks) = parts(page, "console")
    out = command(fit, capsys)
    for line in table.splitlines()[1:]:
        name = line.split()[0]
        found = re.search(rf"^{name} .*$", out, re.MULTILINE)
        assert found, name
        assert numbers(found[0]) == pytest.approx(numbers(line), rel=DIGITS)
    assert Path("tutorial_fit.png").exists()

    out = command(select, capsys)
    for line in pattern.splitlines():
        same = [
            one for one in out.splitlines() if re.sub(NUMBER, "", one)[:20] == re.sub(NUMBER, "", line)[:20]
        ]
        assert same, line
        # rounding decides how good the reference is
        if not line.startswith("reference"):
            assert numbers(same[0]) == pytest.approx(numbers(line), rel=0.05, abs=1e-6)

    command(card, capsys)
    block = Path("joint.json").read_text(encoding="utf-8")
    for line in remarks.splitlines():
        assert line.split("=")[0] in block

    shutil.copy(DOCS / "images" / "tutorial_host.csv", "host.csv")
    [(code, shown)] = parts(page, "py")
    assert run("import matplotlib\nmatplotlib.use('Agg')\n" + code) == shown
    assert Path("tutorial_comparison.png").exists()


def command(text: str, capsys: pytest.CaptureFixture[str]) -> str:
    """Output of a command of the page."""
    capsys.readouterr()
    assert main(text.split()[1:]) == 0
    return capsys.readouterr().out


def run(code: str) -> str:
    """Output of a script in the current folder."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def numbers(line: str) -> list[float]:
    """Numbers with a decimal point in a line."""
    return [float(text) for text in re.findall(NUMBER, line)]
