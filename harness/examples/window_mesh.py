"""A wall with a window in gmsh: bricks in running bond, each a block; `window_mesh.py FILE.msh`."""

import itertools
import sys

import gmsh

L, H, courses = 240.0, 120.0, 8
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
bricks = []
for j in range(courses):
    ends = [0.0, *(L * (k + (1 - j % 2 / 2)) for k in range(3 + j % 2)), 4.0 * L]
    for x, end in itertools.pairwise(sorted(set(ends))):
        bricks.append((2, gmsh.model.occ.addRectangle(x, j * H, 0.0, end - x, H)))
window = [(2, gmsh.model.occ.addRectangle(1.25 * L, 2 * H, 0.0, 1.5 * L, 3 * H))]
lintel = [(2, gmsh.model.occ.addRectangle(L, 5 * H, 0.0, 2 * L, H))]
cut, _ = gmsh.model.occ.cut(bricks, window + lintel, removeTool=False)
gmsh.model.occ.remove(window)
gmsh.model.occ.fragment(cut, lintel)  # blocks that touch share their lines
gmsh.model.occ.synchronize()
for _, brick in gmsh.model.getEntities(2):
    gmsh.model.addPhysicalGroup(2, [brick], name=f"brick_{brick}")
for name, y in ("bottom", 0.0), ("top", courses * H):
    lines = gmsh.model.getEntitiesInBoundingBox(-1.0, y - 1.0, -1.0, 4 * L + 1.0, y + 1.0, 1.0, 1)
    gmsh.model.addPhysicalGroup(1, [line for _, line in lines], name=name)
gmsh.option.setNumber("Mesh.MeshSizeMax", 50.0)
gmsh.model.mesh.generate(2)
gmsh.write(sys.argv[1])
