"""Texts of small meshes, and grids, that several of these files read."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
from asperity import Interface, Material, Pattern
from asperity.mesh import Joint, Jointed

from harness.hosts import structured

ROUNDING = 1.0e-9
"""Relative error of areas of files whose places have six decimals, and of instances turned about an axis."""


def placed(folder: Path, files: dict[str, str] | str, **included: str) -> Path:
    """Write files and return the main one, the last; a text is a deck, included: files NAME.inc beside."""
    if isinstance(files, str):
        files = {**{f"{name}.inc": text for name, text in included.items()}, "job.inp": files}
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder / list(files)[-1]


CUBE = """*Part, name=Cube
*Node
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 2.
6, 1., 0., 2.
7, 1., 1., 2.
8, 0., 1., 2.
*Element, type=c3d8r, elset=Stone
7, 1, 2, 3, 4,
5, 6, 7, 8
*Surface, type=ELEMENT, name=Foot
Stone, S1
*Surface, type=ELEMENT, name=Side
7, S3
*End Part
*Assembly, name=A
*Instance, name=One, part=Cube
*End Instance
*Instance, name=Two, part=Cube
3., 0., 2.
3., 0., 2., 4., 0., 2., 90.
*End Instance
*Nset, nset=Corner, instance=Two
1
*Elset, elset=Both
One.Stone, Two.7
*End Assembly
"""
"""A block 1 x 1 x 2, and the same moved by (3, 0, 2), then turned from y to z: its height is along -y."""


def groups(mesh: Jointed) -> dict[str, tuple[int, float]]:
    """Number and area of the faces of each surface, by the corners of its faces."""
    areas = {}
    for name, rows in mesh.surfaces.items():
        total = 0.0
        for nodes in mesh.face_nodes(rows):
            x = mesh.points[nodes]
            if x.shape[2] == 2:
                total += float(np.linalg.norm(x[:, 1] - x[:, 0], axis=1).sum())
            else:  # triangles from the first corner
                fan = np.cross(x[:, 1:-1] - x[:, :1], x[:, 2:] - x[:, :1])
                total += 0.5 * float(np.linalg.norm(fan, axis=2).sum())
        areas[name] = len(rows), total
    return areas


STRIP = """*Node
1, 0., 0.
2, 1., 0.
3, 0., 1.
4, 1., 1.
5, 0., 3.
6, 1., 3.
7, 0., 4.
8, 1., 4.
*Element, type=CPE4
1, 1, 2, 4, 3
2, 3, 4, 6, 5
3, 5, 6, 8, 7
*Elset, elset=ROCK
1
*Elset, elset=DAM
2, 3
"""


MSH = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
4
1 4 "foot"
1 5 "rim"
2 1 "rock"
2 2 "dam"
$EndPhysicalNames
$Entities
0 3 2 0
1 0 0 0 3 0 0 2 4 5 0
2 0 2 0 3 2 0 1 5 0
3 0 1 0 3 1 0 0 0
1 0 0 0 3 1 0 1 1 0
2 0 1 0 3 2 0 1 2 0
$EndEntities
$Nodes
1 6 11 16
2 1 0 6
11
12
13
14
15
16
0 0 0
3 0 0
0 1 0
3 1 0
0 2 0
3 2 0
$EndNodes
$Elements
5 5 1 5
1 1 1 1
1 11 12
1 2 1 1
2 15 16
1 3 1 1
3 13 14
2 1 3 1
4 11 12 14 13
2 2 3 1
5 13 14 16 15
$EndElements
"""
"""Two squares 3 x 1; the lowest edge is in two groups, the one between them in none."""


DIGITS = 1.0e-12
"""Rounding errors of areas and axes, of coordinates between 0 and 10."""


LAW = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5), Pattern.regular(0, 0.0))


def grid(n: tuple[int, ...], parts: tuple[int, ...]) -> meshio.Mesh:
    """n cells of length 1 along each axis, in parts x parts (x parts) blocks."""
    places = (place * count // size for place, count, size in zip(np.indices(n), parts, n, strict=True))
    block = np.ravel_multi_index(tuple(places), parts)
    return structured.grid(*(range(k + 1) for k in n), block=block, sides=())


def only(mesh: Jointed) -> Joint:
    """The only joint of a mesh."""
    ((joint,),) = mesh.joints.values()
    return joint
