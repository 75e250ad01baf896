"""Block on a rough base in OOFEM: pressed, then pulled along the base at one face; mm, N, MPa.

The base is a thin layer of elements with the UMAT of libasperity.  The block stays in plane strain.  The
script prints the force and the residual strength, and writes the files for ParaView.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from asperity import Interface, Material, Pattern
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parent.parent))
import paraview_files as paraview

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

RUNNER = Path(__file__).parent / "kit" / "oofem_run.py"
LENGTH, WIDTH, HEIGHT, THICKNESS = 200.0, 20.0, 50.0, 0.01
YOUNG, POISSON, PRESSURE = 30000.0, 0.2, 1.0
THETA = 30.0
JOINT = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5), Pattern.regular(4, theta=THETA))
PRELOAD_STEPS, STEPS, SLIP = 10, 60, 0.6
ORDER = (0, 1, 4, 5, 2, 3, 6, 7)
"""Integration points of LSpace in the order of paraview.Structure."""

AT = [2, 4, 3]
"""Positions of N, Tx, Ty among 33, 13, 23 in OOFEM's order 11, 22, 33, 23, 13, 12."""


@dataclass(frozen=True)
class Result:
    """Force and slip of the pulled face (T,); steps for ParaView; structure; messages of the run."""

    slip: Floats
    force: Floats
    steps: list[paraview.Step]
    structure: paraview.Structure
    messages: str


def model(nx: int, nz: int) -> tuple[str, paraview.Structure]:
    """Input and structure of a block of nx x 1 x nz elements."""
    z = np.append(0.0, THICKNESS + np.linspace(0.0, HEIGHT, nz + 1))
    grid = np.stack(np.meshgrid(np.linspace(0.0, LENGTH, nx + 1), [0.0, WIDTH], z, indexing="ij"), axis=-1)
    number = np.arange(grid[..., 0].size).reshape(grid.shape[:3])
    corners = paraview.AROUND[8]
    cells = np.stack(
        [number[a : nx + a, b : 1 + b, c : nz + 1 + c] for a, b, c in corners], axis=-1
    )  # (nx, 1, nz + 1, 8)
    joints, solids = cells[:, :, 0].reshape(-1, 8), cells[:, :, 1:].reshape(-1, 8)
    nodes = grid.reshape(-1, 3)
    structure = paraview.Structure(nodes, solids, joints, (2, 2, 2), ORDER)
    steps = PRELOAD_STEPS + STEPS
    sets = {3: number[:, :, 0], 4: number[-1, :, 1:], 5: number[1:-1, :, -1], 6: number[[0, -1], :, -1]}
    sets[7] = number[:, :, 1:]
    share = -0.5 * PRESSURE * WIDTH * LENGTH / nx  # of a node on the sides; of one at a corner half
    lines = [
        "pulled_block.out",
        "Block on a rough base: pressure, then slip of its face x = LENGTH; mm, N, MPa",
        f"NonLinearStatic nsteps {steps} rtolv 1e-8 MaxIter 100 controlmode 1 stiffMode 0 nmodules 0 "
        "lstype 0 smtype 1",
        "domain 3d",
        "OutputManager",
        f"ndofman {len(nodes)} nelem {len(joints) + len(solids)} ncrosssect 2 nmat 2 nbc 5 nic 0 nltf 3 "
        f"nset {len(sets) + 2}",
        *(f"node {i} coords 3 {x!r} {y!r} {z!r}" for i, (x, y, z) in enumerate(nodes.tolist(), 1)),
    ]
    # OOFEM lists the nodes of the upper face first
    elements = np.concatenate([joints, solids])[:, [4, 5, 6, 7, 0, 1, 2, 3]] + 1
    for i, cell in enumerate(elements.tolist(), 1):
        kind = 1 if i <= len(joints) else 2
        lines.append(f"LSpace {i} nodes 8 {' '.join(map(str, cell))} crosssect {kind} mat {kind}")
    lines += [
        "SimpleCS 1 material 1 set 1",
        "SimpleCS 2 material 2 set 2",
        JOINT.card("oofem", h=THICKNESS).rstrip("\n"),
        f"IsoLE 2 d 0.0 E {YOUNG!r} n {POISSON!r} tAlpha 0.0",
        "BoundaryCondition 1 loadTimeFunction 1 dofs 3 1 2 3 values 3 0 0 0 set 3",
        "BoundaryCondition 2 loadTimeFunction 2 dofs 1 1 values 1 1.0 set 4",
        "BoundaryCondition 3 loadTimeFunction 1 dofs 1 2 values 1 0.0 set 7",
        f"NodalLoad 4 loadTimeFunction 3 dofs 3 1 2 3 components 3 0 0 {share!r} set 5",
        f"NodalLoad 5 loadTimeFunction 3 dofs 3 1 2 3 components 3 0 0 {0.5 * share!r} set 6",
        "ConstantFunction 1 f(t) 1.0",
        f"PiecewiseLinFunction 2 nPoints 3 t 3 0 {PRELOAD_STEPS} {steps} f(t) 3 0 0 {SLIP}",
        # OOFEM adds the load of every step to those before
        f"PiecewiseLinFunction 3 nPoints 6 t 6 0 0.5 0.6 {PRELOAD_STEPS}.5 {PRELOAD_STEPS}.6 1000 f(t) 6 0 0 "
        f"{1.0 / PRELOAD_STEPS!r} {1.0 / PRELOAD_STEPS!r} 0 0",
        f"Set 1 elementranges {{(1 {len(joints)})}}",
        f"Set 2 elementranges {{({len(joints) + 1} {len(elements)})}}",
    ]
    for name, members in sets.items():
        text = " ".join(map(str, (np.ravel(members) + 1).tolist()))
        lines.append(f"Set {name} nodes {np.size(members)} {text}")
    return "\n".join([*lines, ""]), structure


def run(folder: Path, nx: int = 10, nz: int = 2) -> Result:
    """Run the model; raises RuntimeError where a step has not converged."""
    text, structure = model(nx, nz)
    (folder / "block.in").write_text(text, encoding="utf-8")
    command = [sys.executable, RUNNER, "block.in", "block.npz"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(done.stderr)
    found = np.load(folder / "block.npz")
    points = structure.points
    separation = THICKNESS * found["strain"][:, :points, AT]
    traction, state = found["stress"][:, :points, AT], found["state"][:, :points, : JOINT.nstatv]
    rows = zip(found["displacement"], separation, traction, state, strict=True)
    steps = [paraview.Step(float(k), *row) for k, row in enumerate(rows, 1)]
    slip = found["displacement"][:, -1, 0]  # of a node of the pulled face
    area = LENGTH * WIDTH / points
    return Result(slip, area * traction[..., 1].sum(axis=1), steps, structure, done.stderr)


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="Block pulled along a rough base in OOFEM.")
    parser.add_argument("--pvd", type=Path, metavar="FILE.pvd", help="write all steps for ParaView")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        result = run(Path(name))
    print(result.messages.splitlines()[-1])
    residual = JOINT.material.residual_strength(THETA) * PRESSURE * LENGTH * WIDTH
    print(f"largest force {result.force.max():.1f} N")
    print(f"force at the end {result.force[-1]:.3f} N, closed form {residual:.3f} N")
    if options.pvd is not None:
        paraview.write(options.pvd, result.structure, result.steps)
        print(options.pvd)


if __name__ == "__main__":
    main()
