"""Joints that are surfaces of revolution: CAX4 and COHAX4, and a fibre pulled out against closed forms."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern
from asperity.mesh import split

ROOT = Path(__file__).parents[2]
RADII = 0.0, 3.0, 5.0
JOINT = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(0, 0.0))


def deck(kind: str = "CAX4", shift: float = 0.0, cone: float = 0.0) -> str:
    """Rings between radii, two elements high; the joint between them is a cylinder or a cone."""
    z = (0.0, 1.0, 4.0)
    nodes = [(r + shift + cone * height * (k == 1), height) for k, r in enumerate(RADII) for height in z]
    text = "*Node\n" + "".join(f"{i}, {r}, {h}\n" for i, (r, h) in enumerate(nodes, 1))
    for k, name in enumerate(("ROD", "RING")):
        rows = [(3 * k + i, 3 * k + 3 + i, 3 * k + 4 + i, 3 * k + 1 + i) for i in (1, 2)]
        lines = "".join(f"{2 * k + j}, {', '.join(map(str, row))}\n" for j, row in enumerate(rows, 1))
        text += f"*Element, type={kind}, elset={name}\n{lines}"
    return text


@pytest.mark.parametrize("kind", ["CAX4", "CAX4R", "CAX4RH"])
@pytest.mark.parametrize("cone", [0.0, 0.1])
def test_elements_and_areas(kind: str, cone: float, said: Callable, folder: Path) -> None:
    """Solids keep their types, joints are COHAX4, and the area is that of the cylinder or the cone."""
    (folder / "rod.inp").write_text(deck(kind, cone=cone), encoding="utf-8")
    out, _ = said("mesh rod.inp --axisymmetric -o new.inp")
    written = (folder / "new.inp").read_text(encoding="utf-8")
    assert re.findall(r"type=(C\w+)", written) == [kind, kind, "COHAX4"]
    expected = np.pi * (2.0 * RADII[1] + 4.0 * cone) * np.hypot(4.0, 4.0 * cone)
    [area] = re.findall(r"joint joint: 2 faces, area of revolution ([\d.]+)", out)
    assert float(area) == pytest.approx(expected, rel=1e-5)


def test_refusals(said: Callable, folder: Path) -> None:
    """What a host would read as plane, and what contradicts an axis, is refused."""
    (folder / "rod.inp").write_text(deck(), encoding="utf-8")
    plane = said("mesh rod.inp -o new.inp", 1)[1]
    assert "type=CAX4: not read: axisymmetric: expected a plane mesh or one in space, or --axisymm" in plane
    assert (
        "axisymmetric mesh: vtu would read a plane one: expected abaqus"
        in said("mesh rod.inp --axisymmetric -o new.vtu", 1)[1]
    )
    for text, words in (
        (deck("CPE4"), "axisymmetric: elements of type CPE4: expected types such as CAX4"),
        (deck(shift=-1.0), "a node at r = -1: expected r >= 0"),
        (deck(shift=-3.0), "a node at r = -3"),
    ):
        (folder / "rod.inp").write_text(text, encoding="utf-8")
        assert words in said("mesh rod.inp --axisymmetric -o new.inp", 1)[1]


@pytest.mark.parametrize(("solid", "joint", "words"), [
    ("CAX4", "COHAX4", ""),
    ("CAX4", "COH2D4", "beside solids of type CAX4: expected COHAX4"),
    ("CPE4", "COHAX4", "beside solids of type CPE4: expected COH2D4"),
    ("CPE4", "COH2D4", ""),
])  # fmt: skip
def test_doctor(solid: str, joint: str, words: str, said: Callable, folder: Path) -> None:
    """Plane and axisymmetric elements side by side are named; what `asperity mesh` writes is right."""
    (folder / "rod.inp").write_text(deck(), encoding="utf-8")
    said("mesh rod.inp --axisymmetric -o new.inp")
    text = re.sub(r"COHAX4", joint, (folder / "new.inp").read_text(encoding="utf-8"))
    text = re.sub(r"type=CAX4", f"type={solid}", text)
    sections = "".join(f"*Solid Section, elset={name}, material=ROCK\n,\n" for name in ("ROD", "RING"))
    text += sections + "*Material, name=ROCK\n*Elastic\n30000., 0.2\n"
    text += JOINT.card("abaqus", name="joint", dimension=2)
    (folder / "job.inp").write_text(text, encoding="utf-8")
    out, _ = said("doctor job.inp", code=int(bool(words)))
    assert words in out


def test_mesh_without_types() -> None:
    """A plane mesh is the section of a body of revolution if that is said."""
    meshio = pytest.importorskip("meshio")
    points = np.array([[r, z, 0.0] for r in RADII for z in (0.0, 1.0, 4.0)])
    cells = np.array([[k + i, k + 3 + i, k + 4 + i, k + 1 + i] for k in (0, 3) for i in (0, 1)])
    mesh = meshio.Mesh(points, [("quad", cells)], cell_sets={"ROD": [[0, 1]], "RING": [[2, 3]]})
    assert split(mesh, axisymmetric=True).axisymmetric and not split(mesh).axisymmetric
    assert "area of revolution 75.39" in split(mesh, axisymmetric=True).summary()


def test_pull_out(tmp_path: Path) -> None:
    """Stiffness and largest force of a long fibre: plane sections hold within K a/G, elements within 2e-3."""
    program = ROOT / "harness" / "examples" / "pull_out.py"
    run = subprocess.run(
        [sys.executable, program, tmp_path / "pull_out.inp"], capture_output=True, text=True, check=True
    )
    rows = re.findall(r"([\d.]+) N(?:/mm)?, closed form ([\d.]+)", run.stdout)
    assert len(rows) == 2
    for computed, expected in rows:
        assert float(computed) == pytest.approx(float(expected), rel=2e-3)
