"""Snap-back of a bar, passed by dissipation control, with the law in scikit-fem.

The bar pulls a joint apart. If it is longer than E (s_f - s_0)/sigma0, it shortens by more than the joint
opens while the joint softens: the displacement of its end has to turn back. Newton's method with prescribed
displacements finds no neighbouring equilibrium there.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from asperity import Interface, Material, Pattern, contract
from asperity.options import add_options
from asperity.tools.style import COLOURS, TWO, new_figure, printed, save
from dissipation import DissipationControl
from joint import Floats, Joint, Newton, NotConverged
from skfem import Basis, ElementQuad1, ElementVector, FacetBasis, MeshQuad
from skfem.models.elasticity import lame_parameters, linear_elasticity

# mm, N, MPa
MODULUS = 30000.0
BOND = Material(sigma0=3.0, Gc=0.03, eta=0.9, mu=0.0)
S_F = 2 * BOND.Gc / BOND.sigma0
S_0 = (1 - BOND.eta) * S_F
LIMIT = MODULUS * (S_F - S_0) / BOND.sigma0
"""Length of a bar beyond which it snaps back."""


@dataclass(frozen=True)
class Curve:
    """Rows of a run: displacement of the pulled end and force, per width.

    broken: smallest damage after the last row, 1 if the joint is broken.  rupture: energy of the joint.
    """

    moved: Floats
    force: Floats
    iterations: int
    broken: float
    rupture: float


def bar(length: float, elements: int = 8) -> tuple[Newton, Floats]:
    """Column on a joint with a rigid base, without lateral contraction; its end moves along N."""
    mesh = MeshQuad.init_tensor(np.array([0.0, 1.0]), np.linspace(0.0, length, elements + 1))
    basis = Basis(mesh, ElementVector(ElementQuad1()))
    clamped = np.flatnonzero(basis.doflocs[1] > length - 1e-9)
    base = FacetBasis(mesh, basis.elem, facets=mesh.facets_satisfying(lambda p: p[1] < 1e-9), intorder=4)
    stiffness = linear_elasticity(*lame_parameters(MODULUS, 0.0)).assemble(basis).tocsr()
    joint = Joint(Interface(BOND, Pattern.regular(0, 0.0)), basis.N, base)
    newton = Newton(stiffness, joint, clamped, least=BOND.sigma0 * float(joint.weights.sum()))
    return newton, np.resize([0.0, 1.0], len(clamped))


def by_displacement(model: tuple[Newton, Floats], end: float, steps: int) -> Curve:
    """Newton's method with prescribed displacements, up to the first step without a solution."""
    newton, pattern = model
    u, rows = np.zeros(newton.stiffness.shape[0]), [(0.0, 0.0)]
    for moved in np.linspace(0.0, end, steps + 1)[1:]:
        try:
            u, out = newton.step(u, moved * pattern, np.zeros(len(u)))
        except NotConverged:
            break
        rows.append((moved, float(out[newton.fixed] @ pattern)))
    return _curve(rows, newton)


def by_dissipation(model: tuple[Newton, Floats], energy: float) -> Curve:
    """Dissipation control until the joint is broken and the end has moved as far as ever before."""
    newton, pattern = model
    control = DissipationControl(newton, pattern, energy, move=0.5 * S_0)
    u, rows = np.zeros(newton.stiffness.shape[0]), [(0.0, 0.0)]
    while newton.joint.state[:, 0].min() < 1.0 or control.factor < max(moved for moved, _ in rows):
        u = control.step(u)
        rows.append((control.factor, control.force))
    return _curve(rows, newton)


def _curve(rows: list[tuple[float, float]], newton: Newton) -> Curve:
    state = newton.joint.state
    moved, force = np.array(rows).T
    rupture = float(newton.joint.weights @ state[:, contract.statev_index("rupture")])
    return Curve(moved, force, newton.iterations, float(state[:, 0].min()), rupture)


def closed_form(opening: Floats, length: float) -> tuple[Floats, Floats]:
    """Displacement of the end of a bar and force, over its opening: bond in straight lines, and stretch."""
    traction = BOND.sigma0 * np.clip(np.minimum(opening / S_0, (S_F - opening) / (S_F - S_0)), 0.0, None)
    return opening + traction * length / MODULUS, traction


def work(curve: Curve) -> float:
    """Work of the pulled end, per width."""
    return float(np.trapezoid(curve.force, curve.moved))


def draw(path: Path) -> None:
    """Draw force over displacement of three bars, and print the numbers."""
    opening = np.concatenate([np.linspace(0, S_0, 20), np.linspace(S_0, 1.2 * S_F, 60)])
    print("length / limit  steps  largest move [mm]  rupture [N]  work [N]  prescribed displacements")
    with printed():
        figure, (ax,) = new_figure(TWO, 2.9)
        for share, colour in zip((0.5, 1.5, 2.2), COLOURS, strict=False):
            length = share * LIMIT
            ax.plot(*closed_form(opening, length), "-", color=colour, label=f"{share:g} of the limit")
            curve = by_dissipation(bar(length), BOND.Gc / 30)
            ax.plot(curve.moved, curve.force, "o", color=colour, markersize=2.5)
            prescribed = by_displacement(bar(length), 1.2 * float(curve.moved.max()), 200)
            if prescribed.broken < 1.0:
                ax.plot(prescribed.moved[-1:], prescribed.force[-1:], "x", color=colour, markersize=8)
            end = "passes" if prescribed.broken == 1.0 else f"stops at {prescribed.moved[-1]:.4f} mm"
            numbers = f"{curve.moved.max():19.5f}{curve.rupture:13.5f}{work(curve):10.5f}"
            print(f"{share:14g}{len(curve.moved) - 1:7}{numbers}  {end}")
        ax.plot([], [], "o", color="black", markersize=2.5, label="dissipation control")
        ax.plot([], [], "x", color="black", label="prescribed: no convergence beyond")
        ax.set(xlabel="displacement of the end [mm]", ylabel="force per width [N/mm]")
        ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0))
        ax.grid(alpha=0.3)
        save(figure, path)


def main() -> None:
    """Run, print and draw."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add_options(parser, ("-o --output FILE", "picture", Path("snap_back.png")))
    output = parser.parse_args().output
    draw(output)
    print(output)


if __name__ == "__main__":
    main()
