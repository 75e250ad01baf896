"""Layers of solids that are joints in CalculiX: normal, thickness and steps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern

JOINT = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(2, theta=30.0))

TURNED = "*ORIENTATION, NAME=ACROSS\n0., 1., 0., 0., 0., 1.\n"
"""Axes whose third one is x."""


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("|", ""),
        ("thickness|0.01", "1 of 1 elements, as at (0.5, 0.5, 1), are 0.01 thick: expected 0.25 (PROPS 9)"),
        ("axes|1, 2, 0", "another normal than z: expected an *Orientation"),
        ("axes|1, 2, 0, MATERIAL=ABAQUSJOINT, ORIENTATION=ACROSS", ""),
        ("MATERIAL=ABAQUSJOINT|MATERIAL=ABAQUSJOINT, ORIENTATION=ACROSS", "than the third axis of"),
        ("*STEP|*STEP, NLGEOM", "NLGEOM: expected none"),
        ("*STEP|*STEP, NLGEOM=NO", ""),
        ("C3D8|C3D6", ""),
    ],
)
def test_layers_of_calculix(change: str, words: str, said, tmp_path: Path) -> None:
    """The normal of a layer is z or that of its axes, its thickness h; displacements are small."""
    old, _, new = change.partition("|")
    height = float(new) if old == "thickness" else 0.25
    z = (0.0, 1.0, 1.0 + height, 2.0 + height)
    axes = [2, 0, 1] if old == "axes" else [0, 1, 2]
    wedges = old == "C3D8"
    corners = ((0, 0), (1, 0), (1, 1), (0, 1))[: 3 if wedges else 4]
    x = np.array([[*corner, level] for level in z for corner in corners], float)[:, axes]
    text = "*NODE\n" + "".join(f"{n}, {a}, {b}, {c}\n" for n, (a, b, c) in enumerate(x.tolist(), 1))
    for k, name in enumerate(("LOWER", "JOINT", "UPPER")):
        nodes = range(k * len(corners) + 1, (k + 2) * len(corners) + 1)
        row = ", ".join(map(str, nodes))
        text += f"*ELEMENT, TYPE={'C3D6' if wedges else 'C3D8'}, ELSET={name}\n{k + 1}, {row}\n"
    text += "*MATERIAL, NAME=ROCK\n*ELASTIC\n1000., 0.2\n"
    text += "".join(f"*SOLID SECTION, ELSET={name}, MATERIAL=ROCK\n" for name in ("LOWER", "UPPER"))
    text += JOINT.card("calculix", name="JOINT", h=0.25) + TURNED + "*STEP\n*END STEP\n"
    if old == "axes" and "ORIENTATION" in new:
        old, new = "MATERIAL=ABAQUSJOINT", "MATERIAL=ABAQUSJOINT, ORIENTATION=ACROSS"
    (tmp_path / "job.inp").write_text(text.replace(old, new), encoding="utf-8")
    out, err = said(f"doctor {tmp_path / 'job.inp'}", code=int(bool(words)))
    assert words in out + err
