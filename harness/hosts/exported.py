"""Kits of `asperity export HOST DIR --case` for a joint that is not that of the examples, and their runs."""

from __future__ import annotations

import contextlib
import io
import subprocess
import sys
from pathlib import Path

import numpy as np
from asperity.cli import main
from asperity.export.element import Element

CASE = """&case title = 'mine' /
&material sigma0 = 0.25, Gc = 0.02, eta = 0.9, mu = 0.7, kc = 8.0 /
&pattern sides = 4, theta = 20.0, turn = 15.0 /
&step t_N = -0.5, increments = 8 /
&step slip = 0.4, -0.1, increments = 83, 20 /
"""


def element(host: str, folder: Path) -> tuple[Element, list[int]]:
    """Write the kit of a host; returns the element and the numbers of the steps (from 1) of its rows."""
    case = folder.parent / "mine.nml"
    case.write_text(CASE, encoding="utf-8")
    with contextlib.redirect_stdout(io.StringIO()):
        assert main(["export", host, str(folder), "--case", str(case)]) == 0
    one = Element.of_case(case)
    assert (one.press, one.slide, len(one.rows)) == (8, 85, 5)
    return one, [one.press + k * one.every for k in range(1, 6)]


def assert_script(host: str, folder: Path) -> None:
    """Assert that the script of a kit, which compares its rows with those of the README, ends well."""
    element(host, folder / "kit")
    script = [sys.executable, folder / "kit" / "single.py"]
    done = subprocess.run(script, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(done.stdout.split("expected\n")[-1].splitlines()) == 5


def assert_same(one: Element, rows: object, tolerance: float) -> None:
    """Assert that slip, opening, force and damage of a host are the rows of the README."""
    material = one.interface.material
    difference = np.abs(np.array(rows) - one.rows) / [material.s_f, material.s_f, material.sigma0, 1.0]
    print(f"rows of the exported element differ by {difference.max():.1e}")
    assert difference.max() <= tolerance
