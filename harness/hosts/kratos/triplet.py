"""Masonry triplet in Kratos: three bricks, two bed joints, cyclic slip of the middle brick under pressure.

The model is 2D plane strain in mm, N, MPa with thickness 1.  As a script this module draws the deformed mesh
with the damage of the joints.  It also draws force and dilation over the slip, together with the prediction
of one material point.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from asperity import Interface, Material, Pattern
from asperity.case_files import read_run
from kratos_model import Floats, Structure

sys.path.insert(0, str(Path(__file__).parent.parent))
import paraview_files as paraview
import structure_picture

LENGTH, HEIGHT = 210.0, 52.0
YOUNG, POISSON = 6000.0, 0.15
THETA = 10.0
JOINT = Interface(Material(sigma0=0.3, Gc=0.03, eta=0.95, mu=0.6, kc=20.0), Pattern.regular(2, theta=THETA))
PRESSURE = 0.5
PRELOAD_STEPS = 4
TOLERANCE = 1.0e-9
"""Accepted residual force, N; the loads are 1 to 100 N on a node."""


@dataclass(frozen=True)
class Result:
    """Histories with one row for each step; the first PRELOAD_STEPS rows have the slip 0.

    The arrays are the slip, the force on the middle brick, the rise of the top, separation and traction
    (steps, points, 3) and displacement (steps, nodes, 2).  `norms` are those of the Newton iterations.
    """

    slip: Floats
    force: Floats
    rise: Floats
    separation: Floats
    traction: Floats
    displacement: Floats
    norms: list[list[float]]
    structure: Structure


def run(
    turns: Sequence[float],
    increment: float,
    nx: int = 21,
    ny: int = 5,
    law: Interface = JOINT,
    **umat: object,
) -> Result:
    """Apply the pressure, then move the middle brick to each reversal (`turns`, mm) in turn.

    The steps have about the size `increment`, mm.  umat: see Structure.umat.
    """
    s = Structure(2)
    brick, joint = s.elastic(YOUNG, POISSON), s.umat(law, **umat)
    x, y = np.linspace(0.0, LENGTH, nx + 1), np.linspace(0.0, HEIGHT, ny + 1)
    bricks = []
    for k in range(3):
        grid = np.stack(np.meshgrid(x, y + k * HEIGHT, indexing="ij"), axis=-1)
        n = s.add_nodes(grid)
        bricks.append(n)
        for i in range(nx):
            for j in range(ny):
                s.add_solid([n[i, j], n[i + 1, j], n[i + 1, j + 1], n[i, j + 1]], brick)
    for lower, upper in pairwise(bricks):
        for i in range(nx):
            s.add_interface(lower[i : i + 2, -1], upper[i : i + 2, 0], joint)
    top, bottom, middle = bricks[2][:, -1], bricks[0][:, 0], bricks[1][[0, -1]].ravel()
    s.fix(bottom, 0, 1)
    s.fix(top, 0)
    s.fix(middle, 0)

    share = np.full(nx + 1, LENGTH / nx)
    share[[0, -1]] *= 0.5
    s.load({node: (0.0, 0.0, 0.0) for node in top})
    slips = [0.0]
    for turn in turns:
        n = max(1, round(abs(turn - slips[-1]) / increment))
        slips += np.linspace(slips[-1], turn, n + 1)[1:].tolist()
    rows, norms = [], []
    for k, slip in enumerate([0.0] * (PRELOAD_STEPS - 1) + slips):
        part = min(1.0, (k + 1) / PRELOAD_STEPS)
        for node, area in zip(top, share, strict=True):
            s.set_load(node, (0.0, -PRESSURE * part * area, 0.0))
        s.move(middle, 0, slip)
        norms.append(s.step(TOLERANCE))
        u = s.displacements()
        rows.append((slip, s.reaction(middle)[0], u[top - 1, 1].mean(), *s.points(), u))
        if sys.stderr.isatty():
            print(f"\rstep {k + 1} of {PRELOAD_STEPS - 1 + len(slips)} ", end="", file=sys.stderr, flush=True)
    slip, force, rise, separation, traction, u = (np.array(column) for column in zip(*rows, strict=True))
    return Result(slip, force, rise, separation, traction, u, norms, s)


def prediction(slips: Floats, law: Interface = JOINT) -> tuple[Floats, Floats]:
    """Return the force on two joints and the rise of the top if all points have the same separation."""
    pressed = law.confined_slip(0.0, [0.0], -PRESSURE).separation[0, 0]
    history = law.confined_slip(0.0, slips, -PRESSURE)
    return 2.0 * LENGTH * history.traction[:, 1], 2.0 * (history.separation[:, 0] - pressed)


def write_paraview(pvd: Path, result: Result, law: Interface = JOINT) -> None:
    """Write all steps for ParaView.

    Kratos does not give the state variables of its interface elements: they are those of the library on the
    separations of Kratos.
    """
    s = result.structure
    around = [0, 1, 3, 2]  # both sides of an element have the same direction
    structure = paraview.Structure(
        s.coordinates(), np.array(s.solids) - 1, s.interface_nodes()[:, around] - 1, (2, 1)
    )
    states = np.array([law.replay(path).state for path in result.separation.transpose(1, 0, 2)])
    rows = zip(
        result.displacement, result.separation, result.traction, states.transpose(1, 0, 2), strict=True
    )
    paraview.write(pvd, structure, (paraview.Step(float(k), *row) for k, row in enumerate(rows)))


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="Masonry triplet in Kratos, drawn.")
    parser.add_argument("-o", "--output", type=Path, default=Path("kratos-triplet.png"), metavar="FILE.png")
    parser.add_argument("--case", type=Path, metavar="CASE.nml", help="interface of the joints")
    parser.add_argument("--value", help="of the sweep of the case")
    parser.add_argument("--turns", type=float, nargs="+", default=[0.6, -0.6, 0.6], help="slips in turn, mm")
    parser.add_argument("--pvd", type=Path, metavar="FILE.pvd", help="write all steps for ParaView")
    parser.add_argument("--csv", type=Path, help="write slip, force and rise there")
    options = parser.parse_args()
    law = JOINT if options.case is None else read_run(options.case, options.value).interface
    result = run(options.turns, 0.01, law=law)
    after = slice(PRELOAD_STEPS, None)
    slip, force, rise = result.slip[after], result.force[after], result.rise[after]
    rise = rise - result.rise[PRELOAD_STEPS - 1]
    force_1, rise_1 = prediction(slip, law)
    if options.csv is not None:
        names = "slip,force,rise,force_point,rise_point"
        table = np.column_stack([slip, force, rise, force_1, rise_1])
        np.savetxt(options.csv, table, fmt="%.6f", delimiter=",", header=names, comments="")
    print(f"{len(slip)} steps, at most {max(map(len, result.norms))} iterations")
    print(f"largest force {force.max():.2f} N, of the material point {force_1.max():.2f} N")
    print(f"force at the end {force[-1]:.2f} N, of the material point {force_1[-1]:.2f} N")
    print(f"rise at the end {rise[-1]:.4f} mm, of the material point {rise_1[-1]:.4f} mm")
    damage = np.array([law.replay(path).damage for path in result.separation.transpose(1, 0, 2)]).T
    row = int(np.ptp(damage, axis=1).argmax())  # the step at which the damage varies most along the joints
    shown = row - PRELOAD_STEPS
    s = result.structure
    joints = s.interface_nodes() - 1
    mesh = structure_picture.Mesh(
        s.coordinates(), result.displacement[row], np.array(s.solids) - 1, joints, damage[row].reshape(-1, 2)
    )
    mark = f"slip {slip[shown]:.2g} mm, drawn"
    label = "slip of the middle brick [mm]"
    structure_picture.draw(
        options.output,
        f"Kratos: masonry triplet under {PRESSURE:g} MPa, slip {slip[shown]:.2g} mm",
        mesh,
        100.0,
        [
            structure_picture.Curves(
                label,
                "force on two joints [N/mm]",
                {"Kratos": (slip, force), "material point": (slip, force_1)},
                [(mark, slip[shown], force[shown])],
            ),
            structure_picture.Curves(
                label,
                "rise of the top [mm]",
                {"Kratos": (slip, rise), "material point": (slip, rise_1)},
                [(mark, slip[shown], rise[shown])],
            ),
        ],
    )
    print(options.output)
    if options.pvd is not None:
        write_paraview(options.pvd, result, law)
        print(options.pvd)


if __name__ == "__main__":
    main()
