"""Sides of faults inside a block: stairs, ends, crossings and branches, on cubes in closed form."""

from __future__ import annotations

import meshio
import numpy as np
import pytest
from asperity.mesh import split
from asperity.mesh.sides import one_sided

from harness.hosts import structured


def fault(faces: list[list[int]], n: int = 4, kinds: str = "quad") -> meshio.Mesh:
    """A cube of n x n x n cells in one block with named faces, whose nodes are numbered (x, y, z)."""
    mesh = structured.grid(*[range(n + 1)] * 3, block=1, names={"rock": 1}, sides=())
    number = np.arange((n + 1) ** 3).reshape([n + 1] * 3)
    data = np.array([[number[tuple(at)] for at in face] for face in faces])
    tags = [*mesh.cell_data["gmsh:physical"], np.full(len(data), 2)]
    field = mesh.field_data | {"fault": np.array([2, 2])}
    cells = [*mesh.cells, (kinds, data)]
    return meshio.Mesh(mesh.points, cells, cell_data={"gmsh:physical": tags}, field_data=field)


def square(axis: int, at: int, a: int, b: int) -> list[list[int]]:
    """Corners of a face of a cell, normal to an axis."""
    around = [[a, b], [a + 1, b], [a + 1, b + 1], [a, b + 1]]
    return [[*corner[:axis], at, *corner[axis:]] for corner in around]


def test_one_side_of_a_fault() -> None:
    """Faces with any first node and sense have N on one side along a stair, and each part its own."""
    draw = np.random.default_rng(5)
    stair = [square(2, 1, a, b) for a in (0, 1) for b in range(4)]
    stair += [square(0, 2, b, 1) for b in range(4)]  # up from z = 1 to 2 at x = 2
    stair += [square(2, 2, a, b) for a in (2, 3) for b in range(4)]
    for _ in range(5):
        faces = []
        for face in (stair[k] for k in draw.permutation(len(stair))):
            turned = np.roll(face, int(draw.integers(4)), axis=0)
            faces.append((turned if draw.random() < 0.5 else turned[::-1]).tolist())
        mesh = split(fault(faces), {"fault": None})
        (joint,) = mesh.joints["fault"]
        normal = joint.axes[:, 0]
        flat = np.abs(normal[:, 2]) == 1.0
        assert flat.sum() == 16 and (normal[flat, 2] == 1.0).all() and (normal[~flat, 0] == -1.0).all()
        assert joint.area.sum() == 20.0 and joint.tips == 0
        assert len(mesh.points) == 125 + 6 * 5 and "N inside rock about (-0.2, 0, 0.8)" in mesh.summary()


def test_fault_that_ends_inside() -> None:
    """Nodes on the front of a fault are not doubled; those inside it and on the outside of the mesh are."""
    mesh = split(fault([square(1, 2, a, b) for a in (0, 1) for b in (1, 2)]), {"fault": None})
    (joint,) = mesh.joints["fault"]
    doubled = mesh.points[joint.minus[joint.minus != joint.plus]]
    assert {tuple(point) for point in doubled.tolist()} == {(0.0, 2.0, 2.0), (1.0, 2.0, 2.0)}
    assert len(mesh.points) == 125 + 2 and joint.tips == 7
    with pytest.raises(ValueError, match="joint fault: 1 of its 1 faces end with all their nodes inside"):
        split(fault([square(1, 2, 1, 1)]), {"fault": None})
    closed = split(fault([square(axis, at, 1, 1) for axis in range(3) for at in (1, 2)]), {"fault": None})
    (joint,) = closed.joints["fault"]
    out = closed.points[joint.minus].mean(1) - 1.5
    assert np.abs(joint.axes[:, 0] - 2.0 * out).max() == 0.0  # N points out of a closed surface
    assert joint.tips == 0 and len(closed.points) == 125 + 8


def test_crossing_and_branching_faults() -> None:
    """At a line where three or four faces meet, flat ones go on; a branch has a side of its own."""
    flat = [square(2, 2, a, b) for a in range(4) for b in range(4)]
    wall = [square(0, 2, b, c) for b in range(4) for c in (2, 3)]
    (joint,) = split(fault(flat + wall), {"fault": None}).joints["fault"]
    level = joint.axes[:, 0, 2] != 0.0
    assert level.sum() == 16 and (joint.axes[level, 0, 2] == 1.0).all()
    assert (joint.axes[~level, 0, 0] == 1.0).all()
    assert len(split(fault(flat + wall), {"fault": None}).points) == 125 + 25 + 15


def test_no_two_sides() -> None:
    """The Moebius strip of five triangles has no two sides, and without one of them it has."""
    around = np.array([[k, (k + 1) % 5, (k + 2) % 5] for k in range(5)])
    ends = np.concatenate([np.stack([around[:, k], around[:, (k + 1) % 3]], 1) for k in range(3)])
    sense = np.where(ends[:, 0] < ends[:, 1], 1, -1)
    rim = np.column_stack([np.sort(ends, axis=1), sense, np.tile(np.arange(5), 3)])
    n, middle, points = np.zeros((5, 3)), np.zeros((5, 3)), np.zeros((5, 3))
    assert one_sided(rim, n, middle, points)[2].tolist() == [0, 1, 2, 3, 4]
    sign, part, bad = one_sided(rim[rim[:, 3] < 4], n[:4], middle[:4], points)
    assert len(bad) == 0 and np.abs(sign).tolist() == [1.0] * 4 and len(set(part.tolist())) == 1
