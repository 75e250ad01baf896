"""Checks of the files for ParaView: the law on their separations, and the places of the points."""

from __future__ import annotations

from pathlib import Path

import joint_picture
import numpy as np
from asperity import Interface
from numpy.typing import NDArray

Floats = NDArray[np.float64]

GAUSS = 0.1
"""Accepted difference of the dilation of a point and the jump of the displacements in the middle of its cell.

It is relative to the largest variation of the dilation in an element.  Gauss points lie within 0.06 of the
length of an element from the middles of their cells; points in a wrong order differ by more than half of it.
"""


def fields(pvd: Path) -> dict[str, Floats]:
    """Fields of the joints in all steps, (T, points, ...), and `separation` (T, points, 3)."""
    joints = [joints for _, _, joints in joint_picture.read(pvd)]
    found = {name: np.array([one.cell_data[name][0] for one in joints]) for name in joints[0].cell_data}
    return found | {"separation": np.concatenate([found["dilation"][..., None], found["slip"]], axis=2)}


def against_the_law(pvd: Path, law: Interface, tolerance: float) -> dict[str, Floats]:
    """Compare the fields of every point with the library on its separations; the first step begins at zero.

    tolerance is relative to the strength, to 1 (damage), and to strength times the largest separation.
    """
    found = fields(pvd)
    separation, sigma0 = found["separation"], law.material.sigma0
    scales = {"traction": sigma0, "damage": 1.0}
    for name in ("stored", "rupture", "friction"):
        scales[name] = sigma0 * float(np.abs(separation).max())
    for k in range(separation.shape[1]):
        expected = law.replay(separation[:, k])
        for name, scale in scales.items():
            assert np.abs(found[name][:, k] - getattr(expected, name)).max() <= tolerance * scale, (name, k)
    return found


def places(pvd: Path, points: int, up: int, layers: int = 1, away: float = GAUSS) -> None:
    """Compare the dilation with the displacements of the nodes: points of a joint are where their cells are.

    points: of an element.  up: axis of the normal.  layers: cells between the faces of the joint.  away: see
    GAUSS.
    """
    worst = scale = 0.0
    for _, _, joints in joint_picture.read(pvd):
        (block,) = joints.cells
        u = joints.point_data["displacement"][block.data][..., up]
        half = u.shape[1] // 2
        jump = layers * (u[:, half:].mean(axis=1) - u[:, :half].mean(axis=1))
        dilation = joints.cell_data["dilation"][0]
        worst = max(worst, float(np.abs(np.abs(jump) - np.abs(dilation)).max()))
        scale = max(scale, float(np.ptp(dilation.reshape(-1, points), axis=1).max()))
    print(f"dilation less jump of the displacements {worst:.2e}, variation in an element {scale:.2e}")
    assert worst <= away * scale
