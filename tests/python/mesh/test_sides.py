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


DRAWN = 20
"""Drawn files of each kind."""


def curved(draw: np.random.Generator, d: int) -> tuple[meshio.Mesh, list[str]]:
    """Cells around an axis, one block, and a fault at the middle radius in parts whose faces are as drawn."""
    n, closed = int(draw.integers(6, 14)), bool(draw.random() < 0.5)
    turns = 2.0 * np.pi if closed else float(draw.uniform(1.0, 5.5))
    angle = float(draw.uniform(0.0, 6.0)) + turns * np.linspace(0.0, 1.0, n + 1)
    radii, heights = (1.0, 2.0, 3.0), range(3 if d == 3 else 1)
    columns = n if closed else n + 1
    number = np.arange(len(heights) * len(radii) * columns).reshape(len(heights), len(radii), columns)
    points = [[r * np.cos(a), r * np.sin(a), h] for h in heights for r in radii for a in angle[:columns]]
    cells, faces = [], []
    for k in range(n):
        a, b = k, (k + 1) % columns
        for h in range(max(len(heights) - 1, 1)):
            for r in range(2):
                flat = [number[h, r, a], number[h, r + 1, a], number[h, r + 1, b], number[h, r, b]]
                cells.append(flat + [node + number[0].size for node in flat] if d == 3 else flat)
            low = [number[h, 1, a], number[h, 1, b]]
            faces.append((k, low + [node + number[0].size for node in low[::-1]] if d == 3 else low))
    cuts = np.sort(draw.choice(np.arange(1, n), int(draw.integers(1, 4)), replace=False))
    part = [int(np.searchsorted(cuts, k, "right")) for k, _ in faces]
    order = draw.permutation(len(faces))
    data = np.array([faces[k][1] for k in order])
    data = np.array([row[::-1] if draw.random() < 0.5 else row for row in data])
    names = [f"part_{k}" for k in range(len(cuts) + 1)]
    tags = [np.ones(len(cells), int), np.array([part[k] + 2 for k in order])]
    field = {name: np.array([k + 2, d - 1]) for k, name in enumerate(names)} | {"rock": np.array([1, d])}
    kinds = ("hexahedron", "quad") if d == 3 else ("quad", "line")
    mesh = meshio.Mesh(
        np.array(points), list(zip(kinds, (np.array(cells), data), strict=True)),
        cell_data={"gmsh:physical": tags}, field_data=field,
    )  # fmt: skip
    return mesh, names


@pytest.mark.parametrize("d", [2, 3])
def test_curved_fault_in_parts(d: int) -> None:
    """N of an arc or a ring is on one side along all of its parts, whatever the nodes of their faces."""
    for seed in range(DRAWN):
        draw = np.random.default_rng([seed, d])
        mesh, names = curved(draw, d)
        jointed = split(mesh, dict.fromkeys(draw.permutation(names).tolist()))
        outward = [
            float(np.sign(n @ x))
            for (joint,) in jointed.joints.values()
            for n, x in zip(joint.axes[:, 0, :2], jointed.points[joint.minus].mean(1)[:, :2], strict=True)
        ]
        assert len(outward) == sum(len(block.data) for block in mesh.cells[1:])
        assert abs(sum(outward)) == len(outward), seed


@pytest.mark.parametrize("d", [2, 3])
def test_many_blocks(d: int) -> None:
    """N of all faces between stones in any order is on one side along each bed and each through joint.

    It is that of the later stones, by area; heads that end at beds are parts of their own.
    """
    for seed in range(DRAWN):
        draw = np.random.default_rng([seed, d, 2])
        axes = [np.cumsum([0.0, *draw.uniform(0.5, 2.0, 2 * int(draw.integers(2, 4)))]) for _ in range(d)]
        cells = [len(x) - 1 for x in axes]
        at = list(np.indices(cells))
        bond = bool(draw.random() < 0.5)  # every other row is shifted by half a stone
        shift = at[-1] // 2 % 2 if bond else 0
        stone = np.ravel_multi_index(
            [(at[0] + shift) // 2, *(k // 2 for k in at[1:])],
            [cells[0] // 2 + 1, *(n // 2 for n in cells[1:])],
        )
        _, stone = np.unique(stone, return_inverse=True)
        number = draw.permutation(stone.max() + 1)[stone.ravel()].reshape(cells)
        jointed = split(structured.grid(*axes, block=number + 1, sides=()))
        total: dict[tuple[int, float, int], float] = {}
        signs: dict[tuple[int, float, int], set[float]] = {}
        (joint,) = jointed.joints["joint"]
        block = np.concatenate(list(jointed.block.values()))
        for N, nodes, area, pair in zip(
            joint.axes[:, 0], joint.minus, joint.area, block[joint.cells], strict=True
        ):
            axis = int(np.abs(N).argmax())
            later = float(np.sign(N[axis]) * np.sign(pair[1] - pair[0]))
            x = jointed.points[nodes].mean(0)
            row = int(np.searchsorted(axes[-1][::2], x[-1])) if bond and axis == 0 else 0
            line = axis, float(x[axis].round(9)), row
            total[line] = total.get(line, 0.0) + float(area) * later
            signs.setdefault(line, set()).add(float(np.sign(N[axis])))
        assert len(total) >= sum(n // 2 - 1 for n in cells[1:]) + (cells[0] // 2 - 1)
        for line, found in signs.items():
            [sign] = found
            assert total[line] * sign > 0.0, (seed, line)


@pytest.mark.parametrize("d", [2, 3])
def test_ring_between_blocks(d: int) -> None:
    """N between segments and rock is on one side, whatever the order of their groups."""
    for seed in range(DRAWN):
        draw = np.random.default_rng([seed, d, 1])
        mesh, _ = curved(draw, d)
        cells = mesh.cells[0].data
        inner = np.linalg.norm(mesh.points[cells].mean(1)[:, :2], axis=1) < 1.6
        segments = 2 + np.arange(len(cells)) * 3 // len(cells)
        tags = np.where(
            inner, segments, int(draw.integers(1, 6)) + 0.5
        )  # of the rock between those of others
        numbers = np.unique(tags, return_inverse=True)[1].ravel() + 1
        named = {
            f"lining_{k}" if inner[numbers == k].all() else "rock": np.array([k, d]) for k in set(numbers)
        }
        ring = meshio.Mesh(
            mesh.points, mesh.cells[:1], cell_data={"gmsh:physical": [numbers]}, field_data=named
        )
        jointed = split(ring, {"ring": ("lining*", "rock")})
        (joint,) = jointed.joints["ring"]
        x = np.einsum("fd,fd->f", joint.axes[:, 0, :2], jointed.points[joint.minus].mean(1)[:, :2])
        assert abs(np.sign(x).sum()) == len(x), seed


def test_direction_along_a_ring() -> None:
    """A direction that would turn N to the other side is refused; along an arc it sets the sides."""
    angles = np.linspace(0.1, 2.0 * np.pi + 0.1, 13)
    for last, words in ((12, "by its direction N of . of 12 connected faces is on the other side"), (5, "")):
        number = np.arange(39).reshape(3, 13)
        points = np.array([[r * np.cos(a), r * np.sin(a)] for r in (1.0, 2.0, 3.0) for a in angles])
        number[:, 12] = number[:, 0]
        cells = [
            [number[r, k], number[r + 1, k], number[r + 1, k + 1], number[r, k + 1]]
            for r in range(2) for k in range(12)
        ]  # fmt: skip
        line = np.stack([number[1, :last], number[1, 1 : last + 1]], 1)
        mesh = meshio.Mesh(
            points, [("quad", np.array(cells)), ("line", line)],
            cell_data={"gmsh:physical": [np.ones(24, int), np.full(last, 2)]},
            field_data={"rock": np.array([1, 2]), "fault": np.array([2, 1])},
        )  # fmt: skip
        if words:
            with pytest.raises(ValueError, match=words):
                split(mesh, {"fault": None}, direction=(1.0, 0.0))
        else:
            (joint,) = split(mesh, {"fault": None}, direction=(1.0, 0.0)).joints["fault"]
            assert (joint.axes[:, 0, 1] > 0.0).all()
