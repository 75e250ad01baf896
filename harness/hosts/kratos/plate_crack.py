"""The benchmarks of ../python/crack.py in Kratos, compared with scikit-fem.

Both have the same mesh, quadratic elements, loads and interface points (the nodes).  As a script this module
prints the errors of slip and opening against the closed forms, and the differences.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path

import numpy as np
from kratos_model import Structure

sys.path.insert(0, str(Path(__file__).parent.parent / "python"))
import crack
import joint

TOLERANCE = 1.0e-13
"""Residual force over the largest nodal load; it is the root of the mean square over all components."""

SEPARATION_BOUND = 1.0e-7
"""Most that the separations of the codes may differ by, mm.

Far elements are large, so that the largest nodal load is some 3e6 N/mm.  A force of 1e-10 of it, which
scikit-fem may leave out of balance, moves the face of the crack by about 4/E' times itself, 5e-8 mm.
"""

COUNTER_CLOCKWISE = [0, 3, 2, 1, 7, 6, 5, 4, 8]
"""Nodes of an element of the mesh in the order of Kratos: corners, middles of the edges, middle."""


def run(kind: str, n: int) -> crack.Crack:
    """Solve a benchmark with n elements along the crack."""
    plate = crack.plate(kind, n, nodal=True)
    s = Structure(2)
    solid, joint_law = s.elastic(crack.MODULUS, crack.POISSON), s.umat(crack.interface(kind))
    unknowns = plate.bonded.indices  # that of the plate for each of both halves
    places = np.zeros((plate.bonded.shape[1], 2))
    places[unknowns] = np.concatenate([basis.doflocs.T for basis in plate.bases])
    nodes = np.repeat(s.add_nodes(places[::2]), 2)  # unknowns come in pairs x, y
    faces = []
    for half, basis in enumerate(plate.bases):
        number = nodes[unknowns[half * basis.N : (half + 1) * basis.N]]
        for element in basis.element_dofs[::2].T:
            s.add_solid(number[element[COUNTER_CLOCKWISE]], solid)
        x, y = basis.doflocs[:, ::2]
        at = np.flatnonzero((np.abs(y) < 1e-9 * crack.B) & (np.abs(x) < crack.B * (1 + 1e-9)))
        faces.append(number[::2][at[np.argsort(x[at])]])
    upper, lower = faces
    for i in range(0, len(upper) - 1, 2):
        corners_middle = [i, i + 2, i + 1]
        s.add_interface(lower[corners_middle], upper[corners_middle], joint_law)
    for unknown in plate.fixed:
        s.fix(nodes[unknown], int(unknown % 2))
    forces = plate.load.reshape(-1, 2)
    loaded = np.flatnonzero(forces.any(axis=1))
    s.load({nodes[2 * i]: (0.0, 0.0, 0.0) for i in loaded})
    iterations = 0
    for k in range(crack.STEPS[kind]):
        for i in loaded:
            s.set_load(nodes[2 * i], (*((k + 1) / crack.STEPS[kind] * forces[i]), 0.0))
        iterations += len(s.step(TOLERANCE * np.abs(forces).max()))
        joint.progress(f"Kratos: {kind}, {n} elements, {iterations} iterations")
    joint.progress("")
    return crack.Crack(plate.joint.x, plate.joint.weights, *s.points(), iterations)


def difference(kind: str, kratos: crack.Crack) -> float:
    """Return the largest difference from the separations in scikit-fem, mm; the points are the nodes, too."""
    python = crack.run(kind, len(kratos.x) // 3, nodal=True)
    return float(np.abs(kratos.separation - python.separation).max())


def main() -> None:
    """Run all benchmarks in both codes and print the rows of the page."""
    argparse.ArgumentParser(description="Crack in a large plate in Kratos against scikit-fem.").parse_args()
    print("benchmark  elements  L2 error, %  order  difference, mm  traction at s = 0, MPa  its error, %")
    for kind in crack.STEPS:
        before = math.nan
        for n in crack.MESHES if kind != "height" else crack.MESHES[:2]:
            found = run(kind, n)
            error = found.error(kind) if kind != "height" else math.nan
            uniform = found.normal_error(kind) if kind in ("friction", "dilation") else math.nan
            normal = found.traction[np.abs(found.x).argmin(), 0]
            print(
                f"{kind:9}{n:10}{100 * error:13.2f}{math.log2(before / error):7.2f}"
                f"{difference(kind, found):16.0e}{normal:24.4f}{100 * uniform:14.3f}"
            )
            before = error


if __name__ == "__main__":
    main()
