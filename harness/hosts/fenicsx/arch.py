"""Semicircular dry arch on FEniCSx: its weight, then a growing horizontal acceleration until it falls; mm, N.

`collapse` computes it, `limit` is the largest acceleration of rigid voussoirs by limit analysis.
"""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path

import gmsh
import numpy as np
from asperity.fenicsx import COMM, Conditions, Model, Output, State, Terms, largest, solve, total
from asperity.interface import Interface
from asperity.material import Material
from asperity.mesh import split
from asperity.options import add_options
from asperity.pattern import Pattern
from scipy.optimize import linprog

R, VOUSSOIRS, DEPTH, WEIGHT, E, NU = 1000.0, 15, 300.0, 2.4e-5, 2.0e4, 0.2
DEEP = 0.0, 0.0, 1.0
"""Tx of the joints of an arch in space."""

LEAST = 1e-4
"""Least step of the acceleration, in g."""

FALLS = 20.0
"""Displacement, mm, beyond which an arch falls; at rest it moves by some 0.1 mm."""


def mesh(path: Path, ratio: float, dim: int, size: float) -> None:
    """Mesh an arch of the thickness ratio R on two foundations: triangles or tetrahedra."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    g, t = gmsh.model.geo, ratio * R
    angle, centre = np.linspace(0.0, np.pi, VOUSSOIRS + 1), g.addPoint(0.0, 0.0, 0.0)
    ends = [
        [g.addPoint(r * np.cos(a), r * np.sin(a), 0.0, size) for r in (R - t / 2, R + t / 2)] for a in angle
    ]
    radial = [g.addLine(*pair) for pair in ends]
    faces = []
    for i in range(VOUSSOIRS):
        inner, outer = (g.addCircleArc(ends[i][k], centre, ends[i + 1][k]) for k in (0, 1))
        faces.append(g.addPlaneSurface([g.addCurveLoop([radial[i], outer, -radial[i + 1], -inner])]))
    for i in (0, VOUSSOIRS):
        x = np.array([R - t, R + t]) * np.cos(angle[i])
        places = (0, -0.3 * t), (1, -0.3 * t), (1, 0.0), (0, 0.0)
        a, b, c, d = (g.addPoint(x[k], y, 0.0, size) for k, y in places)
        lines = [g.addLine(*pair) for pair in ((a, b), (b, c), (c, ends[i][1]), (ends[i][0], d), (d, a))]
        faces.append(g.addPlaneSurface([g.addCurveLoop([*lines[:3], -radial[i], *lines[3:]])]))
    solids = [(2, face) for face in faces]
    if dim == 3:
        solids = [(3, g.extrude([(2, face)], 0.0, 0.0, DEPTH)[1][1]) for face in faces]
        g.removeAllDuplicates()
    g.synchronize()
    for k, (_, solid) in enumerate(solids):
        gmsh.model.addPhysicalGroup(dim, [solid], name=f"voussoir_{k}")
    gmsh.model.mesh.generate(dim)
    gmsh.write(str(path))
    gmsh.finalize()


def collapse(
    path: Path, ratio: float, dim: int, mu: float, tan_psi: float = 0.0, pvd: Path | None = None
) -> tuple[float, int]:
    """Largest horizontal acceleration in g of a meshed arch, and the number of its unknowns."""
    jointed = split(path, direction=DEEP if dim == 3 else None) if COMM.rank == 0 else None
    pattern = (
        Pattern.regular(2, float(np.degrees(np.arctan(tan_psi)))) if tan_psi else Pattern.regular(0, 0.0)
    )
    law = Interface(Material.from_joint(kn=200.0, ks=80.0, mu=mu), pattern)
    model = Model(jointed, {"joint": law}, E, NU, DEPTH if dim == 2 else 1.0)
    down, side = (model.body((np.eye(dim)[k] * WEIGHT * sign).tolist()) for k, sign in ((1, -1.0), (0, 1.0)))
    base = model.x[:, 1] < -0.3 * ratio * R + 1e-6
    fixed, drag = model.dofs(base, *range(dim)), np.abs(down + side)
    at, step = 0.0, 0.02
    state, rests = settled(model, State.virgin(model), Conditions(fixed, load=down), drag)
    if not rests:
        raise ValueError(f"t/R = {ratio:g}: the arch falls under its weight")
    output = Output(model, pvd) if pvd else None
    while step > LEAST:
        new, rests = settled(model, state, Conditions(fixed, load=down + (at + step) * side), drag)
        if rests:
            at, state = at + step, new
        else:
            if output and step <= 2.0 * LEAST:
                output.write(new, at)  # as it falls
            step /= 2.0
    return at, model.K.getSize()[0]


def settled(model: Model, state: State, conditions: Conditions, drag: np.ndarray) -> tuple[State, bool]:
    """Return the last state of an arch under conditions, and whether it comes to rest.

    It moves against a drag, its weight for a speed of 1 mm, in times that grow until the drag is gone.
    """
    time = 1.0
    while 1e-6 < time < 1e6:
        report = solve(model, state, conditions, Terms(dt=time, drag=drag, iterations=30))
        if report.state is not None:
            braked = total((drag * np.abs(report.state.u - state.u)).sum()) / time
            state = report.state
            if braked <= 1e-5 * report.size:
                return state, True
        if largest(state.u) > FALLS:
            return state, False
        time *= 4.0 if report.state else 0.25
    return state, False


def limit(ratio: float, mu: float) -> float:
    """Largest horizontal acceleration in g of rigid voussoirs with joints that carry no tension (linprog).

    Unknown are the pressures at both ends and the shear force of every joint, and the acceleration.
    """
    angle, inner, outer = np.linspace(0.0, np.pi, VOUSSOIRS + 1), 1.0 - ratio / 2, 1.0 + ratio / 2
    step, n = np.pi / VOUSSOIRS, 3 * (VOUSSOIRS + 1)
    area = 0.5 * (outer**2 - inner**2) * step
    middle = 2 / 3 * (outer**3 - inner**3) / (outer**2 - inner**2) * np.sin(step / 2) / (step / 2)
    A, b = np.zeros((3 * VOUSSOIRS, n + 1)), np.zeros(3 * VOUSSOIRS)
    for i in range(VOUSSOIRS):
        a = (angle[i] + angle[i + 1]) / 2
        for j, sign in ((i, 1.0), (i + 1, -1.0)):
            along, across = np.array([[c := np.cos(angle[j]), s := np.sin(angle[j])], [-s, c]])
            for k, (radius, force) in enumerate(((inner, across), (outer, across), (1.0, along))):
                x, y = radius * along - middle * np.array([np.cos(a), np.sin(a)])
                A[3 * i : 3 * i + 3, 3 * j + k] = sign * np.array([*force, x * force[1] - y * force[0]])
        A[3 * i, -1], b[3 * i + 1] = area, area
    bound = np.zeros((2 * (VOUSSOIRS + 1), n + 1))
    for j in range(VOUSSOIRS + 1):
        for k, sign in enumerate((1.0, -1.0)):
            bound[2 * j + k, 3 * j : 3 * j + 3] = -mu, -mu, sign
    limits = [(0.0, None), (0.0, None), (None, None)] * (VOUSSOIRS + 1) + [(None, None)]
    return -float(linprog([0.0] * n + [-1.0], bound, np.zeros(len(bound)), A, b, limits).fun)


def main() -> None:
    """Run the program."""
    warnings.simplefilter("ignore")
    parser = argparse.ArgumentParser(description=__doc__)
    add_options(
        parser,
        ("ratios RATIO", "thickness over radius (default: 0.15)", float, {"nargs": "*", "default": [0.15]}),
        ("--dim D", "2 or 3", 2, {"choices": (2, 3)}),
        ("--size MM", "of the elements", 60.0),
        ("--mu MU", "friction", 0.7),
        ("--tan-psi SLOPE", "of two planes of the joints, which add to the friction; 0: flat", 0.0),
        ("--folder DIR", "for meshes and fields", Path()),
        ("--pvd", "write fields at the last step for ParaView"),
    )
    o = parser.parse_args()
    for ratio in o.ratios:
        path = o.folder / f"arch_{ratio:g}_{o.dim}.msh"
        if COMM.rank == 0:
            mesh(path, ratio, o.dim, o.size)
        COMM.barrier()
        pvd = path.with_suffix(".pvd") if o.pvd else None
        collapsed, unknowns = collapse(path, ratio, o.dim, o.mu, o.tan_psi, pvd)
        if COMM.rank == 0:
            strength = (o.mu + o.tan_psi) / (1.0 - o.mu * o.tan_psi)
            rigid = f"limit analysis {limit(ratio, strength):.4f} g"
            print(f"t/R {ratio:g}: {collapsed:.4f} g, {rigid}, {unknowns} unknowns", flush=True)


if __name__ == "__main__":
    main()
