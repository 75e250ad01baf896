"""Double cantilever beam with the law in scikit-fem, compared with beam theory and the J integral.

Two elastic arms on a rough interface are opened at their ends. Beam theory gives force and opening of a crack
that grows at G = Gc. The J integral is P times the rotation between the ends. It is the energy that the
interface dissipates at the tip, which is Gc for any pattern once the cohesive zone has formed.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from asperity import Interface, Material, Pattern
from asperity.style import TWO, printed, save
from joint import Floats, Joint, Newton, NotConverged, progress
from matplotlib.figure import Figure
from scipy import sparse
from skfem import Basis, ElementQuad2, ElementVector, FacetBasis, MeshQuad
from skfem.models.elasticity import lame_parameters, linear_elasticity

# mm, N, MPa
MODULUS, POISSON = 70000.0, 0.3
LENGTH, HEIGHT, CRACK = 70.0, 3.0, 30.0
MATERIAL = Material(sigma0=30.0, Gc=0.3, eta=0.9, mu=0.5)
PATTERN = Pattern.regular(4, 30.0)
PLANE_STRAIN = MODULUS / (1 - POISSON**2)
SHEAR = MODULUS / (2 * (1 + POISSON))
GAMMA = 1.18 * MODULUS / SHEAR
ROOT = float(np.sqrt(MODULUS / (11 * SHEAR) * (3 - 2 * (GAMMA / (1 + GAMMA)) ** 2)))
"""chi of Williams (1989) for isotropic arms: additional crack length over the height, for root rotation."""


@dataclass(frozen=True)
class Curve:
    """Rows of a run: opening of the ends, force, J integral and crack length where damage is complete."""

    opening: Floats
    force: Floats
    j_integral: Floats
    crack: Floats
    mesh: tuple[Floats, Floats, Floats]
    norms: list[float]
    iterations: int
    seconds: tuple[float, float]
    points: int


def beam(opening: Floats, crack: Floats) -> Floats:
    """Force of a crack of a given length before it grows."""
    return PLANE_STRAIN * HEIGHT**3 * opening / (8 * (crack + ROOT * HEIGHT) ** 3)


def growth(opening: Floats) -> Floats:
    """Force while the crack grows at G = 12 P^2 a^2/(E h^3) = Gc; the opening 8 P a^3/(E h^3) gives a."""
    force_times_crack = np.sqrt(MATERIAL.Gc * PLANE_STRAIN * HEIGHT**3 / 12)
    crack = np.sqrt(opening * PLANE_STRAIN * HEIGHT**3 / (8 * force_times_crack))
    return force_times_crack / crack


def run(opening: float, steps: int, size: float, symmetric: bool = False) -> Curve:
    """Open the ends in steps; the mesh has elements of `size` along the beam and two over each arm."""
    arms, places, upper_face, lower_face = _bodies(size)
    n = arms[0].N
    stiffness = sparse.block_diag([_elastic(arm) for arm in arms]).tocsr()
    joint = Joint(Interface(MATERIAL, PATTERN), 2 * n, upper_face, lower_face, offset=n)
    upper, lower = places
    fixed = np.array([upper["end"][1], n + lower["end"][1], upper["far"][0], n + lower["far"][0]])
    newton = Newton(stiffness, joint, fixed, symmetric)
    u = np.zeros(2 * n)
    rows = [(0.0, 0.0, 0.0, CRACK)]
    started, done, part = time.perf_counter(), 0.0, 1.0 / steps
    while done < 1.0 - 1e-12:
        target = min(done + part, 1.0)
        try:
            u, out = newton.step(u, opening * target * np.array([0.5, -0.5, 0.0, 0.0]), np.zeros(2 * n))
        except NotConverged:
            part /= 2
            if part < 1e-3 / steps:
                raise
            continue
        done, part = target, min(1.0 / steps, 2 * part)
        turn = sum(
            abs(u[first + at["end top"][0]] - u[first + at["end bottom"][0]]) / HEIGHT
            for first, at in ((0, upper), (n, lower))
        )
        force = float(out[fixed[0]])
        broken = joint.x[joint.state[:, 0] >= 1.0 - 1e-12]
        rows.append((opening * done, force, force * turn, float(broken.max(initial=CRACK))))
        progress(f"dcb: opening {opening * done:.3f} of {opening:g} mm, {len(newton.norms) - 1} iterations")
    progress("")
    columns = np.array(rows).T
    seconds = (time.perf_counter() - started, joint.seconds)
    mesh = np.concatenate([arm.doflocs for arm in arms], axis=1)
    return Curve(*columns, (mesh, u, np.column_stack([joint.x, joint.state[:, 0]])), newton.norms,
                 newton.iterations, seconds, len(joint.x))  # fmt: skip


def _bodies(size: float) -> tuple[list[Basis], list[dict[str, np.ndarray]], FacetBasis, FacetBasis]:
    """Bases of the arms, unknowns (x, y) of the loaded nodes, and the faces ahead of the crack."""
    element = ElementVector(ElementQuad2())
    x = np.linspace(0.0, LENGTH, round(LENGTH / size) + 1)
    arms, places, faces = [], [], []
    for bottom in (0.0, -HEIGHT):
        mesh = MeshQuad.init_tensor(x, np.linspace(bottom, bottom + HEIGHT, 3))
        basis = Basis(mesh, element)
        arms.append(basis)
        middle = bottom + HEIGHT / 2
        corners = {"end": (0.0, middle), "far": (LENGTH, middle), "end top": (0.0, bottom + HEIGHT)}
        corners["end bottom"] = (0.0, bottom)
        places.append({name: _unknowns(basis, *at) for name, at in corners.items()})
        ahead = mesh.facets_satisfying(lambda p: (np.abs(p[1]) < 1e-9) & (p[0] > CRACK))
        faces.append(FacetBasis(mesh, element, facets=ahead, intorder=4))
    return arms, places, *faces


def _unknowns(basis: Basis, x: float, y: float) -> np.ndarray:
    """Unknowns (x, y) of the node at a place."""
    found = np.flatnonzero((np.abs(basis.doflocs[0] - x) < 1e-9) & (np.abs(basis.doflocs[1] - y) < 1e-9))
    if len(found) != 2:
        raise ValueError(f"({x:g}, {y:g}): expected a node")
    return found


def _elastic(basis: Basis) -> sparse.csr_array:
    """Stiffness in plane strain."""
    return linear_elasticity(*lame_parameters(MODULUS, POISSON)).assemble(basis)


def draw(curve: Curve, path: Path) -> None:
    """Force and J integral over the opening, and the deformed arms with the damage between them."""
    with printed():
        save(_figure(curve), path)


def _figure(curve: Curve) -> Figure:
    figure = Figure(figsize=(TWO, 4.4), layout="constrained")
    axes = figure.subplot_mosaic([["shape", "shape"], ["force", "energy"]], height_ratios=(1.0, 1.2))
    force, energy, shape = axes["force"], axes["energy"], axes["shape"]
    force.plot(curve.opening, curve.force, color="#0072B2", label="scikit-fem with asperity")
    force.plot(
        curve.opening,
        growth(np.maximum(curve.opening, 1e-9)),
        "--",
        color="#D55E00",
        label="beam theory, G = Gc",
    )
    force.plot(
        curve.opening,
        beam(curve.opening, np.array(CRACK)),
        ":",
        color="black",
        label="beam theory, initial crack, rigid joint",
    )
    force.set(
        xlabel="opening of the ends [mm]", ylabel="force per width [N/mm]", ylim=(0, 1.3 * curve.force.max())
    )
    force.legend()
    energy.plot(curve.opening, curve.j_integral / MATERIAL.Gc, color="#0072B2")
    energy.axhline(1.0, color="#D55E00", linestyle="--")
    energy.set(xlabel="opening of the ends [mm]", ylabel="J / Gc [-]")
    places, u, damage = curve.mesh
    x, y = places[0][::2], places[1][::2]
    ux, uy = u[::2], u[1::2]
    moved_x, moved_y = x + ux, y + uy
    half = len(x) // 2
    for arm in (slice(0, half), slice(half, None)):
        for level in np.unique(y[arm]):
            line = np.flatnonzero(y[arm] == level) + arm.start
            line = line[np.argsort(x[line])]
            shape.plot(moved_x[line], moved_y[line], color="grey", linewidth=0.6)
        # the damage on the deformed face of this arm
        face = np.flatnonzero(np.abs(y[arm]) < 1e-9) + arm.start
        face = face[np.argsort(x[face])]
        at = [np.interp(damage[:, 0], x[face], values[face]) for values in (moved_x, moved_y)]
        points = shape.scatter(*at, c=damage[:, 1], s=5.0, cmap="cividis", vmin=0, vmax=1, zorder=3)
    figure.colorbar(points, cax=shape.inset_axes([1.02, 0.0, 0.015, 1.0]), label="damage [-]")
    shape.set(xlabel="x [mm]", ylabel="y [mm]", title="deformed arms, displacements to scale", aspect="equal")
    for ax in (force, energy):
        ax.grid(alpha=0.3)
    return figure


def main() -> None:
    """Run, print and draw."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--opening", type=float, default=3.0, help="opening of the ends, mm (default: %(default)s)"
    )
    parser.add_argument("--steps", type=int, default=40, help="default: %(default)s")
    parser.add_argument(
        "--size", type=float, default=0.5, help="size of the elements, mm (default: %(default)s)"
    )
    parser.add_argument("-o", "--output", type=Path, default=Path("dcb.png"), help="default: %(default)s")
    options = parser.parse_args()
    curve = run(options.opening, options.steps, options.size)
    print("opening [mm]  force [N/mm]  beam [N/mm]  J/Gc   crack [mm]")
    for i in range(0, len(curve.opening), max(1, len(curve.opening) // 12)):
        reference = min(
            beam(curve.opening[i : i + 1], np.array(CRACK))[0], growth(curve.opening[i : i + 1] + 1e-12)[0]
        )
        share = curve.j_integral[i] / MATERIAL.Gc
        print(f"{curve.opening[i]:12.3f}{curve.force[i]:14.4f}{reference:13.4f}{share:7.4f}"
              f"{curve.crack[i]:11.2f}")  # fmt: skip
    print("last step, residuals:", ", ".join(f"{norm:.1e}" for norm in curve.norms))
    total, law = curve.seconds
    print(f"{curve.iterations} iterations in {total:.1f} s, {law:.2f} s in the law ({curve.points} points)")
    draw(curve, options.output)
    print(options.output)


if __name__ == "__main__":
    main()
