"""An arm is peeled off another in Akantu, by explicit dynamics with elements inserted during the run.

Plane strain, mm, N, MPa, t, s, thickness 1.  The arms are one body at the start, clamped at its right face;
the left end of the upper arm is pulled up.  Where the stress between the arms has reached half of the
strength, Akantu inserts elements of the joint, which begin with that stress.  As a script this module prints
the balance of energy and writes the files for ParaView.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import dataclass
from itertools import count
from pathlib import Path

import akantu as aka
import meshio
import numpy as np
from asperity import Interface, Material, Pattern, contract
from asperity.contract import Floats

sys.path.insert(0, str(Path(__file__).parent.parent))
sys.path.insert(0, str(Path(__file__).parent / "kit"))
import structured
from asperity.mesh import paraview
from asperity_akantu import Joint, Points, register

JOINT = Interface(Material(sigma0=3.0, Gc=0.003, eta=0.9, mu=0.5), Pattern.regular(4, theta=30.0))
LENGTH, HEIGHT, SIZE = 40.0, 4.0, 1.0
ARMS = 2.5e-9, 30000.0, 0.2
"""Density, Young's modulus and Poisson's ratio."""

SPEED, OPENING = 300.0, 0.13
"""Of the pulled end, mm/s and mm."""

STABLE = 0.5
"""Time step over the largest that is stable for the arms."""

ROWS = 60
AREA = SIZE / 2.0
"""Of a point of the joint."""

CELL = aka._cohesive_2d_4
RUNS = count()
"""Numbers for names, each of which can be registered once."""

INPUT = """
model solid_mechanics_model_cohesive [
  cohesive_inserter [
    bounding_box = [{box}]
  ]
  material elastic [
    name = block
    rho = {solid[0]}
    E = {solid[1]}
    nu = {solid[2]}
  ]
  {card}
]
"""

DAMAGE, *ENERGIES = (contract.statev_index(name) for name in paraview.OF_STATE)


@dataclass(frozen=True)
class Result:
    """Rows of the run: force, its work, energies of arms and joint; steps for ParaView."""

    force: Floats
    work: Floats
    arms: Floats
    joint: Floats
    steps: list[paraview.Step]

    @property
    def unbalanced(self) -> float:
        """Largest difference of the work and the energies, relative to the work at the end."""
        return float(np.abs(self.work - self.arms - self.joint).max() / self.work[-1])

    @property
    def elements(self) -> list[int]:
        """Number of elements of the joint."""
        return [len(step.state) for step in self.steps]


def run(folder: Path) -> Result:
    """Pull the end of the upper arm up."""
    x, y = (np.linspace(0.0, side, round(side / SIZE) + 1) for side in (LENGTH, 2.0 * HEIGHT))
    model, mesh, joint = start(folder, structured.grid(x, y, sides=()), JOINT, HEIGHT, ARMS)
    dt = STABLE * model.getStableTimeStep()
    model.setTimeStep(dt)
    count = int(np.ceil(OPENING / (SPEED * dt)))
    shown = set(np.linspace(0, count, ROWS + 1).round().astype(int)[1:].tolist())
    nodes = np.array(mesh.getNodes())
    end = np.flatnonzero((nodes[:, 0] < 1e-9) & (nodes[:, 1] == 2.0 * HEIGHT))
    model.getBlockedDOFs()[nodes[:, 0] > LENGTH - 1e-9] = True
    model.getBlockedDOFs()[end, 1] = True
    rows, steps, work, force, initial_energy, points = [], [], 0.0, 0.0, 0.0, 0
    for k in range(1, count + 1):
        model.checkCohesiveStress()
        model.getVelocity()[end, 1] = SPEED
        model.getDisplacement()[end, 1] = SPEED * k * dt
        model.solveStep("explicit_lumped")
        old, force = force, -float(np.array(model.getInternalForce())[end, 1].sum())
        work += 0.5 * (old + force) * SPEED * dt
        at = joint.points(CELL) if CELL in joint.types() else None
        if at is not None and len(at.state) > points:
            # a new element begins with the energy of its initial stress
            initial_energy += AREA * float(at.state[points:, ENERGIES[0]].sum())
            points = len(at.state)
        joint.commit()
        if k in shown:
            step = step_of(mesh, model, at, SPEED * k * dt)
            of_joint = AREA * float(step.state[..., ENERGIES].sum()) - initial_energy
            of_arms = model.getEnergy("kinetic") + model.getEnergy("potential")
            rows.append((force, work, of_arms, of_joint))
            steps.append(step)
    return Result(*(np.array(column) for column in zip(*rows, strict=True)), steps)


def start(
    folder: Path,
    mesh: meshio.Mesh,
    joint: Interface,
    z: float,
    solid: tuple[float, float, float],
    extrinsic: bool = True,
    method: object = aka._explicit_lumped_mass,
    of_card: bool = False,
    **options: object,
) -> tuple[aka.SolidMechanicsModelCohesive, aka.Mesh, Joint]:
    """Model, mesh, which must live on, and joint at the height z of a mesh of one kind of cells.

    solid: density, Young's modulus, Poisson's ratio.  extrinsic: whether elements are inserted during the
    run.  of_card: the input file has the constants, by `asperity card`.  options: of `register`.
    """
    name, dimension = f"asperity_{next(RUNS)}", mesh.points.shape[1]
    joints = register(None if of_card else joint, name, **options)
    card = joint.card("akantu", name="joint") if of_card else "material asperity [\n    name = joint\n  ]"
    card = card.replace("material asperity [", f"material {name} [")
    low, high = mesh.points.min(axis=0) - 1.0, mesh.points.max(axis=0) + 1.0
    low[-1], high[-1] = z - 0.1, z + 0.1
    box = ", ".join(f"[{a}, {b}]" for a, b in zip(low, high, strict=True))
    text = INPUT.format(box=box, solid=solid, card=card)
    (folder / "input.dat").write_text(text, encoding="utf-8")
    tags = [np.ones(len(mesh.cells[0].data), dtype=int)]
    unsplit = meshio.Mesh(
        np.pad(mesh.points, ((0, 0), (0, 3 - dimension))), mesh.cells,
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
        field_data={"blocks": np.array([1, dimension])},
    )  # fmt: skip
    unsplit.write(folder / "mesh.msh", file_format="gmsh22", binary=False)
    aka.parseInput(str(folder / "input.dat"))
    akantu_mesh = aka.Mesh(dimension)
    akantu_mesh.read(str(folder / "mesh.msh"))
    model = aka.SolidMechanicsModelCohesive(akantu_mesh)
    model.initFull(_analysis_method=method, _is_extrinsic=extrinsic)
    if extrinsic:
        model.updateAutomaticInsertion()
    return model, akantu_mesh, joints[0]


def step_of(
    mesh: aka.Mesh, model: aka.SolidMechanicsModelCohesive, points: Points | None, time: float
) -> paraview.Step:
    """Step for ParaView; the two sides of a joint have the same direction in Akantu."""
    solids, joints = (np.array(mesh.getConnectivity(kind)) for kind in (aka._quadrangle_4, CELL))
    nodes, u = np.array(mesh.getNodes()), np.array(model.getDisplacement())
    empty = np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, JOINT.nstatv))
    values = empty if points is None else (points.separation, points.traction, points.state)
    of_joints = (of_sides.reshape(-1, 2, of_sides.shape[1]).copy() for of_sides in values)
    return paraview.Step(time, nodes, u, "quad", solids, joints[:, [0, 1, 3, 2]], *of_joints)


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="Arm peeled off in Akantu by explicit dynamics.")
    parser.add_argument("--pvd", type=Path, metavar="FILE.pvd", help="write rows of the run for ParaView")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        result = run(Path(name))
    print(f"elements of the joint {result.elements[0]} to {result.elements[-1]}, of {round(LENGTH / SIZE)}")
    print(f"largest force {result.force.max():.4f} N, at the end {result.force[-1]:.4f} N")
    print(f"work {result.work[-1]:.5f} N mm: arms {result.arms[-1]:.5f}, joint {result.joint[-1]:.5f}")
    print(f"difference of work and energies {result.unbalanced:.1e} of the work")
    if options.pvd is not None:
        paraview.write(options.pvd, result.steps)
        print(options.pvd)


if __name__ == "__main__":
    main()
