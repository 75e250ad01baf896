"""Masonry walls under pressure whose top is moved sideways, mm, N, MPa; ranks of MPI share a wall.

The wall is pressed in four steps and then moved.  Rows are written step by step, and the last line printed is
a summary in JSON.  The exit status is 3 where the run stops before its end.
"""

from __future__ import annotations

import argparse
import json
import resource
import sys
import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from asperity.interface import Interface
from asperity.material import Material
from asperity.mesh import Jointed, split
from asperity.options import add_options
from asperity.pattern import Pattern
from jointed import COMM, Follow, Model, Output, Steps, total
from jointed_follow import ERRORS, PASSES
from petsc4py import PETSc
from structured import grid

HEAD = "displacement [mm],horizontal [kN],vertical [kN],dissipated [kN mm],iterations,passes,e_a [-],e_t [-]"

MID_BRICK, STIFFER = 1.0e4, 10.0
"""Stiffness of the potential crack in a brick, N/mm3; modulus of a beam over that of the bricks."""

STOPPED, SAVED = 3, 10
"""Exit status of a run that stops before its end; rows between two files to go on from."""


@dataclass(frozen=True)
class Masonry:
    """A wall that was tested.

    half_brick: length, thickness, height.  joint: constants of `Material.from_masonry`, or of
    `Material.from_joint` for dry joints.  crack: strength and fracture energy of a brick; None: it stays
    whole.  beam: height of a stiff loading beam on top and of a foundation, with joints to the wall, which is
    moved at a `level` above the foundation and may turn; without a beam the top stays horizontal and its
    height is held.  pressure: at the base, with the weight (per volume) of the wall.
    """

    columns: int
    courses: int
    half_brick: tuple[float, float, float]
    pressure: float
    joint: dict[str, float]
    E: float = 16700.0
    nu: float = 0.15
    crack: tuple[float, float] | None = (2.0, 0.08)
    beam: float = 0.0
    level: float = 0.0
    weight: float = 0.0


STIFF, SOFT = {"kn": 110.0, "ks": 50.0}, {"kn": 82.0, "ks": 36.0}
STRONG = {"ft": 0.25, "GfI": 0.018, "c": 0.35, "GfII": 0.125, "tan_phi": 0.75}
WEAK = {"ft": 0.16, "GfI": 0.012, "c": 0.224, "GfII": 0.05, "tan_phi": 0.75}

BRICK = Masonry(9, 16, (110.0, 100.0, 62.5), 0.3, SOFT | STRONG)
GRANITE = Masonry(10, 8, (100.0, 200.0, 150.0), 0.0, {}, 20000.0, 0.2, None, 250.0, 1325.0, 2.6e-5)
SANDSTONE = Masonry(10, 10, (100.0, 200.0, 100.0), 0.0, {}, 15500.0, 0.2, None, 100.0, 1000.0, 2.4e-5)


def dry(wall: Masonry, force: float, kn: float, mu: float) -> Masonry:
    """Wall of dry joints under a vertical force in kN; ks = 0.4 kn."""
    area = wall.columns * wall.half_brick[0] * wall.half_brick[1]
    return replace(wall, pressure=1e3 * force / area, joint={"kn": kn, "ks": 0.4 * kn, "mu": mu})


WALLS = {
    "J4D": BRICK,
    "J6D": replace(BRICK, pressure=1.21, joint=STIFF | WEAK),
    "J7D": replace(BRICK, pressure=2.12, joint=SOFT | WEAK),
    "WS40": dry(GRANITE, 44.8, 5.9, 0.65),
    "WS100": dry(GRANITE, 104.8, 7.9, 0.65),
    "WS175": dry(GRANITE, 179.8, 12.3, 0.65),
    "WS250": dry(GRANITE, 254.8, 12.9, 0.65),
    "SW30": dry(SANDSTONE, 33.6, 5.9, 0.62),
    "SW100": dry(SANDSTONE, 103.6, 7.9, 0.62),
    "SW200": dry(SANDSTONE, 203.6, 12.3, 0.62),
    "SW250": dry(SANDSTONE, 253.6, 12.9, 0.62),
}
"""Walls by the names of their tests; docs/validation/walls.md has the sources."""


def laws(
    wall: Masonry, pattern: Pattern, height: float, tau_v: float, changed: dict[str, float]
) -> dict[str, Interface]:
    """Laws of the joints and of the flat cracks in mid-brick; `changed` are constants of the joint."""
    if unknown := set(changed) - set(wall.joint):
        raise ValueError(f"{', '.join(sorted(unknown))}: expected {', '.join(wall.joint)}")
    if "mu" in wall.joint:
        joint = Material.from_joint(**wall.joint | changed)
        if tau_v:
            raise ValueError(f"tau = {tau_v:g}: expected 0 for dry joints, which do not soften")
    else:
        joint = replace(Material.from_masonry(**wall.joint | changed), kc=1.0, tau_v=tau_v)
    found = {"joint": Interface(replace(joint, height=height), pattern)}
    if wall.crack:
        strength, energy = wall.crack
        eta = 1.0 - strength**2 / (2.0 * MID_BRICK * energy)
        crack = Material(strength, energy, eta, 0.75, kc=1.0, tau_v=tau_v)
        found["crack"] = Interface(crack, Pattern.regular(0, 0.0))
    return found


def mesh(wall: Masonry, elements: Sequence[int]) -> Jointed:
    """Mesh with joints; elements: of a half-brick.  Groups bottom and top, blocks beam_N."""
    d = len(elements)
    length, thickness, height = wall.half_brick
    beams = [wall.beam] * (wall.beam > 0.0)
    heights = np.array([*beams, *[height] * wall.courses, *beams])
    nc, nr, n = wall.columns, len(heights), elements[-1]
    up = np.concatenate([[0.0], *(base + h * np.arange(1, n + 1) / n for base, h in zip(
        np.cumsum(heights) - heights, heights, strict=True))])  # fmt: skip
    axes = [np.arange(nc * elements[0] + 1) * length / elements[0], up]
    if d == 3:
        axes.insert(1, np.arange(elements[1] + 1) * thickness / elements[1])
    parts = [len(a) - 1 for a in axes]
    i, *_, j = np.indices(parts).reshape(d, -1)
    i, j = i // elements[0], j // n
    stiff = (wall.beam > 0.0) & ((j == 0) | (j == nr - 1))
    brick = np.where(stiff, 0, i if wall.crack else (i + j % 2) // 2)
    tags = j * (nc + 1) + brick
    names = {f"beam_{k}": k * (nc + 1) for k in (0, nr - 1) if wall.beam}
    whole = grid(*axes, block=tags.reshape(parts), names=names)
    if not wall.crack:
        return split(whole)
    block = np.unique(tags)

    def cracks(a: np.ndarray, b: np.ndarray, x: np.ndarray, normal: np.ndarray) -> np.ndarray:
        row, column = np.divmod(block[a], nc + 1)
        return (np.abs(normal[:, 0]) > 0.5) & ((row + column) % 2 == 0)

    return split(whole, {"crack": cracks, "joint": ("*", "*")})


class Run:
    """A wall under its pressure, which is then moved."""

    def __init__(self, o: argparse.Namespace) -> None:
        """Build the wall and press it."""
        wall = replace(
            WALLS[o.wall], columns=WALLS[o.wall].columns * o.scale, courses=WALLS[o.wall].courses * o.scale
        )
        pattern = Pattern.regular(o.sides, o.theta, turn=o.turn) if o.theta else Pattern.regular(0, 0.0)
        changed = {name: float(value) for name, value in (one.split("=", 1) for one in o.joint)}
        found = laws(wall, pattern, o.height, o.tau, changed)
        whole = mesh(wall, o.elements) if COMM.rank == 0 else None
        names = COMM.bcast(whole.names if whole else None)
        E = {name: (STIFFER if name.startswith("beam") else 1.0) * wall.E for name in names}
        self.model = m = Model(whole, found, E, wall.nu, wall.half_brick[1])
        up, sides = m.d - 1, range(m.d - 1)
        (top, area), (bottom, _) = m.group("top"), m.group("bottom")
        pushed = (
            np.abs(m.x[:, up] - (wall.beam + wall.level)) < 1e-6 if wall.beam else np.isin(range(m.n), top)
        )
        if wall.beam:
            pushed &= m.x[:, up] > COMM.allreduce(m.x[:, up].max(), max) - 1.001 * wall.beam
        if not COMM.allreduce(int(pushed.sum())):
            raise ValueError(
                f"elements {o.elements}: expected nodes of the beam at the level {wall.level:g} mm"
            )
        weight = m.body([0.0] * up + [-wall.weight]) * m.solid(
            *(k for k in names if not k.startswith("beam"))
        )
        load = weight.reshape(-1, m.d)
        above = wall.pressure + total(weight.sum()) / total(area.sum())
        load[top, up] -= above * area
        load, self.bottom = load.ravel(), bottom
        drag = o.drag * m.solid(*(k for k in names if not k.startswith("beam"))) * np.abs(m.body([1.0] * m.d))
        base, push = m.dofs(bottom, *range(m.d)), m.dofs(pushed, 0)
        first = Steps(m, np.r_[base, m.dofs(pushed, *sides)], o.tolerance, o.petsc, drag)
        for part in (0.25, 0.5, 0.75, 1.0):
            if not first.solve(np.zeros(len(first.fixed)), part * load):
                raise ValueError(f"the pressure: {first.message}")
        self.steps = first
        if not wall.beam:
            self.steps = Steps(m, np.r_[base, m.dofs(pushed, *range(m.d))], o.tolerance, o.petsc, drag)
            first.destroy()
            load = 0.0 * load
        at, along = m.u[self.steps.fixed], np.isin(self.steps.fixed, push)
        self.follow = Follow(
            self.steps, lambda t: (at + t * along, load), o.step, o.most, 1e-5, o.passes, o.limit, o.errors
        )
        self.follow.by_passes = self.follow.always = o.always

    def row(self) -> tuple[float, ...]:
        """Displacement, forces at the base, energy of rupture and friction, iterations, passes, errors."""
        m = self.model
        F = self.steps.reaction.reshape(-1, m.d)[self.bottom]
        along, up = (total(F[:, k].sum()) / 1e3 for k in (0, -1))
        steps = self.steps
        return self.follow.at, -along, up, m.spent() / 1e3, steps.iterations, steps.passes, *steps.errors


def options() -> argparse.Namespace:
    """Options of the command line."""
    parser = argparse.ArgumentParser(prog="walls.py", description=__doc__, allow_abbrev=False)
    of_half_brick = "of a half-brick: length and height, or length, thickness and height in 3D (default: 4 3)"
    add_options(
        parser,
        ("--wall", "one of the tested walls", "J4D", {"choices": tuple(WALLS)}),
        ("--elements N", of_half_brick, int, {"nargs": "+", "default": [4, 3]}),
        ("--scale N", "so many times the half-bricks and courses", 1),
        ("--theta DEGREES", "of the pattern of the joints; 0: flat", 0.0),
        ("--sides M", "of the pattern", 4),
        ("--turn DEGREES", "of the pattern", 0.0),
        ("--height MM", "of the asperities; 0: infinite", 0.0),
        ("--tau MM", "tau_v, in mm of the top", 0.0),
        ("--drag FORCE", "on a volume, N/mm3, that moves as fast as the top", 0.0),
        ("--joint NAME=VALUE", "other constants, such as kn=10", str, {"nargs": "+", "default": []}),
        ("--to MM", "displacements in turn (4)", float, {"nargs": "+", "default": [4.0]}),
        ("--step MM", "first step", 0.02),
        ("--most MM", "largest step", 0.05),
        ("--passes N", "most of a step where Newton's method fails; 0: none", PASSES),
        ("--always", "all steps by passes"),
        (
            "--errors E",
            "of a damage and of forces, beyond which a shorter step by passes follows (0.1 0.05)",
            float,
            {"nargs": 2, "default": ERRORS},
        ),
        (
            "--limit E",
            "of the error of forces, beyond which a shortest step by passes ends the run",
            ERRORS[1],
        ),
        ("--tolerance TOLERANCE", "residual over the prescribed forces and loads", 1e-6),
        ("--petsc OPTIONS", "of PETSc, in one word", str, {"default": ""}),
        ("--out FILE.csv", "rows, and FILE.RANK.npz to go on from", Path),
        ("--resume", "go on from the files of --out"),
        ("--pvd FILE.pvd", "fields at the displacements --to", Path),
    )
    o = parser.parse_args()
    for name, right, text in (
        ("elements", len(o.elements) in (2, 3) and min(o.elements) >= 1, "2 or 3 numbers of at least 1"),
        ("scale", o.scale >= 1, "at least 1"),
        ("step", 0.0 < o.step <= o.most < np.inf, "between 0 and --most"),
        ("tolerance", 0.0 < o.tolerance < 0.1, "between 0 and 0.1"),
        ("passes", o.passes >= 0, "at least 0"),
        ("always", not o.always or o.passes, "with --passes of at least 1"),
        ("errors", all(0.0 < one < 1.0 for one in o.errors), "2 numbers between 0 and 1"),
        ("limit", 0.0 < o.limit < 1.0, "between 0 and 1"),
        ("drag", 0.0 <= o.drag < np.inf, "at least 0"),
        ("to", np.isfinite(o.to).all() and all(np.diff([0.0, *o.to])), "finite, each another than before"),
        ("resume", not o.resume or o.out, "with --out"),
        ("out", not o.out or o.resume or not o.out.exists(), "a new file, or --resume"),
    ):
        if not right:
            parser.error(f"--{name} {getattr(o, name)}: expected {text}")
    return o


def main() -> int:
    """Run the program."""
    warnings.simplefilter("ignore")
    o, begin = options(), time.process_time()
    PETSc.Log.begin()
    say = print if COMM.rank == 0 else lambda *words, **how: None
    try:
        run = Run(o)
        follow, rows = run.follow, []
        if o.resume:
            follow.resume(o.out)
            rows = np.loadtxt(o.out, delimiter=",", skiprows=1, ndmin=2)[: follow.count].tolist()
    except (ValueError, OSError) as error:
        say(f"walls.py: {error}", file=sys.stderr)
        return 2
    if o.out and COMM.rank == 0:
        o.out.write_text("\n".join([HEAD, *(",".join(f"{x:.12g}" for x in row) for row in rows), ""]))
    output = Output(run.model, o.pvd) if o.pvd else None
    for end in [end for end in o.to[:-1] if not any(row[0] == end for row in rows)] + o.to[-1:]:
        while follow.at != end and not follow.reason:
            if follow.advance(end):
                rows.append(run.row())
                if o.out and COMM.rank == 0:
                    with o.out.open("a") as file:
                        file.write(",".join(f"{x:.12g}" for x in rows[-1]) + "\n")
                if o.out and (follow.count % SAVED == 0 or follow.at == end):
                    follow.save(o.out)
        if output and follow.at == end:
            output.write(end)
    at, force, _, spent, _, passes, *errors = np.array(rows).reshape(-1, len(HEAD.split(","))).T
    peak = int(np.abs(force).argmax()) if len(force) else 0
    entries, operations, gigabytes = run.steps.factor()
    lu, cholesky = (PETSc.Log.Event(f"Mat{name}Num").getPerfInfo() for name in ("LUFactor", "CholFctr"))
    say(json.dumps({
        "unknowns": run.model.K.getSize()[0], "points": int(total(len(run.model.area))), "ranks": COMM.size,
        "steps": len(rows), "cuts": follow.cuts, "repeated": follow.repeated,
        "by_passes": int((passes > 0).sum()), "e_a": float(errors[0].max(initial=0.0)),
        "e_t": float(errors[1].max(initial=0.0)), "work": float(np.trapezoid(np.r_[0, force], np.r_[0, at])),
        "dissipated": float(spent[-1]) if rows else 0.0,
        "iterations": follow.taken, "linear": run.model.linear,
        "seconds": time.process_time() - begin, "law": run.model.clock,
        "memory": COMM.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) / 1e6,
        "peak": float(force[peak]) if rows else 0.0, "at": float(at[peak]) if rows else 0.0, "end": follow.at,
        "entries": entries, "operations": operations, "gigabytes": gigabytes,
        **{name: one["time"] / max(one["count"], 1) for name, one in (("lu", lu), ("cholesky", cholesky))},
    }))  # fmt: skip
    if follow.reason:
        say(f"walls.py: {follow.reason}", file=sys.stderr)
    return STOPPED if follow.reason else 0


if __name__ == "__main__":
    sys.exit(main())
