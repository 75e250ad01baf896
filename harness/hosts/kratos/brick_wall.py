"""The wall J4D of ../petsc in Kratos: the same half-bricks, joints, loads and viscous damage."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from asperity import Pattern
from kratos_model import Floats, Lost, Structure

sys.path.insert(0, str(Path(__file__).parent.parent / "petsc"))
from masonry import WALLS, Mesh, laws

TOLERANCE = 1e-4
"""Residual force, N, for a thickness of 1; the reactions of the wall are some 100 N."""

LEAST_STEP, FAST = 1e-4, 6
"""Least step, mm; a step grows after at most FAST iterations."""


def model(name: str, elements: Sequence[int], tau: float) -> tuple[Structure, Mesh, np.ndarray]:
    """The wall under its pressure, its mesh, and the numbers of its nodes; the top is held."""
    masonry = WALLS[name]
    mesh = Mesh(masonry, laws(masonry, Pattern.regular(0, 0.0), 0.0, 1.0, tau), elements)
    s = Structure(2)
    nodes = s.add_nodes(mesh.X)
    brick = s.elastic(masonry.E, masonry.nu, "LinearElasticPlaneStress2DLaw")
    for corners in mesh.solids:
        s.add_solid(nodes[corners[[0, 2, 3, 1]]], brick)
    for joints in mesh.joints:
        properties, along = s.umat(joints.law), np.diff(mesh.X[joints.nodes[joints.faces[0], 0]], axis=0)[0]
        turned = joints.axes[0] @ (-along[1], along[0]) < 0.0  # Kratos' normal is the edge turned left
        for face in joints.faces[:, ::-1] if turned else joints.faces:
            s.add_interface(*nodes[joints.nodes[face]].T, properties)
    s.fix(nodes[mesh.bottom], 0, 1)
    top = nodes[mesh.pushed]
    s.fix(top, 0)
    area = mesh.area[mesh.pushed] / masonry.half_brick[1]
    s.load({node: (0.0, 0.0, 0.0) for node in top})
    for part in (0.25, 0.5, 0.75, 1.0):
        for node, width in zip(top, area, strict=True):
            s.set_load(node, (0.0, -part * masonry.pressure * width, 0.0))
        s.step(TOLERANCE)
    s.fix(top, 1)
    return s, mesh, nodes


def run(
    name: str, elements: Sequence[int], tau: float, most: float, ends: Sequence[float]
) -> tuple[Floats, int]:
    """Rows of displacement in mm, horizontal and vertical force in kN, and the number of iterations."""
    s, mesh, nodes = model(name, elements, tau)
    to_kN, top, bottom = WALLS[name].half_brick[1] / 1e3, nodes[mesh.pushed], nodes[mesh.bottom]
    at, step, again, iterations, rows = 0.0, most, False, 0, []
    for end in ends:
        while abs(end - at) > LEAST_STEP:
            move = float(np.clip(end - at, -step, step))
            s.move(top, 0, at + move)
            try:
                norms = s.step(TOLERANCE, again, abs(move))
            except Lost:
                step, again = abs(move) / 2.0, True
                if step < LEAST_STEP:
                    print(f"stopped at {at:g} mm", file=sys.stderr)
                    return np.array(rows).reshape(-1, 3), iterations
                continue
            at, again, iterations = at + move, False, iterations + len(norms)
            step = min(1.5 * step, most) if len(norms) <= FAST else step
            horizontal, vertical = to_kN * s.reaction(bottom)
            rows.append((at, -horizontal, vertical))
    return np.array(rows), iterations


def main() -> None:
    """Run the program."""
    parser = argparse.ArgumentParser(description=__doc__)
    add = parser.add_argument
    add("--wall", choices=("J4D", "J6D", "J7D"), default="J4D")
    add("--elements", type=int, nargs=2, default=[4, 3], help="of a half-brick (default: 4 3)")
    add("--tau", type=float, default=0.002, help="tau_v, in mm of the top (default: %(default)s)")
    add("--most", type=float, default=0.05, help="largest step, mm (default: %(default)s)")
    add("--to", type=float, nargs="+", default=[2.15], help="displacements of the top, mm (default: 2.15)")
    add("--out", type=Path, metavar="FILE.csv", help="write the rows there")
    o = parser.parse_args()
    begin = time.process_time()
    rows, iterations = run(o.wall, o.elements, o.tau, o.most, o.to)
    seconds = time.process_time() - begin
    if not len(rows):
        sys.exit(f"{o.wall}: no solution")
    if o.out:
        head = "displacement [mm],horizontal [kN],vertical [kN]"
        np.savetxt(o.out, rows, "%.12g", ",", header=head, comments="")
    peak = rows[rows[:, 1].argmax()]
    steps = f"{len(rows)} steps, {iterations} iterations, {seconds:.0f} s"
    print(f"peak {peak[1]:.2f} kN at {peak[0]:.2f} mm, {steps}")


if __name__ == "__main__":
    main()
