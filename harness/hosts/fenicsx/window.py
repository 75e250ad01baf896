"""A wall of any mesh, such as that of window_mesh.py, pressed by its top and moved sideways, mm, N, MPa."""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Callable
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
    from jointed import COMM, Follow, Model, Output, Steps, total

    mesh = split(path) if COMM.rank == 0 else None
    model = Model(mesh, {"joint": law}, E, NU, THICKNESS)
    top, bottom = model.group("top")[0], model.group("bottom")[0]
    steps = Steps(model, model.dofs(np.r_[top, bottom], 0, 1), options=options)
    along, down = (np.isin(steps.fixed, model.dofs(top, k)) * 1.0 for k in (0, 1))
    press = Follow(steps, lambda t: (-t * PRESS * down, 0.0 * model.u), 1.0, 1.0)
    while press.at < 1.0 and not press.reason:
        press.advance(1.0)
    if press.reason:
        raise RuntimeError(f"the pressure: {press.reason}")
    follow = Follow(steps, lambda t: (t * along - PRESS * down, 0.0 * model.u), most, most)
    rows, error = [], 0.0
    while follow.at < to and not follow.reason:
        if follow.advance(to):
            error = max(error, steps.errors[1])
            F = steps.reaction.reshape(-1, 2)[bottom]
            rows.append([follow.at, -total(F[:, 0].sum()) / 1e3, total(F[:, 1].sum()) / 1e3])
    if pvd:
        Output(model, pvd).write(follow.at)
    if follow.reason:
        raise RuntimeError(follow.reason)
    if error and COMM.rank == 0:
        print(f"steps by passes leave errors up to {error:.2g} of the forces")
    return np.array(rows) if COMM.rank == 0 else np.zeros((0, 3))


def main(solve: Callable[..., np.ndarray] = run) -> None:
    """Run the program with a `run` of this host or another one."""
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
    rows = solve(o.mesh, law, o.to, o.most, o.petsc, o.pvd)
    if len(rows):
        if o.out:
            np.savetxt(o.out, rows, "%.12g", ",", header="mm,horizontal [kN],vertical [kN]", comments="")
        peak = rows[rows[:, 1].argmax()]
        print(f"peak {peak[1]:.3f} kN at {peak[0]:.3f} mm, {len(rows)} steps")


if __name__ == "__main__":
    main()
