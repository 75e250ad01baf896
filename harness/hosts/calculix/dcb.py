"""Double cantilever beam under end moments in CalculiX: mixed-mode rupture of a rough joint.

Two elastic arms (C3D8I) in plane strain with a thin layer (C3D8) between them are clamped at the far end.
The ends of the arms rotate under moments of a prescribed ratio.  The energy release rate of the two moments
is known for any length of the crack, so it is the resistance of the joint.  Units: mm, N, MPa.

The script prints the resistance, and the work of the law on the separations of the first point of the joint.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from asperity import Interface, Material, Pattern, contract

sys.path.insert(0, str(Path(__file__).parent.parent))
import calculix_run
import paraview_files as paraview
from calculix_run import TX, TY, Floats, N, Run

LENGTH, CRACK, HEIGHT, WIDTH = 60.0, 20.0, 4.0, 1.0
YOUNG, POISSON = 70000.0, 0.3
THICKNESS = 1.0e-3
"""Thickness of the layer, PROPS 9."""

ROUGH = Interface(Material(sigma0=20.0, Gc=0.3, eta=0.95, mu=0.5), Pattern.regular(4, theta=30.0))
"""Five planes."""

STIFFNESS = YOUNG / (1.0 - POISSON**2) * WIDTH**2 * HEIGHT**3
"""Twelve times the bending stiffness of an arm, times its width."""

POINTS = 8
"""Integration points of C3D8."""

ORDER = (0, 4, 2, 6, 1, 5, 3, 7)
"""These points in the order of paraview.Structure."""

ROWS = 2
"""Elements over the height of an arm."""


@dataclass(frozen=True)
class Result:
    """Histories with one row for each increment.

    time (T,); moments (T, 2) of the upper and the lower arm; separation, traction and state of the points of
    the joint (T, points, ...); displacement (T, nodes, 3); the run; structure.
    """

    time: Floats
    moments: Floats
    separation: Floats
    traction: Floats
    state: Floats
    displacement: Floats
    run: Run
    structure: paraview.Structure

    @property
    def damage(self) -> Floats:
        """Damage of the joint (T, elements)."""
        damage = self.state[:, :, contract.statev_index("damage")]
        return damage.reshape(len(damage), -1, POINTS).mean(axis=2)

    @property
    def release(self) -> Floats:
        """Energy release rate of the end moments, N/mm: the energy of two arms less that of one beam."""
        upper, lower = self.moments.T
        rate: Floats = (21.0 * (upper**2 + lower**2) - 6.0 * upper * lower) / (4.0 * STIFFNESS)
        return rate


def deck(
    interface: Interface, ratio: float, turn: float, n: int, increments: int
) -> tuple[str, Floats, list[list[int]], list[list[int]]]:
    """Input for n elements along the beam; the lower moment is ratio times the upper, `turn` their rotation.

    Returns the input, the nodes (n, 3) and the corners of the elements of arms and layer, from 1.
    """
    half = 0.5 * THICKNESS
    upper = np.linspace(half, half + HEIGHT, ROWS + 1)
    z = np.concatenate([-upper[::-1], upper])
    grid = np.stack(np.meshgrid(np.linspace(0, LENGTH, n + 1), [0.0, WIDTH], z, indexing="ij"), axis=-1)
    number = np.arange(1, grid[..., 0].size + 1).reshape(grid.shape[:3])

    def corners(i: int, k: int) -> list[int]:
        return [number[i + a, b, k + c] for c in (0, 1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]

    arms, layer = [], []
    for i in range(n):  # numbered by columns, because a thread takes a range of elements
        for k in range(2 * ROWS + 1):
            if k != ROWS:
                arms.append(corners(i, k))
            elif LENGTH * (i + 0.5) / n > CRACK:
                layer.append(corners(i, k))
    points = grid.reshape(-1, 3)
    last = len(points)
    # Extra nodes: axial displacement of each end, then the sum of the rotations and the lower rotation.
    axial, turns = (last + 1, last + 2), (last + 3, last + 4)
    extra = np.zeros((4, 3)) + [[-1.0 - i, 0.0, 0.0] for i in range(4)]
    text = calculix_run.nodes(np.concatenate([points, extra]))
    text += calculix_run.elements("C3D8I", "ARMS", 1, arms)
    text += calculix_run.elements("C3D8", "ROUGH", len(arms) + 1, layer)
    for name, members in (
        ("SIDES", number.ravel()),
        ("SHOWN", number.ravel()),
        ("FAR", number[-1].ravel()),
        ("ENDS", number[0].ravel()),
        ("AXIAL", axial),
    ):
        text += f"*NSET, NSET={name}\n" + calculix_run.numbers(members)
    # The ends remain plane: u_x = axial displacement + z' rotation; upper rotation = sum - ratio * lower one.
    middle = half + 0.5 * HEIGHT
    for arm, levels in enumerate((range(ROWS + 1, 2 * ROWS + 2), range(ROWS + 1))):
        for k in levels:
            lever = round(float(z[k] - (middle if arm == 0 else -middle)), 9)
            for j in (0, 1):
                terms = [(number[0, j, k], 1.0), (axial[arm], -1.0)]
                terms += [(turns[0], -lever), (turns[1], ratio * lever)] if arm == 0 else [(turns[1], -lever)]
                terms = [(node, factor) for node, factor in terms if factor != 0.0]
                text += f"*EQUATION\n{len(terms)}\n"
                text += "".join(f"{node}, 1, {factor:.12g}\n" for node, factor in terms)
    text += f"*MATERIAL, NAME=ARM\n*ELASTIC\n{YOUNG}, {POISSON}\n"
    text += interface.card("calculix", h=THICKNESS, name="ROUGH")
    text += "*SOLID SECTION, ELSET=ARMS, MATERIAL=ARM\n"
    unused = f"{turns[0]}, 2, 3\n{turns[1]}, 2, 3\nAXIAL, 2, 3\n"
    text += f"*BOUNDARY\nFAR, 1, 3\nSIDES, 2\n{unused}"
    text += f"*STEP, INC=1000\n*STATIC\n{1.0 / increments!r}, 1., 1e-5, {1.0 / increments!r}\n"
    text += f"*BOUNDARY\n{turns[0]}, 1, 1, {turn!r}\n"
    text += "*NODE PRINT, NSET=ENDS\nRF\n*NODE PRINT, NSET=SHOWN\nU\n"
    text += "*EL PRINT, ELSET=ROUGH\nE, S, SDV\n*END STEP\n"
    return text, points, arms, layer


def run(
    program: Path, folder: Path, interface: Interface, ratio: float, turn: float, n: int = 120,
    increments: int = 50,
) -> Result:  # fmt: skip
    """Rotate the ends; see `deck`."""
    text, points, arms, layer = deck(interface, ratio, turn, n, increments)
    done = calculix_run.run(program, folder, text)
    if done.code != 0:
        raise RuntimeError(f"ccx ended with {done.code}:\n{done.output[-2000:]}\n{done.errors[-2000:]}")
    time, forces = done.table("ENDS forces")  # a node with equations alone has no reaction
    _, u = done.table("SHOWN displacements")
    _, strain = done.table("ROUGH strains")
    _, state = done.table("ROUGH internal")
    _, stress = done.table("ROUGH stresses")
    # the first two columns are element and point; CalculiX prints tensor shears
    separation = THICKNESS * strain[:, :, 2:][..., [N, TX, TY]] * [1.0, 2.0, 2.0]
    height = points[forces[0, :, 0].astype(int) - 1, 2]
    lever = height - np.sign(height) * 0.5 * (THICKNESS + HEIGHT)
    moments = [(forces[:, arm, 1] * lever[arm]).sum(axis=1) for arm in (height > 0.0, height < 0.0)]
    return Result(
        time, np.stack(moments, axis=1), separation, stress[:, :, 2:][..., [N, TX, TY]], state[:, :, 2:],
        u[:, :, 1:], done,
        paraview.Structure(points, np.array(arms) - 1, np.array(layer) - 1, (2, 2, 2), ORDER),
    )  # fmt: skip


def write_paraview(pvd: Path, result: Result) -> None:
    """Write all increments for ParaView."""
    rows = zip(result.displacement, result.separation, result.traction, result.state, strict=True)
    paraview.write(pvd, result.structure, (paraview.Step(float(k), *row) for k, row in enumerate(rows)))


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="Mixed-mode beam in CalculiX.")
    parser.add_argument("program", type=calculix_run.program_file, help="ccx linked with libasperity")
    parser.add_argument("--csv", type=Path, metavar="FILE.csv", help="write moment and energy release rate")
    parser.add_argument("--pvd", type=Path, metavar="FILE.pvd", help="write all increments for ParaView")
    options = parser.parse_args()
    ratio, turn = 0.5, 0.06
    with tempfile.TemporaryDirectory() as folder:
        result = run(options.program, Path(folder), ROUGH, ratio, turn)
    # the law of one point, by the library, on the separations that CalculiX found
    law = ROUGH.replay(result.separation[:, 0])
    work, friction = law.work, law.state[-1, contract.statev_index("friction")]
    bent = np.sqrt(work * 4.0 * STIFFNESS / (21.0 * (1.0 + ratio**2) - 6.0 * ratio))
    steady = result.release[result.time > 0.9]
    iterations = sum(result.run.iterations)
    print(f"{len(result.time)} increments, {iterations} iterations, {result.run.attempts} attempts")
    print(f"energy release rate at the end {steady.min():.4f} to {steady.max():.4f} N/mm")
    print(f"Gc {ROUGH.material.Gc:g} N/mm")
    print(f"work of the law at the first point {work[-1]:.4f} N/mm, friction in it {friction:.4f}")
    if options.csv is not None:
        table = np.column_stack([turn * result.time, result.moments[:, 0], result.release, bent, work])
        head = "rotation,moment,release,moment_point,release_point"
        np.savetxt(options.csv, table, "%.6f", ",", header=head, comments="")
    if options.pvd is not None:
        write_paraview(options.pvd, result)


if __name__ == "__main__":
    main()
