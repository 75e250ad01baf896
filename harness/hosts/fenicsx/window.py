"""A wall of any mesh, such as that of window_mesh.py, pressed by its top and moved sideways, mm, N, MPa."""

from __future__ import annotations

import argparse
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
from asperity.case_files import read_run
from asperity.interface import Interface
from asperity.material import Material
from asperity.mesh import split
from asperity.options import add_options
from asperity.pattern import Pattern

E, NU, THICKNESS = 5000.0, 0.15, 100.0
MORTAR = Interface(
    replace(Material.from_masonry(82.0, 36.0, 0.25, 0.018, 0.35, 0.125, 0.75), kc=1.0, tau_v=0.002),
    Pattern.regular(4, 10.0),
)
PRESS = 0.05
"""Displacement of the top downwards, mm, before it is moved sideways."""


def run(
    path: Path, law: Interface, to: float, most: float, options: str = "", pvd: Path | None = None
) -> np.ndarray:
    """Rows of displacement in mm, horizontal and vertical force in kN."""
    from asperity.fenicsx import COMM, Conditions, Follow, Model, Output, State, Terms, total

    mesh = split(path) if COMM.rank == 0 else None
    model = Model(mesh, {"joint": law}, E, NU, THICKNESS)
    top, bottom = model.group("top")[0], model.group("bottom")[0]
    fixed, terms = model.dofs(np.r_[top, bottom], 0, 1), Terms(options=options)
    along, down = (np.isin(fixed, model.dofs(top, k)) * 1.0 for k in (0, 1))
    press = Follow(
        model, State.virgin(model), lambda t: Conditions(fixed, -t * PRESS * down), 1.0, terms=terms
    )
    pressed = press.run(1.0)
    follow = Follow(model, pressed, lambda t: Conditions(fixed, t * along - PRESS * down), most, terms=terms)
    rows, error = [], 0.0
    for report in follow.to(to):
        error = max(error, report.errors[1])
        F = report.reaction.reshape(-1, 2)[bottom]
        rows.append([follow.at, -total(F[:, 0].sum()) / 1e3, total(F[:, 1].sum()) / 1e3])
    if pvd:
        Output(model, pvd).write(follow.state)
    if error and COMM.rank == 0:
        print(f"steps by passes leave errors up to {error:.2g} of the forces")
    return np.array(rows) if COMM.rank == 0 else np.zeros((0, 3))


def main() -> None:
    """Run the program."""
    warnings.simplefilter("ignore")
    parser = argparse.ArgumentParser(description=__doc__)
    add_options(
        parser,
        ("mesh MESH", "with the groups top and bottom, one group for each block", Path),
        ("--law CASE.nml", "constants of the joints (default: a mortar)", Path),
        ("--to MM", "displacement of the top", 1.0),
        ("--most MM", "largest step", 0.05),
        ("--petsc OPTIONS", "of PETSc, in one word", str, {"default": ""}),
        ("--out FILE.csv", "displacement, horizontal and vertical force", Path),
        ("--pvd FILE.pvd", "fields at the end for ParaView", Path),
    )
    o = parser.parse_args()
    law = MORTAR if o.law is None else read_run(o.law).interface
    rows = run(o.mesh, law, o.to, o.most, o.petsc, o.pvd)
    if len(rows):
        if o.out:
            np.savetxt(o.out, rows, "%.12g", ",", header="mm,horizontal [kN],vertical [kN]", comments="")
        peak = rows[rows[:, 1].argmax()]
        print(f"peak {peak[1]:.3f} kN at {peak[0]:.3f} mm, {len(rows)} steps")


if __name__ == "__main__":
    main()
