"""Slab on a slope in CalculiX: it starts in equilibrium with the stress of its own weight, then slides.

The model is one period of an infinite slab of rock on a rough joint and fixed ground, inclined by SLOPE.
The two ends are tied to each other; x points down the slope, z is its normal.  The mesh is that of `asperity
mesh` for CalculiX.  All stresses follow from equilibrium.  Units: m, MN, MPa, plane strain.  The script
prints a row for each state of the joint.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import calculix_run
import numpy as np
from asperity import Interface, Material, Pattern, contract
from asperity.mesh import split, write
from calculix_run import Floats, Run
from numpy.typing import ArrayLike

sys.path.insert(0, str(Path(__file__).parent.parent))
from structured import grid

LENGTH, WIDTH, HEIGHT = 4.0, 2.0, 10.0

YOUNG, POISSON, WEIGHT = 20000.0, 0.2, 0.025
SLOPE = np.radians(20.0)
LATERAL = 0.5
"""Ratio of the stress along x and y to that along z (K0)."""

THICKNESS = 1.0e-3
THETA = 15.0
JOINT = Interface(Material(sigma0=0.3, Gc=2.0e-4, eta=0.95, mu=0.6, kc=4.0), Pattern.regular(2, theta=THETA))
"""Three planes."""

PULL = WEIGHT * np.array([np.sin(SLOPE), 0.0, -np.cos(SLOPE)])
"""Weight by volume."""

TRACTION = HEIGHT * np.array([PULL[2], PULL[0], PULL[1]])
"""Traction of the joint under the weight of the slab, (N, Tx, Ty)."""

SLIDE = 0.005
"""Slip of the slab, m, at which the joint is fully damaged."""

COLUMNS, ROWS = 2, 4
POINTS = 8
"""Integration points of C3D8: the first four are the lower ones."""


@dataclass(frozen=True)
class Result:
    """Results after every increment.

    displacement (T, nodes, 3); reaction of the ground (T, 3); separation, traction and state of the points of
    the joint (T, points, ...); the run.
    """

    displacement: Floats
    reaction: Floats
    separation: Floats
    traction: Floats
    state: Floats
    run: Run


def residual_strength() -> float:
    """Ratio of shear to pressure for slip up one facing plane."""
    return float(JOINT.material.residual_strength(THETA))


def crack() -> Floats:
    """State variables of a cracked joint without traction."""
    state = np.zeros(JOINT.nstatv)
    state[contract.N_POINT_STATEV :: contract.N_PLANE_STATEV] = 1.0
    return state


def run(
    program: Path, folder: Path, slide: float = 0.0, rock: bool = True, traction: ArrayLike = TRACTION,
    state: Floats | None = None, moved: str = "FOOT",
) -> Result:  # fmt: skip
    """Run a step under the weight and, if slide > 0 (m), a step that moves the slab down the slope.

    rock: whether the rock has its initial stress; traction: initial stress of the joint (TYPE=STRESS), zeros
    for none; state (nstatv,): of its points (TYPE=SOLUTION), None for virgin; moved: the nodes, FOOT or TOP
    of the slab.
    """
    text, solids, layer = _model()
    rows = []
    if rock:
        for element, depths in zip(solids, np.tile(_depths(), (COLUMNS, 1)), strict=True):
            for point, depth in enumerate(depths, 1):
                rows.append((element, point, *_components(TRACTION * depth / HEIGHT)))
    numbers = [(element, point) for element in layer for point in range(1, POINTS + 1)]
    if np.any(traction):
        rows += [(*number, *_components(np.asarray(traction))) for number in numbers]
    if rows:
        text += "*INITIAL CONDITIONS, TYPE=STRESS\n"
        text += "".join(", ".join(f"{value:.12g}" for value in row) + "\n" for row in rows)
    if state is not None:
        text += "*INITIAL CONDITIONS, TYPE=SOLUTION, USER\n"
        calculix_run.write_states(folder, {number: state for number in numbers})

    fall = ", ".join(f"{value:.15g}" for value in PULL / WEIGHT)
    text += "*AMPLITUDE, NAME=NOW\n0., 1., 1., 1.\n*STEP, INC=100\n*STATIC, DIRECT\n1., 1.\n"
    text += f"*DLOAD, AMPLITUDE=NOW\nROCK, GRAV, 1., {fall}\n"
    text += "*NODE PRINT, NSET=NALL\nU\n*NODE PRINT, NSET=GROUND\nRF\n*EL PRINT, ELSET=ROUGH_1\nE, S, SDV\n"
    text += "*END STEP\n"
    if slide > 0.0:
        text += "*STEP, INC=1000\n*STATIC\n0.025, 1., 1e-5, 0.025\n"
        text += f"*BOUNDARY\n{moved}, 1, 1, {slide!r}\n*END STEP\n"
    done = calculix_run.run(program, folder, text)
    _, u = done.table("NALL displacements")
    _, force = done.table("GROUND forces")
    separation = THICKNESS * done.vectors("ROUGH_1 strains") * [1.0, 2.0, 2.0]
    of_joint = separation, done.vectors("ROUGH_1 stresses"), done.state("ROUGH_1")
    return Result(u[:, :, 1:], force[:, :, 1:].sum(axis=1), *of_joint, done)


def _model() -> tuple[str, range, range]:
    """Input up to the boundary conditions; numbers of the elements of rock, by columns, and of the layer."""
    z = np.r_[-1.0, 0.5 * THICKNESS, THICKNESS + np.linspace(0.0, HEIGHT, ROWS + 1)[1:]]
    axes = np.linspace(0.0, LENGTH, COLUMNS + 1), [0.0, WIDTH], z
    unsplit = grid(*axes, block=[0] + [1] * ROWS, names={"BASE": 0, "ROCK": 1}, sides=())
    mesh = split(unsplit, {"ROUGH": ("BASE", "ROCK")})
    with tempfile.TemporaryDirectory() as folder:
        [file] = write(Path(folder, "slab.inp"), mesh, "calculix", {"ROUGH": JOINT}, layer=THICKNESS)
        text = file.read_text(encoding="utf-8")
    [joint] = mesh.joints["ROUGH"]
    x, slab = mesh.points, np.setdiff1d(joint.plus, joint.minus)
    below, base, top = x[:, 2] < 0.0, np.isin(np.arange(len(x)), slab), x[:, 2] == z[-1]
    start, end = x[:, 0] == 0.0, x[:, 0] == LENGTH
    ground = below | np.isin(np.arange(len(x)), joint.minus)
    sets = {"NALL": ground | ~ground, "GROUND": ground, "FOOT": base & ~end, "TOP": top & ~end}
    text += "".join(calculix_run.nset(name, members) for name, members in sets.items())
    order = np.lexsort(x.T)
    ties = (order[chosen[order]] + 1 for chosen in (end & ~ground, start & ~ground))
    for pair in zip(*ties, strict=True):
        for axis in (1, 3):
            text += "*EQUATION\n2\n{0}, {2}, 1., {1}, {2}, -1.\n".format(*pair, axis)
    text += f"*MATERIAL, NAME=ROCK\n*ELASTIC\n{YOUNG}, {POISSON}\n*DENSITY\n{WEIGHT!r}\n"
    text += "".join(f"*SOLID SECTION, ELSET={name}, MATERIAL=ROCK\n" for name in mesh.names)
    text += "*BOUNDARY\nGROUND, 1, 3\nNALL, 2\n"
    count = len(unsplit.cells[0].data)
    return text, range(COLUMNS + 1, count + 1), range(count + 1, count + COLUMNS + 1)


def _depths() -> Floats:
    """Depths of the integration points of the rock below the surface (rows, 8)."""
    row = HEIGHT / ROWS
    middles = row * (np.arange(ROWS) + 0.5)
    return HEIGHT - middles[:, None] - 0.5 * row / np.sqrt(3.0) * np.repeat([-1.0, 1.0], POINTS // 2)


def _components(traction: Floats) -> list[float]:
    """Stress 11, 22, 33, 12, 13, 23 of a traction (N, Tx, Ty) and the lateral stress."""
    normal, x, y = traction.tolist()
    return [LATERAL * normal, LATERAL * normal, normal, 0.0, x, y]


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="Slab on a slope in CalculiX, from its own stress.")
    parser.add_argument("program", type=calculix_run.program_file, help="ccx linked with libasperity")
    program = parser.parse_args().program
    part = JOINT.initial(TRACTION, [1.0, 0.5, 0.0])
    starts = {
        "virgin, TYPE=STRESS": {},
        "cracked, TYPE=STRESS and SOLUTION": {"state": crack()},
        "cracked in part, TYPE=SOLUTION": {"state": part, "traction": 0.0},
        "no initial stress": {"rock": False, "traction": 0.0},
    }
    print(f"residual strength, closed form {residual_strength():.6f}; strength is shear over pressure")
    print("start                               moves by its weight [m]  largest strength  at the end")
    for name, start in starts.items():
        with tempfile.TemporaryDirectory() as folder:
            result = run(program, Path(folder), SLIDE, **start)
        strength = -(result.traction[:, :, 1] / result.traction[:, :, 0]).mean(axis=1)
        moved = np.abs(result.displacement[0]).max()
        print(f"{name:36}{moved:23.1e}{strength.max():18.3f}{strength[-1]:12.6f}")


if __name__ == "__main__":
    main()
