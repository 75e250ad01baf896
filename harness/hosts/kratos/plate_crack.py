"""The benchmarks of ../python/crack.py in Kratos, compared with scikit-fem.

Both have the same mesh, quadratic elements and loads, and the interface points at the nodes.  As a script this
module prints the errors of slip and opening beside the closed forms, and the differences.
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

TOLERANCE = 1.0e-10
"""Residual force over the largest nodal load."""

SEPARATION_BOUND = 1.0e-7
"""Most that the separations of the codes may differ by, mm.

Far elements are large, so that the largest nodal load is some 5e6 N/mm.  A force of 1e-10 of it, which Newton's
iterations may leave out of balance, moves the face of the crack by about 4/E' times itself.
"""

COUNTER_CLOCKWISE = [0, 3, 2, 1, 7, 6, 5, 4, 8]
"""Nodes of an element of the mesh in the order of Kratos: corners, middles of the edges, middle."""


def run(kind: str, n: int) -> crack.Crack:
    """Solve a benchmark with n elements along the crack."""
    plate = crack.plate(kind, n, nodal=True)
    s = Structure(2)
    solid, joint_law = s.elastic(crack.MODULUS, crack.POISSON), s.umat(crack.interface(kind))
    unknowns = plate.bonded.indices  # of the plate, for each of both halves
    places = np.zeros((plate.bonded.shape[1], 2))
    places[unknowns] = np.concatenate([basis.doflocs.T for basis in plate.bases])
    nodes = np.repeat(s.add_nodes(places[::2]), 2)  # unknowns come in pairs x, y
    faces: list[dict[float, int]] = []
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
    python = crack.run(kind, (len(kratos.x) // 3), nodal=True)
    return float(np.abs(kratos.separation - python.separation).max())


def main() -> None:
    """Run all benchmarks in both codes and print the rows of the page."""
    parser = argparse.ArgumentParser(description="Crack in a large plate in Kratos against scikit-fem.")
    parser.add_argument(
        "--elements", type=int, nargs="+", default=crack.MESHES, help="along the crack, even, rising"
    )
    options = parser.parse_args()
    for n in options.elements:
        if n < 2 or n % 2:
            parser.error(f"--elements {n}: expected even numbers > 0")
    print("benchmark | L2 errors, % | orders | traction at s = 0, MPa | differences, mm")
    for kind in crack.STEPS:
        cracks = {n: run(kind, n) for n in options.elements}
        errors = [one.error(kind) for one in cracks.values()] if kind != "height" else []
        orders = [
            math.log(errors[i] / errors[i + 1]) / math.log(options.elements[i + 1] / options.elements[i])
            for i in range(len(errors) - 1)
        ]
        finest = cracks[options.elements[-1]]
        print(
            f"| {kind} | " + " | ".join(f"{100 * error:.2f}" for error in errors),
            ", ".join(f"{order:.2f}" for order in orders),
            f"{finest.traction[np.abs(finest.x).argmin(), 0]:.4f}",
            ", ".join(f"{difference(kind, one):.0e}" for one in cracks.values()) + " |",
            sep=" | ",
        )


if __name__ == "__main__":
    main()
