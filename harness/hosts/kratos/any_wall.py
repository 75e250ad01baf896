"""The wall of ../fenicsx/window.py in Kratos: the same mesh by way of a .mdpa file, joints and loads."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
from asperity.mesh import split
from asperity.options import add_options
from kratos_model import Floats, Lost, Structure

sys.path.insert(0, str(Path(__file__).parent.parent / "fenicsx"))
from window import MORTAR, NU, PRESS, THICKNESS, E

TOLERANCE = 1e-4
"""Residual force, N, for a thickness of 1."""


def run(path: Path, to: float, most: float) -> Floats:
    """Rows of displacement in mm, horizontal and vertical force in kN."""
    s, mesh = Structure(2), split(path)
    s.add_mesh(mesh, s.elastic(E, NU, "LinearElasticPlaneStress2DLaw"), s.umat(MORTAR))
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
    parser = argparse.ArgumentParser(description=__doc__)
    add_options(
        parser,
        ("mesh MESH", "that of window.py", Path),
        ("--to MM", "displacement of the top", 1.0),
        ("--most MM", "largest step", 0.05),
        ("--out FILE.csv", "rows", Path, {"required": True}),
    )
    o = parser.parse_args()
    found = run(o.mesh, o.to, o.most)
    np.savetxt(o.out, found, "%.12g", ",", header="mm,horizontal [kN],vertical [kN]", comments="")
