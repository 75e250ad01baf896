"""What the tests of the hosts share: a path of one element, and the kits of `asperity export HOST DIR`."""

from __future__ import annotations

import contextlib
import io
import subprocess
import sys
from pathlib import Path

import numpy as np
from asperity import Interface, Material, Pattern, Step
from asperity.cli import main
from asperity.contract import Floats
from asperity.export.element import Element

MATERIAL = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=3.0)
STIFFNESS = MATERIAL.kc * MATERIAL.K
SOLID, PLANE = (Interface(MATERIAL, Pattern.regular(sides, theta=30.0)) for sides in (4, 2))
"""Joints of elements in three and two dimensions."""

LEGS = (
    (4, (-0.01, 0.0, 0.0)), (16, (-0.005, 0.08, 0.05)), (30, (-0.005, -0.1, 0.05)), (20, (0.06, 0.05, 0.05)),
    (10, (0.002, 0.05, 0.05)), (20, (0.3, 0.3, 0.05)), (30, (-0.02, -0.1, 0.05)),
)  # fmt: skip
"""Increments and separation (N, Tx, Ty) at their end: pressing, sliding and its reversal, opening, unloading,
complete rupture, closing."""


def path(plane: bool = False) -> Floats:
    """Separations (T, 3) along LEGS, without Ty in a plane model."""
    ends = np.array([(0.0, 0.0, 0.0), *(end for _, end in LEGS)]) * [1.0, 1.0, 0.0 if plane else 1.0]
    parts = [np.linspace(ends[i], ends[i + 1], n + 1)[1:] for i, (n, _) in enumerate(LEGS)]
    return np.concatenate(parts)


def reach(separations: Floats) -> Floats:
    """Stiffness times the largest separation so far, (T, 1): the scale of the tractions of a path."""
    return STIFFNESS * np.maximum.accumulate(np.linalg.norm(separations, axis=1))[:, None]


def assert_law(joint: Interface, tolerance: float, separation: Floats, *values: Floats) -> None:
    """Assert that every point (T, points, 3) has the law on its own history.

    values: tractions, and maybe the first state variables; tolerance: of both, of tractions over sigma0.
    """
    sizes = (joint.material.sigma0, 1.0)[: len(values)]
    for k in range(separation.shape[1]):
        expected = joint.replay(separation[:, k])
        for computed, known, size in zip(values, (expected.traction, expected.state), sizes, strict=False):
            assert np.abs(computed[:, k] - known[:, : computed.shape[2]]).max() <= tolerance * size


def from_state(joint: Interface, state: Floats, separation: Floats) -> Floats:
    """Tractions (T, 3) of a point along separations (T, 3) from a state at separation zero."""
    s_N, s_Tx, s_Ty = separation.T
    return joint.rows(Step(s_N=s_N, s_Tx=s_Tx, s_Ty=s_Ty, increments=1), state)[0].traction


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
    cell = Element.of_case(case)
    assert (cell.press, cell.slide, len(cell.rows)) == (8, 85, 5)
    return cell, [cell.press + k * cell.every for k in range(1, 6)]


def assert_script(host: str, folder: Path, python: str | Path = sys.executable) -> None:
    """Assert that the script of a kit, which compares its rows with those of the README, ends well."""
    element(host, folder / "kit")
    script = [python, folder / "kit" / "single.py"]
    done = subprocess.run(script, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(done.stdout.split("expected\n")[-1].splitlines()) == 5


def assert_same(cell: Element, rows: object, tolerance: float) -> None:
    """Assert that slip, opening, force and damage of a host are the rows of the README."""
    material = cell.interface.material
    difference = np.abs(np.array(rows) - cell.rows) / [material.s_f, material.s_f, material.sigma0, 1.0]
    print(f"rows of the exported element differ by {difference.max():.1e}")
    assert difference.max() <= tolerance
