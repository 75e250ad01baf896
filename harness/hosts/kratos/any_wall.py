"""The wall of ../fenicsx/window.py in Kratos: the same mesh by way of a .mdpa file, joints and loads."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from asperity.interface import Interface
from asperity.mesh import split
from kratos_model import Floats, Lost, Structure

sys.path.insert(0, str(Path(__file__).parent.parent / "fenicsx"))
from window import NU, PRESS, THICKNESS, E, main

TOLERANCE = 1e-4
"""Residual force, N, for a thickness of 1."""


def run(path: Path, law: Interface, to: float, most: float, *_: object) -> Floats:
    """Rows of displacement in mm, horizontal and vertical force in kN; --petsc, --pvd have no effect."""
    s, mesh = Structure(2), split(path)
    s.add_mesh(mesh, s.elastic(E, NU, "LinearElasticPlaneStress2DLaw"), s.umat(law))
    top, bottom = (mesh.nodes(name) + 1 for name in ("top", "bottom"))
    s.fix(np.r_[top, bottom], 0, 1)
    s.move(top, 1, -PRESS)
    s.step(TOLERANCE)
    at, step, again, rows = 0.0, most, False, []
    while to - at > 1e-9:
        move = min(step, to - at)
        s.move(top, 0, at + move)
        try:
            s.step(TOLERANCE, again, move)
        except Lost:
            step, again = move / 2.0, True
            if step < 1e-4:
                sys.exit(f"stopped at {at:g} mm")
            continue
        at, again = at + move, False
        rows.append((at, *(THICKNESS / 1e3 * s.reaction(bottom) * [-1.0, 1.0])))
    return np.array(rows)


if __name__ == "__main__":
    main(run)
