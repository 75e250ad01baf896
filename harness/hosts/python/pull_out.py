"""Bond-slip: a block pressed on a rough base is pulled along the base, with the law in scikit-fem.

The block rises on the planes of the interface as it slides.  At the end the force is the pressure on the base
times (mu + tan theta)/(1 - mu tan theta), wherever the planes fail first.  A second run with the symmetric
part of the tangent shows the cost of a solver without unsymmetric matrices.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from asperity import Interface, Material, Pattern
from asperity.style import TWO, new_figure, printed, save
from joint import Floats, Joint, Newton, NotConverged, progress
from matplotlib.figure import Figure
from skfem import Basis, ElementQuad2, ElementVector, FacetBasis, LinearForm, MeshQuad
from skfem.models.elasticity import lame_parameters, linear_elasticity

sys.path.insert(0, str(Path(__file__).parent.parent))
import paraview_files as paraview

# mm, N, MPa: Table 2 of the paper with a stiffer contact
MODULUS, POISSON = 30000.0, 0.2
LENGTH, HEIGHT, PRESSURE = 200.0, 50.0, 1.0
THETA = 30.0
MATERIAL = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=10.0)
INTERFACE = Interface(MATERIAL, Pattern.regular(2, THETA))
PRESS_STEPS = 10


@dataclass(frozen=True)
class Curve:
    """Rows of a run: displacement of the pulled face, force, rise of the block, and the cost.

    separation, traction, state: of the points of the base (rows, points, ...), the first row after pressing.
    nodes: positions of the corners of the elements (n, 2), their displacements (rows, n, 2), elements (k, 4).
    """

    slip: Floats
    force: Floats
    rise: Floats
    damage: tuple[Floats, Floats]
    iterations: int
    cuts: int
    norms: list[list[float]]
    separation: Floats
    traction: Floats
    state: Floats
    nodes: tuple[Floats, Floats, np.ndarray]


def residual_strength() -> float:
    """Force over the width at the end, N/mm."""
    return float(PRESSURE * LENGTH * MATERIAL.residual_strength(THETA))


def material_point(slips: Floats) -> Floats:
    """Force if all points of the interface had the same separation."""
    return INTERFACE.confined_slip(0.0, slips, -PRESSURE).traction[:, 1] * LENGTH


def run(slip: float, steps: int, n: int, symmetric: bool = False) -> Curve:
    """Press, then pull the right face along x by a slip; n elements along the base."""
    element = ElementVector(ElementQuad2())
    mesh = MeshQuad.init_tensor(np.linspace(0, LENGTH, n + 1), np.linspace(0, HEIGHT, max(2, n // 4) + 1))
    basis = Basis(mesh, element)
    facets = mesh.facets_satisfying(lambda p: p[1] < 1e-9)
    base = FacetBasis(mesh, element, facets=facets, intorder=4)
    top = FacetBasis(mesh, element, facets=mesh.facets_satisfying(lambda p: p[1] > HEIGHT - 1e-9))
    right = np.flatnonzero(basis.doflocs[0] > LENGTH - 1e-9)
    pulled = right[::2]  # unknowns come in pairs x, y
    middle = _nearest(basis, LENGTH / 2, HEIGHT)
    load = LinearForm(lambda v, w: -PRESSURE * v[1]).assemble(top)
    stiffness = linear_elasticity(*lame_parameters(MODULUS, POISSON)).assemble(basis).tocsr()
    newton = Newton(
        stiffness, Joint(INTERFACE, basis.N, base), pulled, symmetric, most=60 if symmetric else 20
    )

    u, norms, cuts = np.zeros(basis.N), [], 0
    for k in range(PRESS_STEPS):
        u, out = newton.step(u, np.zeros(len(pulled)), (k + 1) / PRESS_STEPS * load)
    # the fixed face prevents the pressed block from widening
    rows = [(0.0, float(out[pulled].sum()), 0.0)]
    points, moves = [newton.joint.points()], [u[basis.nodal_dofs.T]]
    pressed = u[middle + 1]
    done, part = 0.0, 1.0 / steps
    while done < 1.0 - 1e-12:
        target = min(done + part, 1.0)
        moved = slip * target
        try:
            u, out = newton.step(u, np.full(len(pulled), moved), load)
        except NotConverged:
            cuts, part = cuts + 1, part / 2
            if part < 1e-3 / steps:
                raise
            continue
        done, part = target, min(1.0 / steps, 2 * part)
        norms.append(newton.norms)
        points.append(newton.joint.points())
        moves.append(u[basis.nodal_dofs.T])
        rows.append((moved, float(out[pulled].sum()), float(u[middle + 1] - pressed)))
        progress(f"pull_out: slip {moved:.3f} of {slip:g} mm, {len(newton.norms)} iterations")
    progress("")
    damage = (newton.joint.x, newton.joint.state[:, 0])
    nodes = (mesh.p.T, np.array(moves), mesh.t.T)
    histories = (np.array(values) for values in zip(*points, strict=True))
    return Curve(*np.array(rows).T, damage, newton.iterations, cuts, norms, *histories, nodes)


def _nearest(basis: Basis, x: float, y: float) -> int:
    """Unknown x of the node nearest to a place; that of y follows."""
    distance = np.hypot(basis.doflocs[0] - x, basis.doflocs[1] - y)
    return int(np.argmin(distance))


def draw(curve: Curve, path: Path) -> None:
    """Force and rise over the slip."""
    with printed():
        save(_figure(curve), path)


def _figure(curve: Curve) -> Figure:
    figure, (force, rise) = new_figure(TWO, 2.8, ncols=2)
    force.plot(curve.slip, curve.force, color="#0072B2", label="block in scikit-fem")
    slips = np.linspace(0, curve.slip[-1], 201)[1:]
    force.plot(slips, material_point(slips), "--", color="#D55E00", label="material point")
    force.axhline(residual_strength(), color="black", linestyle=":", label="residual strength")
    force.set(xlabel="displacement of the pulled face [mm]", ylabel="force per width [N/mm]")
    force.legend()
    rise.plot(curve.slip, curve.rise, color="#0072B2")
    rise.set(xlabel="displacement of the pulled face [mm]", ylabel="rise of the block [mm]")
    for ax in (force, rise):
        ax.grid(alpha=0.3)
    return figure


def write_paraview(pvd: Path, curve: Curve) -> None:
    """Write all rows for ParaView; the rigid base has nodes below those of the block, which do not move."""
    block, moves, cells = curve.nodes
    base = np.flatnonzero(block[:, 1] < 1e-9)
    base = base[np.argsort(block[base, 0])]
    below = len(block) + np.arange(len(base))
    joints = np.stack([below[:-1], below[1:], base[1:], base[:-1]], axis=-1)
    points = curve.separation.shape[1] // len(joints)
    structure = paraview.Structure(np.vstack([block, block[base]]), cells, joints, (points, 1))
    still = np.zeros((len(moves), len(base), 2))
    moved = np.concatenate([moves, still], axis=1)
    rows = zip(moved, curve.separation, curve.traction, curve.state, strict=True)
    paraview.write(pvd, structure, (paraview.Step(float(k), *row) for k, row in enumerate(rows)))


def check(parser: argparse.ArgumentParser, options: argparse.Namespace) -> None:
    """End with a message if slip, steps or elements are not positive."""
    for name in ("slip", "steps", "elements"):
        value = np.min(getattr(options, name))
        if not value > 0:
            parser.error(f"--{name} {value:g}: expected more than 0")


def main() -> None:
    """Run with the whole tangent and with its symmetric part, then print and draw the results."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--slip", type=float, default=0.6, help="mm (default: %(default)s)")
    parser.add_argument("--steps", type=int, default=30, help="default: %(default)s")
    parser.add_argument("--elements", type=int, default=20, help="along the base (default: %(default)s)")
    parser.add_argument(
        "-o", "--output", type=Path, default=Path("pull_out.png"), help="default: %(default)s"
    )
    parser.add_argument("--pvd", type=Path, metavar="FILE.pvd", help="write all steps for ParaView")
    options = parser.parse_args()
    check(parser, options)
    curve = run(options.slip, options.steps, options.elements)
    print("slip [mm]  force [N/mm]  material point [N/mm]  rise [mm]")
    every = max(1, len(curve.slip) // 12)
    points = material_point(curve.slip[::every])
    for slip, force, point, rise in zip(
        curve.slip[::every], curve.force[::every], points, curve.rise[::every], strict=True
    ):
        print(f"{slip:9.3f}{force:14.3f}{point:23.3f}{rise:11.4f}")
    print(f"residual strength {residual_strength():.6f}, force at the end {curve.force[-1]:.6f} N/mm")
    worst = max(curve.norms, key=len)
    print("step with most iterations, residuals:", ", ".join(f"{norm:.1e}" for norm in worst))
    print(f"{curve.iterations} iterations, {curve.cuts} cuts")
    try:
        other = run(options.slip, options.steps, options.elements, symmetric=True)
        print(f"symmetric part of the tangent: {other.iterations} iterations, {other.cuts} cuts")
    except NotConverged as error:
        last = str(error).split()[-1]
        print(f"symmetric part of the tangent: a step is not done after 60 iterations, residual {last}")
    draw(curve, options.output)
    print(options.output)
    if options.pvd is not None:
        write_paraview(options.pvd, curve)
        print(options.pvd)


if __name__ == "__main__":
    main()
