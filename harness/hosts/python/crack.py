"""Benchmarks with closed forms in scikit-fem: a crack, half length b, in a large plate, plane strain.

- friction: a closed crack, inclined to a uniaxial compression, slips (Phan 2003).
- pressure: a fluid opens the crack (Sneddon).
- dilation: the crack of the first has planes of one constant slope.  Slip and opening are then ellipses, too.
- height: the same planes end at a finite height.  There is no closed form.

The joint is fully damaged in all of them.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from asperity import Interface, Material, Pattern
from asperity.options import add_options
from asperity.style import COLOURS, TWO, new_figure, printed, save
from joint import Floats, Joint, Newton, progress
from scipy import sparse
from skfem import Basis, ElementQuad2, ElementVector, FacetBasis, LinearForm, MeshQuad
from skfem.models.elasticity import lame_parameters, linear_elasticity

# mm, N, MPa
B = 1000.0
MODULUS, POISSON = 25000.0, 0.25  # K = 16.7 GPa, G = 10 GPa
PLANE_STRAIN = MODULUS / (1 - POISSON**2)
SIGMA, ANGLE, FRICTION = 100.0, math.radians(20.0), math.radians(30.0)
PRESSURE = 10.0
THETA, HEIGHT = 10.0, 0.5
NORMAL, SLIDING = SIGMA * math.sin(ANGLE) ** 2, SIGMA * math.sin(ANGLE) * math.cos(ANGLE)
"""Far compression and shear stress on the plane of the crack."""
RIGID, STIFF = 1e5 * PLANE_STRAIN / B, 1e2 * PLANE_STRAIN / B
"""Stiffness of the joint: without effect on the slip, and one that lets slopes change in few steps."""
COMPLIANCE = 4 / PLANE_STRAIN
"""Slip or opening over stress and sqrt(b^2 - s^2)."""
MESHES = (8, 16, 32)
"""Elements along the crack."""
DOMAIN = 100.0
"""Half width of the plate over b."""
STEPS = {"friction": 1, "pressure": 1, "dilation": 1, "height": 10}


def interface(kind: str) -> Interface:
    """Joint of a benchmark."""
    ends = kind == "height"
    stiffness = STIFF if ends else RIGID
    others = {"height": HEIGHT} if ends else {}
    material = Material.from_joint(kn=stiffness, ks=stiffness, mu=math.tan(FRICTION), **others)
    inclined = kind in ("dilation", "height")
    return Interface(material, Pattern.regular(2, THETA) if inclined else Pattern.regular(0, 0.0))


def closed_form(kind: str) -> tuple[float, float, float]:
    """Factors of sqrt(b^2 - s^2) of opening and slip, and the normal traction on the crack.

    A uniform stress that the crack lacks opens it, or makes it slip, as an ellipse.  With the slope T the
    opening is T times the slip, which raises the compression p on the crack:
    T (far shear - p tan(phi + theta)) = p - far compression.
    """
    if kind == "pressure":
        return COMPLIANCE * PRESSURE, 0.0, 0.0
    slope = math.tan(math.radians(THETA)) if kind == "dilation" else 0.0
    resistance = math.tan(FRICTION + math.atan(slope))
    pressure = (NORMAL + slope * SLIDING) / (1 + slope * resistance)
    slip = COMPLIANCE * (SLIDING - resistance * pressure)
    return slope * slip, slip, -pressure


@dataclass(frozen=True)
class Crack:
    """Points of a crack: place, weight, separation (N, Tx, Ty) and traction."""

    x: Floats
    weights: Floats
    separation: Floats
    traction: Floats

    def error(self, kind: str) -> float:
        """L2 norm of the error of opening and slip, over that of the closed form."""
        exact = np.sqrt(B**2 - self.x**2)[:, None] * closed_form(kind)[:2]
        weights = self.weights[:, None]
        square = (weights * (self.separation[:, :2] - exact) ** 2).sum() / (weights * exact**2).sum()
        return float(np.sqrt(square))

    def imbalance(self, kind: str) -> Floats:
        """Relative errors of mean opening and slip, which follow from the tractions (theorem of Betti).

        It holds for any law of the joint: the uniform stress of the closed form is the second load case.
        """
        far = np.array([PRESSURE, 0.0]) if kind == "pressure" else np.array([-NORMAL, SLIDING])
        missing = far - self.traction[:, :2]
        mean = COMPLIANCE * (self.weights * np.sqrt(B**2 - self.x**2)) @ missing
        return np.abs(self.weights @ self.separation[:, :2] - mean) / mean.max()


def axes(n: int, domain: float) -> tuple[Floats, Floats]:
    """Lines of the mesh: x, and y of the upper half; elements at the tips are small, far ones are large."""
    half = 1 - np.linspace(1, 0, n // 2 + 1) ** 2
    tip = half[-1] - half[-2]
    growth = 2 ** (MESHES[0] / n)
    count = math.ceil(math.log(1 + (domain - 1) * (growth - 1) / tip) / math.log(growth))
    far = np.cumsum(growth ** np.arange(count))
    far *= (domain - 1) / far[-1]
    right = np.concatenate([half, 1 + far])
    return B * np.concatenate([-right[:0:-1], right]), B * np.concatenate([[0.0], far])


def run(kind: str, n: int, domain: float = DOMAIN) -> Crack:
    """Solve a benchmark in a plate of the half width `domain` times b, with n elements along the crack."""
    element = ElementVector(ElementQuad2())
    x, y = axes(n, domain)
    bases, faces, loads = [], [], []
    for lines in (y, -y[::-1]):
        mesh = MeshQuad.init_tensor(x, lines)
        crack = mesh.facets_satisfying(lambda p: (np.abs(p[1]) < 1e-9 * B) & (np.abs(p[0]) < B))
        inner = mesh.facets_satisfying(lambda p: np.abs(p[1]) < 1e-9 * B)
        outer = np.setdiff1d(mesh.boundary_facets(), inner)
        bases.append(Basis(mesh, element))
        faces.append(FacetBasis(mesh, element, facets=crack, intorder=4))
        loads.append(_far.assemble(FacetBasis(mesh, element, facets=outer)))
    bonded = _bonded(bases)
    joint = Joint(interface(kind), 2 * bases[0].N, *faces, offset=bases[0].N)
    joint.jump = (joint.jump @ bonded).tocsr()
    if kind == "pressure":
        load = joint.jump.T @ np.kron(PRESSURE * joint.weights, [1.0, 0.0])
    else:
        load = bonded.T @ np.concatenate(loads)
    upper = bases[0].doflocs
    ends = [
        np.flatnonzero((np.abs(upper[0] - end) < 1e-9 * B) & (np.abs(upper[1]) < 1e-9 * B))
        for end in (upper[0].min(), upper[0].max())
    ]
    fixed = np.array([*ends[0], ends[1][1]])  # against rigid motions only: there is no force on them
    elastic = linear_elasticity(*lame_parameters(MODULUS, POISSON))
    bodies = sparse.block_diag([elastic.assemble(one) for one in bases])
    newton = Newton((bonded.T @ bodies @ bonded).tocsr(), joint, fixed)
    u = np.zeros(bonded.shape[1])
    for k in range(STEPS[kind]):
        u, _ = newton.step(u, np.zeros(3), (k + 1) / STEPS[kind] * load)
        progress(f"crack: {kind}, {n} elements, step {k + 1} of {STEPS[kind]}")
    progress("")
    return Crack(joint.x, joint.weights, joint.separation, joint.traction)


@LinearForm
def _far(v, w):
    """Far stress on the outer edges, which drives the upper face towards +x."""
    return (
        -SIGMA
        * (math.cos(ANGLE) * w.n[0] - math.sin(ANGLE) * w.n[1])
        * (math.cos(ANGLE) * v[0] - math.sin(ANGLE) * v[1])
    )


def _bonded(bases: list[Basis]) -> sparse.csr_array:
    """Matrix from the unknowns to those of both halves, which share the nodes of y = 0 beside the crack."""
    n = bases[0].N
    shared = []
    for basis in bases:
        x, y = basis.doflocs
        found = np.flatnonzero((np.abs(y) < 1e-9 * B) & (np.abs(x) > B * (1 - 1e-9)))
        shared.append(found[np.lexsort((found, x[found]))])
    columns = np.empty(2 * n, dtype=int)
    columns[:n] = np.arange(n)
    own = np.setdiff1d(np.arange(n), shared[1])
    columns[n + own] = n + np.arange(len(own))
    columns[n + shared[1]] = shared[0]
    return sparse.csr_array((np.ones(2 * n), (np.arange(2 * n), columns)), shape=(2 * n, n + len(own)))


def draw(cracks: dict[str, Crack], path: Path) -> None:
    """Slip, opening and compression along the crack; lines are closed forms."""
    with printed():
        figure, (slip, opening, compression) = new_figure(TWO, 2.9, ncols=3)
        s = B * np.sin(np.linspace(-math.pi / 2, math.pi / 2, 201))
        ellipse = np.sqrt(B**2 - s**2)
        labels = {"dilation": "constant slope", "height": "finite height", "pressure": "fluid"}
        for colour, kind in zip(COLOURS, ("friction", *labels), strict=False):
            crack = cracks[kind]
            panels = [slip, compression] if kind != "pressure" else [opening]
            panels += [opening] if kind in ("dilation", "height") else []
            for panel in panels:
                column = 1 if panel is slip else 0
                found = -crack.traction[:, 0] if panel is compression else crack.separation[:, column]
                panel.plot(crack.x / B, found, ".", color=colour, markersize=3, label=labels.get(kind, kind))
                if kind != "height":
                    *factors, normal = closed_form(kind)
                    exact = np.full(len(s), -normal) if panel is compression else factors[column] * ellipse
                    panel.plot(s / B, exact, color=colour, linewidth=0.8)
        slip.set(ylabel="slip [mm]", ylim=(0, 5.2))
        opening.set(ylabel="opening [mm]", ylim=(0, 2.1))
        compression.set(ylabel="compression on the crack [MPa]", ylim=(8, 20))
        for panel in (slip, opening, compression):
            panel.set(xlabel="place s/b [-]")
            panel.legend()
            panel.grid(alpha=0.3)
        save(figure, path)


def main() -> None:
    """Run all benchmarks, print errors and orders, and draw the results of the second mesh."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add_options(
        parser,
        ("--elements", "along the crack, even (default: %(default)s)", int, {"nargs": 3, "default": MESHES}),
        ("-o --output FILE", "picture", Path("crack.png")),
    )
    options = parser.parse_args()
    for n in options.elements:
        if n < 2 or n % 2:
            parser.error(f"--elements {n}: expected even numbers > 0")
    print("benchmark  elements  L2 error  order  largest slip, opening [mm]  normal traction at s = 0 [MPa]")
    shown = {}
    for kind in STEPS:
        before = None
        for n in options.elements if kind != "height" else options.elements[:2]:
            crack = run(kind, n)
            if n == options.elements[1]:
                shown[kind] = crack
            errors = " " * 17
            if kind != "height":
                error = crack.error(kind)
                order = math.log(before[1] / error) / math.log(n / before[0]) if before else math.nan
                errors, before = f"{error:10.5f}{order:7.2f}", (n, error)
            opening, slip, _ = crack.separation.max(axis=0)
            normal = crack.traction[np.abs(crack.x).argmin(), 0]
            print(f"{kind:9}{n:10}{errors}{slip:14.4f}{opening:14.4f}{normal:20.4f}")
    domains = (4 * DOMAIN, 5.0, 10.0, 20.0, DOMAIN)
    far, *slips = (run("friction", options.elements[0], one).separation[:, 1].max() for one in domains)
    for domain, slip in zip(domains[1:], slips, strict=True):
        print(f"half width {domain:g} b: slip {slip / far - 1:+.1e} of that in a plate of {domains[0]:g} b")
    draw(shown, options.output)
    print(options.output)


if __name__ == "__main__":
    main()
