"""Concrete dam on the joint along its base, with the water in the joint and its steady flow; m, N.

The section is that of dam_section.py.  `profile` prints what the joint does at a level, `overload` the level
at which the dam fails, and whether that is a limit or the end of what was found, with the exit status 3.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
from asperity.contract import Floats
from asperity.fenicsx import COMM, Conditions, Flow, Follow, Model, Output, State, Stopped, Terms, solve
from asperity.fenicsx.path import LIMIT_LOAD
from asperity.interface import Interface
from asperity.material import Material
from asperity.options import add_options
from asperity.pattern import Pattern

from harness.hosts.dam_section import (
    A_0,
    BASE,
    PARAPET,
    STIFFNESS,
    UPLIFTS,
    VISCOSITY,
    WATER,
    WEIGHT,
    section,
)

STOPPED = 3
"""Exit status of an overload that ends before a limit load is found."""

BOND = {"sigma0": 1e5, "Gc": 20.0, "eta": 1.0 - 1e5**2 / (2.0 * STIFFNESS * 20.0), "kc": 1.0}
"""Of a joint with a bond: 0.1 MPa, 20 N/m, the same stiffness."""

OPEN = {"kn": STIFFNESS, "ks": STIFFNESS}
JOINTS = {
    "held": (Material.from_joint(**OPEN, mu=1000.0), 0.0),
    "plain": (Material.from_joint(**OPEN, mu=0.75), 0.0),
    "rough": (Material.from_joint(**OPEN, mu=0.75, height=5e-3), 15.0),
    "bonded": (Material(**BOND, mu=0.75), 0.0),
    "rough bonded": (Material(**BOND, mu=0.75, height=5e-3), 15.0),
}
"""Material, and slope of two planes in degrees: held does not slide, rough has asperities of 5 mm."""


TERMS = Terms(tolerance=1e-8)


class Dam:
    """A dam, in whose joint the water has one of the UPLIFTS."""

    def __init__(self, uplift: str, law: Interface, parts: int, E: float, nu: float) -> None:
        """Mesh it, and fix the sides and the bottom of the foundation."""
        self.uplift, mesh = uplift, section(parts) if COMM.rank == 0 else None
        self.model = m = Model(mesh, {"base": law}, E, nu, plane="strain")
        self.weight = m.body([0.0, -WEIGHT], "dam")
        self.outside, self.state, self.terms = m.dofs(m.group("outside")[0], 0, 1), State.virgin(m), TERMS

    def filled(self, level: float) -> Conditions:
        """Foundation, weight and water at a level."""
        upstream = {"upstream": lambda x: WATER * np.maximum(level - x[:, 1], 0.0)}
        linear = {"base": lambda x: WATER * level * (1.0 - x[:, 0] / BASE)}
        ends = {"upstream": lambda x: WATER * level + 0.0 * x[:, 0], "downstream": 0.0}
        flows = [Flow("base", ends, VISCOSITY, A_0, A_0)] if self.uplift == "flow" else []
        pressures = upstream | (linear if self.uplift == "linear" else {})
        return Conditions(self.outside, load=self.weight, pressures=pressures, flows=flows)

    def fill(self, level: float) -> None:
        """Find the equilibrium at a level; RuntimeError where there is none."""
        report = solve(self.model, self.state, self.filled(level), replace(self.terms, at=level))
        if report.state is None:
            raise RuntimeError(f"level {level:g} m: {report.reason}")
        self.state = report.state

    def overload(self, least: float, step: float = 1.0) -> tuple[float, str]:
        """Highest level with an equilibrium, and the kind of the end; the state is that before cracks run.

        A level whose end is not `limit` is a lower bound.
        """
        self.fill(0.0)
        follow = Follow(self.model, self.state, self.filled, step, step, least, self.terms)
        try:
            for _ in follow.to(PARAPET):
                self.state = self.state if follow.branch else follow.state
        except Stopped:
            return follow.at, follow.kind
        raise RuntimeError(f"level {PARAPET:g} m: expected a limit below the crest of the parapet")

    def profile(self) -> Floats:
        """Rows x, s_N, total t_N, p and slip of the joint, by x, on all ranks."""
        m = self.model
        s, t = self.state.s, self.state.t
        parts = np.column_stack([m.places[:, 0], s[:, 0], t[:, 0], self.state.p, s[:, 1]])
        rows = np.concatenate(COMM.allgather(parts))
        return rows[np.unique(rows[:, 0].round(9), return_index=True)[1]]


def main() -> int:
    """Run the program; the exit status is 3 where the end of an overload is no limit."""
    warnings.simplefilter("ignore")
    parser = argparse.ArgumentParser(description=__doc__)
    add_options(
        parser,
        ("kind", "profile or overload", str, {"choices": ("profile", "overload")}),
        ("uplift", f"one of {', '.join(UPLIFTS)}", str, {"choices": UPLIFTS}),
        ("--level M", "of a profile", 9.0),
        ("--joint NAME", f"one of {', '.join(JOINTS)}", "held", {"choices": tuple(JOINTS)}),
        ("--E PA", "of dam and foundation", 3e12),
        ("--nu NU", "of both", 0.0),
        ("--parts N", "elements along the base", 50),
        ("--least M", "least step of the level", 1e-3),
        ("--out FILE", "rows x, s_N, t_N, p, slip", Path),
        ("--pvd FILE", "fields for ParaView", Path),
    )
    o = parser.parse_args()
    material, slope = JOINTS[o.joint]
    law = Interface(material, Pattern.regular(2 if slope else 0, slope))
    dam, status = Dam(o.uplift, law, o.parts, o.E, o.nu), 0
    if o.kind == "profile":
        dam.fill(0.0)
        dam.fill(o.level)
        found = f"level {o.level:.6g}"
    else:
        level, kind = dam.overload(o.least)
        found, status = f"level {level:.6g} {kind}", 0 if kind == LIMIT_LOAD else STOPPED
    if o.pvd:
        Output(dam.model, o.pvd).write(dam.state, flows=dam.filled(dam.state.at).flows)
    rows = dam.profile()
    if COMM.rank == 0:
        print(found)
        if o.out:
            np.savetxt(o.out, rows, "%.9g", ",", header="x,s_N,t_N,p,slip", comments="")
    return status


if __name__ == "__main__":
    sys.exit(main())
