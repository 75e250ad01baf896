"""Section of a gravity dam on rock with a fault, by gmsh; m."""

import sys

import gmsh

HEIGHT, BASE, CREST = 80.0, 60.0, 8.0


def mesh(path: str, size: float = 4.0) -> None:
    """Mesh two blocks, and a fault that begins at the surface and ends in the rock."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    g, far = gmsh.model.geo, 4.0 * size
    bed = [(0, 0, size), (BASE, 0, size), (160, 0, far), (160, -80, far), (-100, -80, far), (-100, 0, far)]
    rock = [g.addPoint(x, y, 0, h) for x, y, h in (*bed, (-40, 0, size))]
    crest = [g.addPoint(x, HEIGHT, 0, size) for x in (CREST, 0)]
    lines = [g.addLine(a, b) for a, b in zip(rock, rock[1:] + rock[:1], strict=True)]
    sides = [g.addLine(a, b) for a, b in ((rock[1], crest[0]), crest, (crest[1], rock[0]))]
    fault = g.addLine(rock[6], g.addPoint(20, -50, 0, size))
    solids = [g.addPlaneSurface([g.addCurveLoop(loop)]) for loop in (lines, [lines[0], *sides])]
    g.synchronize()
    gmsh.model.mesh.embed(1, [fault], 2, solids[0])
    for name, solid in zip(("rock", "dam"), solids, strict=True):
        gmsh.model.addPhysicalGroup(2, [solid], name=name)
    edges = {"fault": [fault], "upstream": sides[2:], "reservoir": lines[5:], "bottom": [lines[3]],
             "ends": [lines[2], lines[4]]}  # fmt: skip
    for name, curves in edges.items():
        gmsh.model.addPhysicalGroup(1, curves, name=name)
    gmsh.model.mesh.generate(2)
    gmsh.write(path)
    gmsh.finalize()


if __name__ == "__main__":
    mesh(sys.argv[1])
