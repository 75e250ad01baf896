"""Joints in meshes: what is doubled where, axes and areas, refusals."""

from __future__ import annotations

import itertools
from contextlib import nullcontext
from pathlib import Path

import meshio
import numpy as np
import pytest
from asperity import ModelWarning
from asperity.mesh import split, write
from asperity.mesh.shapes import FACES
from scipy.spatial import Delaunay

from harness.hosts import structured
from mesh.support_meshes import DIGITS, grid, only


def random_mesh(d: int, seed: int) -> meshio.Mesh:
    """Triangles or tetrahedra of random points, in random blocks."""
    draw = np.random.default_rng(seed)
    points = draw.uniform(0.0, 10.0, (60, d))
    cells = Delaunay(points).simplices
    kind = "triangle" if d == 2 else "tetra"
    return meshio.Mesh(points, [(kind, cells)], cell_data={"block": [draw.integers(0, 4, len(cells))]})


def groups_of_cells(cells: np.ndarray, block: np.ndarray, d: int) -> int:
    """Nodes of a split mesh, by a search around each node over faces inside blocks."""
    count = 0
    for node in np.unique(cells):
        left = {int(k) for k in np.flatnonzero((cells == node).any(1))}
        while left:
            count, wave = count + 1, [left.pop()]
            while wave:
                cell = wave.pop()
                next_ = {
                    k for k in left if block[k] == block[cell]
                    and len(shared := set(cells[k]) & set(cells[cell])) == d and node in shared
                }  # fmt: skip
                left -= next_
                wave += next_
    return count


@pytest.mark.parametrize(("d", "seed"), [(2, 1), (2, 2), (3, 3), (3, 4)])
def test_random_blocks(d: int, seed: int) -> None:
    """Nodes by a search cell by cell; areas, normals and sides of all faces between random blocks."""
    mesh = random_mesh(d, seed)
    cells, block = mesh.cells[0].data, mesh.cell_data["block"][0]
    size = np.linalg.det(np.diff(mesh.points[cells], axis=1))
    with pytest.warns(ModelWarning, match="cells of negative") if (size < 0.0).any() else nullcontext():
        jointed = split(mesh, {"joint": lambda a, b, x, n: np.ones(len(a), bool)})
    joint = only(jointed)
    assert len(jointed.points) == groups_of_cells(cells, block, d)
    new = next(iter(jointed.cells.values()))
    assert (np.sort(jointed.origin[new]) == np.sort(cells)).all()
    assert (jointed.points == mesh.points[jointed.origin]).all()
    between = {
        (a, b) for a, b in itertools.combinations(range(len(cells)), 2)
        if block[a] != block[b] and len(set(cells[a]) & set(cells[b])) == d
    }  # fmt: skip
    assert {tuple(sorted(pair)) for pair in joint.cells.tolist()} == between
    for side, nodes in enumerate((joint.minus, joint.plus)):
        assert all(
            set(face) <= set(new[cell]) for face, cell in zip(nodes, joint.cells[:, side], strict=True)
        )
    assert (jointed.origin[joint.minus] == jointed.origin[joint.plus]).all()
    N, x = joint.axes[:, 0], jointed.points[joint.minus]
    centre = mesh.points[cells].mean(1)
    assert (np.einsum("fd,fd->f", N, centre[joint.cells[:, 1]] - x.mean(1)) > 0.0).all()
    assert np.abs(joint.axes @ joint.axes.transpose(0, 2, 1) - np.eye(d)).max() <= DIGITS
    edge = x[:, 1] - x[:, 0]
    right = np.stack([-edge[:, 1], edge[:, 0]], 1) if d == 2 else np.cross(edge, x[:, 2] - x[:, 0]) / 2
    assert np.abs(joint.area[:, None] * N - right).max() <= 1e2 * DIGITS
    assert (block[joint.cells[:, 0]] < block[joint.cells[:, 1]]).all()


def test_joint_that_ends_inside() -> None:
    """A named line inside one block: its ends keep one node each, the nodes between are doubled."""
    mesh = grid((6, 4), (1, 1))
    line = np.stack([np.arange(1, 4), np.arange(2, 5)], 1) * 5 + 2  # from (1, 2) to (4, 2)
    mesh = meshio.Mesh(
        mesh.points, [*mesh.cells, ("line", line)],
        cell_data={"gmsh:physical": [np.ones(24, int), np.full(3, 2)]},
        field_data={"rock": np.array([1, 2]), "fault": np.array([2, 1])},
    )  # fmt: skip
    jointed = split(mesh, {"fault": None})
    joint = only(jointed)
    assert len(jointed.points) == 35 + 2 and joint.tips == 2
    assert np.abs(joint.axes[:, 0] - [0.0, 1.0]).max() <= DIGITS  # upwards, for every face
    assert np.abs(joint.axes[:, 1] - [1.0, 0.0]).max() <= DIGITS
    left = only(split(mesh, {"fault": None}, direction=(-1.0, 0.0)))
    assert np.abs(left.axes - [[0.0, -1.0], [-1.0, 0.0]]).max() <= DIGITS
    with pytest.raises(ValueError, match=r"joint fault: direction .* is normal to 3 of its 3 faces"):
        split(mesh, {"fault": None}, direction=(0.0, 1.0))


def test_laws_by_rule(tmp_path: Path) -> None:
    """Faces belong to the first rule that holds: a function of normals, then patterns."""
    mesh = grid((4, 4), (2, 2))
    jointed = split(mesh, {"head": lambda a, b, x, n: np.abs(n[:, 0]) > 0.5, "bed": ("block_*", "*")})
    head, bed = (parts[0] for parts in jointed.joints.values())
    assert (head.area.sum(), bed.area.sum()) == (4.0, 4.0)
    assert np.abs(head.axes[:, 0] @ [1.0, 0.0]) == pytest.approx(1.0)
    lower = split(mesh, {"low": ("block_0", "block_2")})
    assert only(lower).area.sum() == 2.0 and only(lower).tips == 1
    assert lower.summary().splitlines()[-1] == (
        "joint low: 2 faces, length 2, 1 tips, N from block_0 to block_2"
    )
    with pytest.warns(ModelWarning, match="joint low ends inside the mesh, where its layer has no thickness"):
        write(tmp_path / "wall.vtu", lower, "ogs", layer=0.01)


def test_directions_in_space() -> None:
    """Tx is the projection of the direction, and the edge from node 0 to node 1 is the closest to it."""
    mesh = grid((3, 3, 2), (1, 1, 2))
    direction = np.array([1.0, 2.0, 5.0])
    joint = only(split(mesh, direction=direction))
    assert np.abs(joint.axes[:, 1] - np.array([1.0, 2.0, 0.0]) / 5**0.5).max() <= DIGITS
    x = mesh.points[split(mesh).origin][joint.minus]
    assert np.abs(x[:, 1] - x[:, 0] - [0.0, 1.0, 0.0]).max() == 0.0
    assert np.abs(only(split(mesh)).axes - np.eye(3)[[2, 0, 1]]).max() <= DIGITS
    mixed = only(split(grid((2, 1, 1), (2, 1, 1))))
    assert np.abs(mixed.axes - np.eye(3)[[0, 2, 1]] * [[1.0], [1.0], [-1.0]]).max() <= DIGITS


def test_middles_of_quadratic_faces() -> None:
    """A node of a face beyond its corners is in the middle of the edge after the corner with its place."""
    for kind, text in structured.QUADRATIC.items():
        pairs = [tuple(map(int, word)) for word in text.split()]
        first = pairs[-1][1] + 1 if kind in ("tetra10", "hexahedron20") else len(pairs)
        for face in FACES[kind]:
            c = {3: 2, 6: 3, 8: 4}[len(face)]
            for k, middle in enumerate(face[c:]):
                assert set(pairs[middle - first]) == {face[k], face[(k + 1) % c]}


def test_quadratic_joint() -> None:
    """Middles of edges are doubled, too, and stay node on node."""
    points = np.array([[x, y] for y in (0, 1, 2) for x in (0, 1, 2)], float)
    cells = [[0, 2, 6, 1, 4, 3], [2, 8, 6, 5, 7, 4]]
    mesh = meshio.Mesh(points, [("triangle6", cells)], cell_data={"part": [np.array([1, 2])]})
    jointed = split(mesh)
    joint = only(jointed)
    for host in ("abaqus", "ogs"):
        with pytest.raises(ValueError, match=f"1 faces of 3 nodes: expected linear ones for {host}"):
            write(Path("wall"), jointed, host, layer=0.1 * (host == "ogs"))
    assert len(jointed.points) == 12 and joint.area[0] == pytest.approx(8**0.5)
    assert jointed.origin[joint.minus].tolist() == jointed.origin[joint.plus].tolist() == [[6, 2, 4]]


def test_groups_follow_their_cells() -> None:
    """Faces of a group on the outside have the nodes of the cell beside them."""
    mesh = structured.grid(range(5), range(3), block=[[1], [1], [2], [2]])
    jointed = split(mesh)
    assert jointed.names == ["block_1", "block_2"]
    assert len(jointed.nodes("top")) == 6 and (jointed.points[jointed.nodes("top"), 1] == 2.0).all()
    with pytest.raises(ValueError, match="base: no such group: expected one of top, bottom, right, left"):
        jointed.nodes("base")


@pytest.mark.parametrize(
    ("joints", "words"),
    [
        ({"block_1": ("*", "*")}, "joint block_1: a block has this name: expected another one"),
        ({"bed": None}, "joint bed: bed: no such group of faces: expected one of top"),
        ({"top": None}, "joint top: 2 of its 2 faces have a cell on one side only"),
        ({"bed": ("brick", "*")}, r"joint bed: 0 of the 2 faces between blocks.*Blocks: block_1, block_2"),
        ({"bed": ("*", "*"), "rest": ("*", "block_2")}, "rules before it have taken all of its 2 faces"),
    ],
)
def test_errors(joints: dict[str, object], words: str) -> None:
    """They name the joint, the group and the number of faces."""
    mesh = structured.grid(range(3), range(3), block=[1, 2])
    with pytest.raises(ValueError, match=words):
        split(mesh, joints)  # type: ignore[arg-type]


@pytest.mark.parametrize("d", [2, 3])
def test_joint_across_a_period(d: int) -> None:
    """Each node on the right has that on the left as its partner, N points out, inner joints stay."""
    mesh = structured.grid(*(range(5), range(3), range(3))[:d], block=[[0], [1]] if d == 3 else [0, 1])
    jointed = split(mesh, {"head": {"right": "left"}, "bed": ("*", "*")})
    ((head,), (bed,)) = jointed.joints.values()
    minus, plus = jointed.points[head.minus], jointed.points[head.plus]
    assert (minus[..., 0] == 4.0).all() and (minus - plus == 4.0 * np.eye(d)[0]).all()
    assert head.area.sum() == 2.0 ** (d - 1) and (head.axes[:, 0] == np.eye(d)[0]).all()
    assert bed.area.sum() == 4.0 * 2.0 ** (d - 2) and len(jointed.points) == len(split(mesh).points)
    centres = [jointed.points[next(iter(jointed.cells.values()))].mean(1)[k] for k in head.cells.T]
    assert (centres[0][:, 0] == 3.5).all() and (centres[1][:, 0] == 0.5).all()
    # the other sense of Tx has the sides in the other order in the plane
    if d == 2:
        turned = split(mesh, {"head": {"right": "left"}}, direction=(0.0, 1.0)).joints["head"][0]
        assert (jointed.points[turned.minus][..., 0] == 0.0).all() and (turned.axes[:, 0, 0] == -1.0).all()
    for host in ("abaqus", "ogs"):
        with pytest.raises(ValueError, match=f"joint head: its sides are .* apart.*for {host}"):
            write(Path("wall"), jointed, host, layer=0.1 * (host == "ogs"))
    mesh.points[mesh.points[:, 0] == 0.0, 1] *= 1.1
    with pytest.raises(ValueError, match=r"joint head: \d of the \d faces of right and left have no partner"):
        split(mesh, {"head": {"right": "left"}})
    with pytest.raises(ValueError, match="joint head: base: no such group of faces"):
        split(mesh, {"head": {"right": "base"}})


# --- files ------------------------------------------------------------------------------------------------
