"""Two elastic blocks with a joint in Akantu, in 2D and 3D: pressure, then slip of the upper block.

As a script this module prints force and dilation beside those of a material point.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count
from pathlib import Path

import akantu as aka
import numpy as np
from asperity import Interface, Material, Pattern
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parent.parent))
sys.path.insert(0, str(Path(__file__).parent / "kit"))
import paraview_files as paraview
from asperity_akantu import Joint, register

Floats = NDArray[np.float64]

JOINT = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=4.0), Pattern.regular(2, theta=30.0))
PRESSURE, SLIP = 1.0, 0.6
PRELOAD_STEPS, STEPS = 10, 120
YOUNG, POISSON = 30000.0, 0.2
TOLERANCE = 1.0e-9
"""Residual force, N, of blocks with an edge of 1 mm."""

MOST_ITERATIONS = 200
RUNS = count()

INPUT = """
model solid_mechanics_model_cohesive [
  cohesive_inserter [
    bounding_box = [{box}]
  ]
  material elastic [
    name = block
    rho = 1e-9
    E = {young}
    nu = {poisson}
  ]
  material {law} [
    name = joint
  ]
]
"""

CELL = {2: aka._cohesive_2d_4, 3: aka._cohesive_3d_8}
"""Type of the elements of the joint, by dimension."""

SOLID = {2: aka._quadrangle_4, 3: aka._hexahedron_8}
"""Type of the elements of the blocks, by dimension."""


@dataclass(frozen=True)
class Result:
    """Slip and rise of the top, force (T, dimension) and points of the joint of each step; iterations.

    structure, displacement (T, n, dimension): for ParaView.
    """

    slip: Floats
    rise: Floats
    force: Floats
    separation: Floats
    traction: Floats
    state: Floats
    displacement: Floats
    iterations: list[int]
    structure: paraview.Structure


def write_mesh(path: Path, axes: Sequence[Floats]) -> None:
    """Write a mesh of quadrilaterals or hexahedra between the lines of the axes, the vertical axis last."""
    dimension = len(axes)
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    number = np.arange(1, grid[..., 0].size + 1).reshape(grid.shape[:-1])
    # nodes of an element: around its lower face, then its upper face; in 2D around it
    faces = [number[:-1], number[1:]]
    if dimension == 3:
        faces = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    lower, upper = [f[..., :-1] for f in faces], [f[..., 1:] for f in faces]
    cells = np.stack(lower + (upper if dimension == 3 else upper[::-1]), axis=-1).reshape(-1, 2**dimension)
    points = np.zeros((number.size, 3))
    points[:, :dimension] = grid.reshape(-1, dimension)
    kind = {2: 3, 3: 5}[dimension]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "1", f'{dimension} 1 "blocks"']
    lines += ["$EndPhysicalNames", "$Nodes", str(len(points))]
    lines += [f"{i} {x!r} {y!r} {z!r}" for i, (x, y, z) in enumerate(points.tolist(), 1)]
    lines += ["$EndNodes", "$Elements", str(len(cells))]
    lines += [f"{i} {kind} 2 1 1 " + " ".join(map(str, cell)) for i, cell in enumerate(cells.tolist(), 1)]
    path.write_text("\n".join([*lines, "$EndElements"]) + "\n", encoding="utf-8")


def run(
    folder: Path, dimension: int, interface: Interface = JOINT, n: int = 2, of_card: bool = False
) -> Result:
    """Press the blocks by PRESSURE, then move the top by SLIP along x; the top stays horizontal.

    of_card: the input file has the constants, by `asperity card`.
    """
    mesh, model, (joint,) = build(folder, dimension, interface, n, aka._static, of_card)
    rows, iterations = [], []
    for k in range(1, PRELOAD_STEPS + STEPS + 1):
        pressure = PRESSURE * min(1.0, k / PRELOAD_STEPS)
        slip = SLIP * max(0.0, (k - PRELOAD_STEPS) / STEPS)
        iterations.append(solve(model, slip, pressure))
        joint.commit()
        points = joint.points(CELL[dimension])
        top = np.array(mesh.getNodes())[:, -1] > 1.5
        u, force = np.array(model.getDisplacement()), np.array(model.getInternalForce())
        rows.append(
            (
                slip,
                u[top, -1].mean(),
                -force[top].sum(axis=0),
                points.separation.copy(),
                points.traction.copy(),
                points.state.copy(),
                u,
            )
        )
    columns = (np.array(column) for column in zip(*rows, strict=True))
    return Result(*columns, iterations, structure_of(mesh))


def build(
    folder: Path,
    dimension: int,
    interface: Interface,
    n: int,
    method: object,
    of_card: bool = False,
    young: float = YOUNG,
) -> tuple[aka.Mesh, aka.SolidMechanicsModelCohesive, list[Joint]]:
    """Mesh, which must live as long as the model, model of the blocks, and its joint in a list."""
    name = f"asperity_{next(RUNS)}"  # a name can be registered once
    made = register(None if of_card else interface, name)
    wide = "[-1, 2], " * (dimension - 1)
    text = INPUT.format(box=f"{wide}[0.9, 1.1]", young=young, poisson=POISSON, law=name)
    if of_card:
        card = interface.card("akantu", name="joint").replace("material asperity [", f"material {name} [")
        text = text.replace(f"material {name} [\n    name = joint\n  ]", card)
    (folder / "material.dat").write_text(text, encoding="utf-8")
    axis = np.linspace(0.0, 1.0, n + 1)
    write_mesh(folder / "blocks.msh", [axis] * (dimension - 1) + [np.array([0.0, 1.0, 2.0])])
    aka.parseInput(str(folder / "material.dat"))
    mesh = aka.Mesh(dimension)
    mesh.read(str(folder / "blocks.msh"))
    model = aka.SolidMechanicsModelCohesive(mesh)
    model.initFull(_analysis_method=method, _is_extrinsic=False)
    return mesh, model, made


def structure_of(mesh: aka.Mesh) -> paraview.Structure:
    """Structure for ParaView; the two sides of a joint have the same direction in Akantu."""
    dimension = np.array(mesh.getNodes()).shape[1]
    solids = np.array(mesh.getConnectivity(SOLID[dimension]))
    joints = np.array(mesh.getConnectivity(CELL[dimension]))
    if dimension == 2:
        return paraview.Structure(np.array(mesh.getNodes()), solids, joints[:, [0, 1, 3, 2]], (2, 1))
    return paraview.Structure(np.array(mesh.getNodes()), solids, joints, (2, 2, 1), (0, 2, 1, 3))


def write_paraview(pvd: Path, result: Result) -> None:
    """Write all steps for ParaView."""
    rows = zip(result.displacement, result.separation, result.traction, result.state, strict=True)
    paraview.write(pvd, result.structure, (paraview.Step(float(k), *row) for k, row in enumerate(rows)))


def solve(model: aka.SolidMechanicsModelCohesive, slip: float, pressure: float) -> int:
    """Newton's method for a slip and a pressure of the top; returns the number of iterations."""
    u = model.getDisplacement()
    x = np.array(model.getMesh().getNodes())
    n, dimension = x.shape
    top, bottom = np.flatnonzero(x[:, -1] > 1.5), np.flatnonzero(x[:, -1] < 0.5)
    numbers = np.arange(n * dimension).reshape(n, dimension)
    vertical = numbers[top, -1]
    # the vertical displacement of the first node of the top is that of all
    tie = np.eye(n * dimension)
    tie[vertical[1:], vertical[1:]] = 0.0
    tie[vertical[1:], vertical[0]] = 1.0
    held = np.concatenate([numbers[bottom].ravel(), numbers[top, :-1].ravel(), vertical[1:]])
    free = np.setdiff1d(numbers.ravel(), held)
    u[top, 0] = slip
    external = np.zeros(n * dimension)
    external[vertical[0]] = -pressure
    for iteration in range(1, MOST_ITERATIONS + 1):
        model.assembleInternalForces()
        residual = external + tie.T @ np.array(model.getInternalForce()).ravel()
        if np.abs(residual[free]).max() <= TOLERANCE:
            return iteration - 1
        model.assembleStiffnessMatrix()
        matrix = aka.AkantuSparseMatrix(model.getDOFManager().getMatrix("K")).toarray()
        reduced = (tie.T @ matrix @ tie)[np.ix_(free, free)]
        step = np.zeros(n * dimension)
        step[free] = np.linalg.solve(reduced, residual[free])
        u[:] = np.array(u) + (tie @ step).reshape(n, dimension)
    raise RuntimeError(f"slip {slip:g}: not converged after {MOST_ITERATIONS} iterations")


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="Two blocks with a joint in Akantu.")
    parser.add_argument("--dimension", type=int, default=2, choices=(2, 3))
    parser.add_argument("--elements", type=int, default=2, help="along each side (default: %(default)s)")
    parser.add_argument("--pvd", type=Path, metavar="FILE.pvd", help="write all steps for ParaView")
    options = parser.parse_args()
    if options.elements < 1:
        parser.error(f"--elements {options.elements}: expected at least 1")
    with tempfile.TemporaryDirectory() as name:
        result = run(Path(name), options.dimension, JOINT, options.elements)
    point = JOINT.confined_slip(0.0, result.slip[PRELOAD_STEPS - 1 :], -PRESSURE)
    counts = result.iterations
    print(f"{len(counts)} steps, {sum(counts)} iterations, at most {max(counts)}")
    largest = result.force[:, 0].max()
    print(f"largest force {largest:.4f} N, of the material point {point.traction[:, 1].max():.4f} N")
    print(
        f"force at the end {result.force[-1, 0]:.9f} N, of the material point {point.traction[-1, 1]:.9f} N"
    )
    rise = result.rise[-1] - result.rise[PRELOAD_STEPS - 1]
    dilation = point.separation[-1, 0] - point.separation[0, 0]
    print(f"rise at the end {rise:.6f} mm, of the material point {dilation:.6f} mm")
    if options.pvd is not None:
        write_paraview(options.pvd, result)
        print(options.pvd)


if __name__ == "__main__":
    main()
