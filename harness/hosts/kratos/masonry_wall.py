"""A wall of ../masonry.py in Kratos by plain Newton, with IMPL-EX in the UMAT or without; mm, N, MPa.

The wall is pressed by forces in four steps; then its top is moved sideways at constant height.  The last line
printed is a summary in JSON.  The exit status is 3 where the run stops before its end.
"""

from __future__ import annotations

import argparse
import json
import sys
import warnings
from pathlib import Path

import numpy as np
from asperity.options import add_options
from asperity.pattern import Pattern
from kratos_model import Floats, Lost, Structure

sys.path.insert(0, str(Path(__file__).parents[3]))
from harness.hosts.masonry import LEAST, WALLS, check_options, laws, mesh, sized

TOLERANCE = 1e-4
"""Residual force, N, for a thickness of 1."""

STOPPED, LEAST_IMPLEX = 3, 1e-4
"""Exit status of a run that stops; least step with IMPL-EX, mm, which is taken with any error."""

FAST, GROWTH = 12, 1.5
"""A step grows after fewer iterations, or where its errors are small, by this factor at most."""


class Run:
    """A wall under its pressure, which is then moved."""

    def __init__(self, o: argparse.Namespace) -> None:
        """Build the wall and press it."""
        wall = sized(WALLS[o.wall], *o.size, bare=True)
        pattern = Pattern.regular(4, o.theta) if o.theta else Pattern.regular(0, 0.0)
        joint_laws = laws(wall, pattern, o.height, o.tau, {})
        wall_mesh = mesh(wall, o.elements)
        self.o, self.thickness = o, wall.half_brick[1]
        self.s = s = Structure(2)
        solid = s.elastic(wall.E, wall.nu, "LinearElasticPlaneStress2DLaw")
        s.add_mesh(wall_mesh, solid, {name: s.umat(law, o.implex) for name, law in joint_laws.items()})
        self.top, self.bottom = (wall_mesh.nodes(name) + 1 for name in ("top", "bottom"))
        x = wall_mesh.points[self.top - 1, 0]
        _, place, count = np.unique(np.round(x, 6), return_inverse=True, return_counts=True)
        half = (count[place] > 1) | np.isin(place, (0, place.max()))
        force = -wall.pressure * wall.half_brick[0] / o.elements[0] * np.where(half, 0.5, 1.0)
        s.fix(self.bottom, 0, 1)
        s.fix(self.top, 0)
        s.load({node: (0.0, 0.0, 0.0) for node in self.top.tolist()})
        self.iterations = 0
        for part in (0.25, 0.5, 0.75, 1.0):
            for node, of_node in zip(self.top.tolist(), force.tolist(), strict=True):
                s.set_load(node, (0.0, part * of_node, 0.0))
            self.iterations += len(s.step(TOLERANCE, time=o.step))
        s.fix(self.top, 1)

    def follow(self) -> tuple[Floats, dict[str, object]]:
        """Rows of displacement in mm, horizontal and vertical force in kN, e_a and e_t; summary."""
        o, at, step, again, rows = self.o, 0.0, self.o.step, False, []
        cuts = repeated = 0
        while o.to - at > 1e-9:
            move = min(step, o.to - at)
            self.s.move(self.top, 0, at + move)
            try:
                norms = self.s.step(TOLERANCE, again, move)
            except Lost as lost:
                self.iterations += len(lost.norms)
                cuts, step, again = cuts + 1, 0.5 * move, True
                if step < LEAST:
                    break
                continue
            except RuntimeError as error:
                if "SINGULAR" not in str(error):
                    raise
                break  # open joints without stiffness: Kratos cannot go on
            self.iterations += len(norms)
            damage, traction = self.s.implex_errors() if o.implex else (0.0, 0.0)
            excess = max(damage, 2.0 * traction) / o.implex if o.implex else 0.0
            if excess > 1.0 and move > 1.001 * LEAST_IMPLEX:
                repeated, again = repeated + 1, True
                step = max(LEAST_IMPLEX, move * min(0.7, max(0.25, 0.8 / excess)))
                continue
            at, again = at + move, False
            forces = self.thickness / 1e3 * self.s.reaction(self.bottom) * [-1.0, 1.0]
            rows.append((at, *forces, damage, traction))
            if excess < 0.7 if o.implex else len(norms) < FAST:
                step = min(o.most, GROWTH * step)
        table = np.array(rows).reshape(-1, 5)
        peak = int(table[:, 1].argmax()) if rows else 0
        return table, {
            "steps": len(rows), "cuts": cuts, "repeated": repeated, "iterations": self.iterations,
            "peak": table[peak, 1] if rows else 0.0, "at": table[peak, 0] if rows else 0.0,
            "work": float(np.trapezoid(np.r_[0.0, table[:, 1]], np.r_[0.0, table[:, 0]])),
            "H": table[-1, 1] if rows else 0.0, "V": table[-1, 2] if rows else 0.0,
            "e_a": table[:, 3].max(initial=0.0), "e_t": table[:, 4].max(initial=0.0), "end": at,
        }  # fmt: skip


def options() -> argparse.Namespace:
    """Options of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, allow_abbrev=False)
    add_options(
        parser,
        ("--wall", "one of the tested walls, without beams and weight", "J4D", {"choices": tuple(WALLS)}),
        ("--size N", "half-bricks and courses (0: as tested)", int, {"nargs": 2, "default": [5, 6]}),
        ("--elements N", "of a half-brick: length and height", int, {"nargs": 2, "default": [2, 2]}),
        ("--theta DEGREES", "of the pattern RP-4 of the joints; 0: flat", 0.0),
        ("--height MM", "of the asperities; 0: infinite", 0.0),
        ("--tau MM", "tau_v, in mm of the top", 0.0),
        ("--implex E", "error of damage that IMPL-EX allows, and half of it of a traction; 0: implicit", 0.0),
        ("--to MM", "displacement", 4.0),
        ("--step MM", "first step", 0.02),
        ("--most MM", "largest step", 0.05),
        ("--out FILE.csv", "rows", Path),
    )
    o = parser.parse_args()
    check_options(
        parser,
        o,
        (2,),
        ("implex", 0.0 <= o.implex < 1.0, "at least 0 and below 1"),
        ("to", 0.0 < o.to < np.inf, "finite, above 0"),
        (
            "out",
            not o.out or (o.out.parent.is_dir() and not o.out.exists()),
            "a new file in a folder that exists",
        ),
    )
    return o


def main() -> int:
    """Run the program."""
    warnings.simplefilter("ignore")
    o = options()
    try:
        run = Run(o)
    except (ValueError, Lost) as error:
        print(f"masonry_wall.py: {error}", file=sys.stderr)
        return 2
    rows, summary = run.follow()
    if o.out:
        head = "displacement [mm],horizontal [kN],vertical [kN],e_a [-],e_t [-]"
        np.savetxt(o.out, rows, "%.12g", ",", header=head, comments="")
    print(json.dumps(summary))
    return 0 if summary["end"] == o.to or o.to - float(str(summary["end"])) < 1e-9 else STOPPED


if __name__ == "__main__":
    sys.exit(main())
