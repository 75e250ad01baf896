"""Layers of solids that are joints in CalculiX: normal, thickness and steps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern

JOINT = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(2, theta=30.0))
H = 0.25
"""Thickness of the constants (PROPS 9)."""

ACROSS = "*ORIENTATION, NAME=ACROSS\n0., 1., 0., 0., 0., 1.\n"
"""Axes whose third one is x."""

TURNED = "MATERIAL=ABAQUSJOINT, ORIENTATION=ACROSS"
"""Section of a layer with these axes."""


def stack(height: float = H, axes: tuple[int, ...] = (0, 1, 2), corners: int = 4, tip: bool = False) -> str:
    """A layer of this height between two solids; axes: of the stack, the third one across the layer.

    corners: of the sides. tip: whether the sides of the layer meet at two corners.
    """
    places = np.array([[0, 0], [1, 0], [1, 1], [0, 1]][:corners], float)
    levels = (0.0, 1.0, 1.0 + height, 2.0 + height)
    x = np.concatenate([np.column_stack([places, np.full(corners, z)]) for z in levels])
    nodes = np.arange(1, 4 * corners + 1).reshape(4, corners)
    if tip:
        nodes[2, :2] = nodes[1, :2]
    text = "*NODE\n" + "".join(f"{n}, {a}, {b}, {c}\n" for n, (a, b, c) in enumerate(x[:, axes].tolist(), 1))
    for k, name in enumerate(("LOWER", "JOINT", "UPPER")):
        row = ", ".join(map(str, [*nodes[k], *nodes[k + 1]]))
        text += f"*ELEMENT, TYPE=C3D{2 * corners}, ELSET={name}\n{k + 1}, {row}\n"
    text += "*MATERIAL, NAME=ROCK\n*ELASTIC\n1000., 0.2\n"
    text += "".join(f"*SOLID SECTION, ELSET={name}, MATERIAL=ROCK\n" for name in ("LOWER", "UPPER"))
    return text + JOINT.card("calculix", name="JOINT", h=H) + ACROSS + "*STEP\n*END STEP\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (stack(), ""),
        (stack(corners=3), ""),
        (stack(tip=True), ""),
        (stack(0.01), "1 of 1 elements, as at (0.5, 0.5, 1), are 0.01 thick: expected 0.25 (PROPS 9)"),
        (stack(axes=(2, 0, 1)), "another normal than z: expected an *Orientation"),
        (stack(axes=(2, 0, 1)).replace("MATERIAL=ABAQUSJOINT", TURNED), ""),
        (stack().replace("MATERIAL=ABAQUSJOINT", TURNED), "another normal than the third axis of"),
        (stack().replace("MATERIAL=ABAQUSJOINT", TURNED).replace("0., 1.\n", "0., 1.\n2, 90.\n"), ""),
        (
            stack().replace("MATERIAL=ABAQUSJOINT", "MATERIAL=ABAQUSJOINT, ORIENTATION=TURN"),
            "no *Orientation has",
        ),
        (
            stack().replace(
                "9, 10, 11, 12\n*ELEMENT", "9, 10, 11, 12\n4, 5, 6, 7, 8, 9, 10, 11, 12\n*ELEMENT"
            ),
            "once",
        ),
        (
            stack().replace("9, 10, 11, 12, 13", "13, 14, 15, 16, 13"),
            "of the upper side are those of no solid",
        ),
        (
            stack().replace(
                "*MATERIAL, NAME=ROCK", "*EQUATION\n2\n5, 3, 1., 9, 3, -1.\n*MATERIAL, NAME=ROCK"
            ),
            "past",
        ),
        (stack().replace("*STEP", "*SOLID SECTION, ELSET=JOINT, MATERIAL=ROCK\n*STEP"), "in two sections"),
        (stack().replace("=ROCK", "=ABAQUSJOINT"), "of the lower side are those of no solid"),
        (stack().replace("*STEP", "*STEP, NLGEOM"), "NLGEOM: expected none"),
        (stack().replace("*STEP", "*STEP, NLGEOM=NO"), ""),
    ],
)
def test_layers_of_calculix(text: str, words: str, said, tmp_path: Path) -> None:
    """The normal of a layer is z or that of its axes, its thickness h; displacements are small.

    A layer ends at a tip; axes that a second line turns are not judged.
    """
    (tmp_path / "job.inp").write_text(text, encoding="utf-8")
    out, err = said(f"doctor {tmp_path / 'job.inp'}", code=int(bool(words)))
    assert words in out + err
