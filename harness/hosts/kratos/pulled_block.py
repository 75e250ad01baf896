"""The block of ../python/pull_out.py in Kratos, compared with the same model in scikit-fem.

Both models have linear elements, the interface points at the nodes of the base, and the same mesh, material
and steps.  As a script this module prints and draws every row of the first mesh, and prints one line for each
mesh.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from asperity.style import TWO, new_figure, printed, save
from kratos_model import Floats, Structure
from matplotlib.figure import Figure

sys.path.insert(0, str(Path(__file__).parent.parent))
sys.path.insert(0, str(Path(__file__).parent.parent / "python"))
import joint
import pull_out
import structure_picture

TOLERANCE = 1.0e-10
"""Residual force, N; the reactions are of 100 N."""

FORCE_BOUND, SEPARATION_BOUND = 1.0e-9, 1.0e-10
"""Most that the codes may differ by: force over its peak, separations in mm.

What scikit-fem may leave out of balance, 1e-10 of some 100 N at a node, is 1e-11 of the peak.  Over the
stiffness at a node, K = 1500 MPa/mm times an element of some 10 mm, it is 1e-12 mm.  Softening makes both
larger: a factor of 100 is left for it.
"""


@dataclass(frozen=True)
class Result:
    """Force, rise and separations (rows, points, 3) with one row for each slip; norms of the iterations."""

    force: Floats
    rise: Floats
    separation: Floats
    norms: list[list[float]]


@dataclass(frozen=True)
class Comparison:
    """Results of both codes and their differences in every row.

    The difference of the forces is relative to the peak; those of separations and rises are in mm.
    """

    kratos: Result
    python: pull_out.Curve
    force: Floats
    separation: Floats
    rise: Floats

    @property
    def iterations(self) -> int:
        """Number of Newton iterations in Kratos."""
        return sum(map(len, self.kratos.norms))


def run(slips: Floats, n: int, **umat: object) -> Result:
    """Apply the pressure as in `pull_out.run`, then move the right face to each slip; n elements along x."""
    s = Structure(2)
    solid, rough = s.elastic(pull_out.MODULUS, pull_out.POISSON), s.umat(pull_out.INTERFACE, **umat)
    x, y = pull_out.axes(n)
    block = s.add_nodes(np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1))
    base = s.add_nodes(np.column_stack([x, np.zeros_like(x)]))
    for i in range(len(x) - 1):
        for j in range(len(y) - 1):
            s.add_solid([block[i, j], block[i + 1, j], block[i + 1, j + 1], block[i, j + 1]], solid)
        s.add_interface(base[i : i + 2], block[i : i + 2, 0], rough)
    top, right = block[:, -1], block[-1]
    s.fix(base, 0, 1)
    s.fix(right, 0)
    s.load({node: (0.0, 0.0, 0.0) for node in top})
    area = np.full(n + 1, pull_out.LENGTH / n)
    area[[0, -1]] *= 0.5

    rows, norms = [], []
    shares = [(k + 1) / pull_out.PRESS_STEPS for k in range(pull_out.PRESS_STEPS - 1)]
    for share, slip in [*((share, 0.0) for share in shares), *((1.0, slip) for slip in slips)]:
        for node, part in zip(top, area, strict=True):
            s.set_load(node, (0.0, -pull_out.PRESSURE * share * part, 0.0))
        s.move(right, 0, slip)
        norms.append(s.step(TOLERANCE))
        rows.append((s.reaction(right)[0], s.displacements()[top[n // 2] - 1, 1], s.points()[0]))
        joint.progress(f"Kratos: slip {slip:.3f} mm, step {len(norms)}, {len(norms[-1])} iterations")
    joint.progress("")
    force, rise, separation = (np.array(column[len(shares) :]) for column in zip(*rows, strict=True))
    return Result(force, rise - rise[0], separation, norms)


def compare(slip: float, steps: int, n: int, back: float | None = None, **umat: object) -> Comparison:
    """Run both codes with the steps of the scikit-fem run; the arguments are those of `pull_out.run`."""
    python = pull_out.run(slip, steps, n, nodal=True, back=back)
    kratos = run(python.slip, n, **umat)
    force = np.abs(kratos.force - python.force) / np.abs(python.force).max()
    separation = np.abs(kratos.separation - python.separation).max(axis=(1, 2))
    return Comparison(kratos, python, force, separation, np.abs(kratos.rise - python.rise))


def travelled(slip: Floats) -> Floats:
    """Return the accumulated slip of the pulled face in each row, mm; the slip itself may be reversed."""
    return np.append(0.0, np.abs(np.diff(slip)).cumsum())


def draw(both: Comparison, fine: pull_out.Curve, path: Path) -> None:
    """Draw the force over the slip in both codes, and their differences over the accumulated slip."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with printed():
        save(_figure(both, fine), path)


def _figure(both: Comparison, fine: pull_out.Curve) -> Figure:
    (blue, *_), (red, *_), (black, *_) = structure_picture.STYLES
    slip, way = both.python.slip, travelled(both.python.slip)
    figure, (force, apart) = new_figure(TWO, 3.0, ncols=2)
    force.plot(slip, both.kratos.force, color=blue, linewidth=3.0, alpha=0.5, label="Kratos")
    force.plot(slip, both.python.force, "--", color=red, label="scikit-fem, same mesh and points")
    force.plot(fine.slip, fine.force, ":", color=black, label="scikit-fem, quadratic, Gauss points")
    force.set(xlabel="displacement of the pulled face [mm]", ylabel="force per width [N/mm]")
    force.legend()
    apart.semilogy(
        way, both.force, "o-", color=blue, markersize=2.5, label="force difference over the peak [-]"
    )
    apart.semilogy(
        way, both.separation, "s--", color=red, markersize=2.5, label="largest separation difference [mm]"
    )
    apart.axhline(FORCE_BOUND, color=blue, linestyle=":", label="tolerance of the test, force")
    apart.axhline(SEPARATION_BOUND, color=red, linestyle="-.", label="tolerance of the test, separation")
    apart.set(
        xlabel="accumulated slip of the pulled face [mm]", ylabel="difference between Kratos and scikit-fem"
    )
    apart.set(ylim=(1e-18, 1e-4))
    apart.legend(loc="upper right")
    for ax in (force, apart):
        ax.grid(alpha=0.3)
    return figure


def main() -> None:
    """Run both codes, print and draw the results."""
    parser = argparse.ArgumentParser(description="Pulled block in Kratos against scikit-fem.")
    parser.add_argument("--slip", type=float, default=0.6, help="mm, > 0 (default: %(default)s)")
    parser.add_argument("--back", type=float, default=0.0, help="then back to, mm (default: %(default)s)")
    parser.add_argument("--steps", type=int, default=30, help="each way (default: %(default)s)")
    parser.add_argument("--elements", type=int, nargs="+", default=[20], help="along the base, a mesh each")
    parser.add_argument("-o", "--output", type=Path, default=Path("pulled_block.png"), metavar="FILE.png")
    options = parser.parse_args()
    pull_out.check(parser, options)
    lines = []
    for n in options.elements:
        both = compare(options.slip, options.steps, n, options.back)
        fine = pull_out.run(options.slip, options.steps, n, back=options.back)
        # The steps of either run may have been subdivided, so that the rows differ.
        other = np.interp(travelled(both.python.slip), travelled(fine.slip), fine.force)
        other = np.abs(both.kratos.force - other).max() / np.abs(fine.force).max()
        lines.append(
            f"| {n} | {both.force.max():.1e} | {both.separation.max():.1e} | {both.rise.max():.1e} "
            f"| {both.iterations}, {both.python.iterations} | {other:.1e} |"
        )
        if len(lines) > 1:
            continue
        print("moved [mm]   force [N/mm]: Kratos  scikit-fem   over the peak   separations [mm]")
        columns = (both.python.slip, both.kratos.force, both.python.force, both.force, both.separation)
        for row in zip(*columns, strict=True):
            print("{:10.3f}{:23.6f}{:12.6f}{:16.1e}{:19.1e}".format(*row))
        pulled = both.kratos.force[both.python.slip.argmax()]
        print(f"force when pulled {pulled:.6f}, residual strength {pull_out.residual_strength():.6f}")
        print(f"force at the end {both.kratos.force[-1]:.6f}; {both.python.cuts} cuts")
        draw(both, fine, options.output)
    print("| elements | force, of the peak | separations, mm | rise, mm | iterations: Kratos, scikit-fem "
          "| force from quadratic elements and Gauss points |")  # fmt: skip
    print("|---|---|---|---|---|---|", *lines, options.output, sep="\n")


if __name__ == "__main__":
    main()
