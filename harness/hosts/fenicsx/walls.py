"""Masonry walls under pressure whose top is moved sideways, mm, N, MPa; ranks of MPI share a wall.

The wall is pressed and then moved.  Rows are written step by step, and the last line printed is
a summary in JSON.  The exit status is 3 where the run stops before its end.
"""

from __future__ import annotations

import argparse
import json
import resource
import sys
import time
import warnings
from contextlib import suppress
from pathlib import Path

import numpy as np
from asperity.fenicsx import COMM, Conditions, Follow, Model, Output, Report, State, Terms, solve, total
from asperity.fenicsx.equilibrium import SEARCHES
from asperity.fenicsx.path import ERRORS, LIMIT
from asperity.options import add_options
from asperity.pattern import Pattern

from harness.hosts.masonry import LEAST, STIFFER, WALLS, check_options, laws, mesh, sized

PASSES = 8
"""Most passes of a step in the runs of docs/validation/walls.md; paths by themselves take more."""

HEAD = "displacement [mm],horizontal [kN],vertical [kN],dissipated [kN mm],iterations,passes,e_a [-],e_t [-]"

STOPPED, SAVED = 3, 10
"""Exit status of a run that stops before its end; rows between two files to go on from."""


def forget_memory() -> None:
    """Let the largest memory of this process be that from now on, where the system can do that."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")


class Run:
    """A wall under its pressure, which is then moved."""

    def __init__(self, o: argparse.Namespace) -> None:
        """Build the wall and press it."""
        wall = sized(WALLS[o.wall], *o.size, o.bare)
        wall = sized(wall, wall.columns * o.scale, wall.courses * o.scale)
        pattern = Pattern.regular(o.sides, o.theta, turn=o.turn) if o.theta else Pattern.regular(0, 0.0)
        changed = {name: float(value) for name, value in (change.split("=", 1) for change in o.joint)}
        joint_laws = laws(wall, pattern, o.height, o.tau, changed)
        unsplit = mesh(wall, o.elements) if COMM.rank == 0 else None
        names = COMM.bcast(unsplit.names if unsplit else None)
        E = {name: (STIFFER if name.startswith("beam") else 1.0) * wall.E for name in names}
        thickness = wall.half_brick[1] if len(o.elements) == 2 else 1.0
        self.model = m = Model(unsplit, joint_laws, E, wall.nu, thickness)
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
        terms = Terms(drag=drag, tolerance=o.tolerance, search=o.search, options=o.petsc)
        state = State.virgin(m)
        fixed = np.r_[base, m.dofs(pushed, *sides)]
        for part in range(1, o.press + 1):
            report = solve(m, state, Conditions(fixed, load=part / o.press * load), terms)
            if report.state is None:
                raise ValueError(f"the pressure: {report.reason}")
            state = report.state
        if not wall.beam:
            fixed, load = np.r_[base, m.dofs(pushed, *range(m.d))], 0.0 * load
        at, along = state.u[fixed], np.isin(fixed, push)
        self.follow = Follow(
            m, state, lambda t: Conditions(fixed, at + t * along, load), o.step, o.most, LEAST, terms,
            o.passes, o.limit, o.errors, o.always,
        )  # fmt: skip
        self.begin = time.process_time()
        forget_memory()

    def row(self, report: Report) -> tuple[float, ...]:
        """Displacement, forces at the base, energy of rupture, friction and crushing, iterations, errors."""
        m = self.model
        F = report.reaction.reshape(-1, m.d)[self.bottom]
        along, up = (total(F[:, k].sum()) / 1e3 for k in (0, -1))
        spent = self.follow.ledger.spent / 1e3
        return self.follow.at, -along, up, spent, report.iterations, report.passes, *report.errors


def options() -> argparse.Namespace:
    """Options of the command line."""
    parser = argparse.ArgumentParser(prog="walls", description=__doc__, allow_abbrev=False)
    of_half_brick = "of a half-brick: length and height, or length, thickness and height in 3D (default: 4 3)"
    add_options(
        parser,
        ("--wall", "one of the tested walls", "J4D", {"choices": tuple(WALLS)}),
        ("--elements N", of_half_brick, int, {"nargs": "+", "default": [4, 3]}),
        ("--size N", "half-bricks and courses (default: as tested)", int, {"nargs": 2, "default": [0, 0]}),
        ("--bare", "without beams and weight"),
        ("--scale N", "so many times the half-bricks and courses", 1),
        ("--theta DEGREES", "of the pattern of the joints; 0: flat", 0.0),
        ("--sides M", "of the pattern", 4),
        ("--turn DEGREES", "of the pattern", 0.0),
        ("--height MM", "of the asperities; 0: infinite", 0.0),
        ("--tau MM", "tau_v, in mm of the top", 0.0),
        ("--drag FORCE", "on a volume, N/mm3, that moves as fast as the top", 0.0),
        ("--joint NAME=VALUE", "other constants, such as kn=10", str, {"nargs": "+", "default": []}),
        ("--to MM", "displacements in turn (4)", float, {"nargs": "+", "default": [4.0]}),
        ("--press N", "steps in which it is pressed", 4),
        ("--step MM", "first step", 0.02),
        ("--most MM", "largest step", 0.05),
        ("--passes N", "most of a step where Newton's method fails; 0: none", PASSES),
        ("--always", "all steps by passes"),
        (
            "--errors E",
            "of a damage and of forces, beyond which a shorter step by passes follows (0.1 0.01)",
            float,
            {"nargs": 2, "default": ERRORS},
        ),
        (
            "--limit E",
            "of the error of forces, beyond which a shortest step by passes ends the run",
            LIMIT,
        ),
        ("--tolerance TOLERANCE", "residual over the prescribed forces and loads", 1e-6),
        ("--search NAME", f"one of {', '.join(SEARCHES)}", SEARCHES[0], {"choices": SEARCHES}),
        ("--petsc OPTIONS", "of PETSc for linear equations, in one word", str, {"default": ""}),
        ("--out FILE.csv", "rows, and FILE.RANK.npz to go on from", Path),
        ("--resume", "go on from the files of --out"),
        ("--pvd FILE.pvd", "fields at the displacements --to", Path),
    )
    o = parser.parse_args()
    check_options(
        parser,
        o,
        (2, 3),
        ("scale", o.scale >= 1, "at least 1"),
        ("press", o.press >= 1, "at least 1"),
        ("tolerance", 0.0 < o.tolerance < 0.1, "between 0 and 0.1"),
        ("passes", o.passes >= 0, "at least 0"),
        ("always", not o.always or o.passes, "with --passes of at least 1"),
        ("errors", all(0.0 < error < 1.0 for error in o.errors), "2 numbers between 0 and 1"),
        ("limit", 0.0 < o.limit < 1.0, "between 0 and 1"),
        ("drag", 0.0 <= o.drag < np.inf, "at least 0"),
        ("to", np.isfinite(o.to).all() and all(np.diff([0.0, *o.to])), "finite, each another than before"),
        ("resume", not o.resume or o.out, "with --out"),
        ("out", not o.out or o.resume or not o.out.exists(), "a new file, or --resume"),
    )
    return o


def main() -> int:
    """Run the program."""
    warnings.simplefilter("ignore")
    o, begin = options(), time.process_time()
    say = print if COMM.rank == 0 else lambda *words, **how: None
    try:
        run = Run(o)
        follow, rows = run.follow, []
        if o.resume:
            follow.resume(o.out.with_suffix(""))
            rows = np.loadtxt(o.out, delimiter=",", skiprows=1, ndmin=2)[: follow.count].tolist()
    except (ValueError, OSError) as error:
        say(f"walls.py: {error}", file=sys.stderr)
        return 2
    if o.out and COMM.rank == 0:
        o.out.write_text("\n".join([HEAD, *(",".join(f"{x:.12g}" for x in row) for row in rows), ""]))
    output, linear, law = Output(run.model, o.pvd) if o.pvd else None, 0, 0.0
    for end in [end for end in o.to[:-1] if not any(row[0] == end for row in rows)] + o.to[-1:]:
        while follow.at != end and not follow.reason:
            taken = follow.advance(end)
            linear, law = linear + follow.report.linear, law + follow.report.law
            if taken:
                rows.append(run.row(follow.report))
                if o.out and COMM.rank == 0:
                    with o.out.open("a") as file:
                        file.write(",".join(f"{x:.12g}" for x in rows[-1]) + "\n")
                if o.out and (follow.count % SAVED == 0 or follow.at == end):
                    follow.save(o.out.with_suffix(""))
        if output and follow.at == end:
            output.write(follow.state)
    at, force, _, spent, _, passes, *errors = np.array(rows).reshape(-1, len(HEAD.split(","))).T
    peak = int(np.abs(force).argmax()) if len(force) else 0
    snaps = errors[1] > o.errors[1]  # of shortest steps
    entries, operations, gigabytes = follow.report.factor if follow.report else (0.0, 0.0, 0.0)
    moving = COMM.allreduce(time.process_time() - run.begin)
    say(json.dumps({
        "unknowns": run.model.K.getSize()[0], "points": int(total(len(run.model.area))),
        "ranks": COMM.size, "steps": len(rows), "cuts": follow.cuts, "repeated": follow.repeated,
        "by_passes": int((passes > 0).sum()), "e_a": float(errors[0].max(initial=0.0)),
        "e_t": float(errors[1].max(initial=0.0)), "snaps": int(snaps.sum()),
        "calm": float(errors[1][~snaps].max(initial=0.0)),
        "work": float(np.trapezoid(np.r_[0, force], np.r_[0, at])),
        "dissipated": float(spent[-1]) if rows else 0.0, "unbalanced": follow.unbalanced,
        "released": follow.ledger.released / follow.ledger.work if follow.ledger.work else 0.0,
        "iterations": follow.taken, "linear": linear, "moving": moving,
        "seconds": time.process_time() - begin, "law": law,
        "memory": COMM.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) / 1e6,
        "peak": float(force[peak]) if rows else 0.0, "at": float(at[peak]) if rows else 0.0, "end": follow.at,
        "entries": entries, "operations": operations, "gigabytes": gigabytes,
    }))  # fmt: skip
    if follow.reason:
        say(f"walls.py: {follow.reason}", file=sys.stderr)
    return STOPPED if follow.reason else 0


if __name__ == "__main__":
    sys.exit(main())
