"""Masonry wall under pressure whose top is moved sideways: half-bricks and joints on ranks of MPI.

The wall is pressed in four steps and then moved.  Rows are written step by step, and the last line printed is
a summary in JSON.  The exit status is 3 where the run stops before its end.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import sys
import time
import warnings
from collections.abc import Sequence
from contextlib import redirect_stderr
from dataclasses import replace
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from asperity import contract
from asperity.contract import Floats
from asperity.pattern import Pattern
from distributed import COMM, SOLVERS, NotConvergedError, Wall, largest, total
from explicit import Explicit
from masonry import WALLS, laws
from newton import Steps
from petsc4py import PETSc

sys.path.insert(0, str(Path(__file__).parent.parent))
import paraview_files as paraview

HEAD = "displacement [mm],horizontal [kN],vertical [kN],dissipated [kN mm],iterations"
MODEL = (
    "wall",
    "elements",
    "scale",
    "theta",
    "sides",
    "turn",
    "height",
    "tau",
    "drag",
    "kc",
    "joint",
    "ranks",
)
"""Options that a run that goes on must share with the one before."""

LEAST_STEP = 1e-5
"""Least step, mm."""

FAST, SLOW, GROWTH = 6, 8, 1.5
"""A step grows after at most FAST iterations, and a step of path control falls after more than SLOW."""

LEAST_ARC, PLAIN = 1e-4, 5e-3
"""Least part of a step of path control; plain step, mm, after it."""

STOPPED = 3
"""Exit status of a run that stops before its end."""

SAVED = 10
"""Rows between two files to go on from."""


def read_options() -> argparse.Namespace:
    """Options of the command line."""
    parser = argparse.ArgumentParser(
        prog="shear_wall.py",
        description=__doc__,
        allow_abbrev=False,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--wall", default="J4D", help=f"one of {', '.join(WALLS)}")
    text = "of a half-brick: length and height, or length, thickness and height in 3D (default: 4 3)"
    add("--elements", type=int, nargs="+", default=[4, 3], metavar="N", help=text)
    add("--scale", type=int, default=1, help="so many times the half-bricks and courses")
    add("--theta", type=float, default=0.0, help="of the pattern of the joints, degrees; 0: flat")
    add("--sides", type=int, default=4, help="of the pattern (default: %(default)s)")
    add("--turn", type=float, default=0.0, help="of the pattern, degrees")
    add("--height", type=float, default=0.0, help="of the asperities, mm; 0: infinite")
    add("--tau", type=float, default=0.0, help="tau_v, in mm of the top")
    add("--drag", type=float, default=0.0, help="force on a volume, N/mm3, that moves as fast as the top")
    add("--kc", type=float, default=1.0, help="of mortar joints (default: %(default)s)")
    add(
        "--joint",
        nargs="+",
        default=[],
        metavar="NAME=VALUE",
        help="other constants of the joint, such as kn=10",
    )
    add(
        "--to",
        type=float,
        nargs="+",
        default=[4.0],
        metavar="MM",
        help="displacements, one after the other (4)",
    )
    add("--step", type=float, default=0.02, help="first step, mm (default: %(default)s)")
    add("--most", type=float, default=0.05, help="largest step, mm (default: %(default)s)")
    add(
        "--tolerance", type=float, default=1e-6, help="residual over the largest force (default: %(default)s)"
    )
    add("--iterations", type=int, default=40, help="most in a step (default: %(default)s)")
    add(
        "--arc",
        type=float,
        default=0.0,
        metavar="MM",
        help="path control where plain steps fail: mean separation",
    )
    add("--explicit", type=float, default=0.0, metavar="MM", help="explicit dynamics: the top in a time step")
    add("--solver", default="mumps", choices=tuple(SOLVERS), help="direct, or of two levels")
    add("--petsc", default="", metavar="OPTIONS", help="more options of PETSc, in one word")
    add("--ranks", type=int, nargs=2, default=[COMM.size, 1], metavar="N", help="along length and height")
    add("--out", type=Path, metavar="FILE.csv", help="rows, and FILE.RANK.npz every ten steps to go on from")
    add(
        "--resume", action="store_true", help="go on from the files of --out, with the same ranks and options"
    )
    add("--pvd", type=Path, metavar="FILE.pvd", help="fields at the displacements --to; one rank")
    with redirect_stderr(sys.stderr if COMM.rank == 0 else open(os.devnull, "w")):
        options = parser.parse_args()
        check(parser, options)
    return options


def check(parser: argparse.ArgumentParser, options: argparse.Namespace) -> None:
    """End the program where an option is out of range, and build the laws."""
    o, bad = options, []
    for name, right, text in (
        ("wall", o.wall in WALLS, f"one of {', '.join(WALLS)}"),
        ("elements", len(o.elements) in (2, 3) and min(o.elements) >= 1, "2 or 3 numbers of at least 1"),
        ("scale", o.scale >= 1, "at least 1"),
        ("step", LEAST_STEP <= o.step < np.inf, f"at least {LEAST_STEP:g}"),
        ("most", o.step <= o.most < np.inf, "at least --step"),
        ("tolerance", 0.0 < o.tolerance < 0.1, "between 0 and 0.1"),
        ("iterations", o.iterations >= 1, "at least 1"),
        (
            "arc",
            0.0 <= o.arc < np.inf and not (o.arc and len(o.to) > 1),
            "at least 0, with one value of --to",
        ),
        ("arc", not (o.arc and (o.tau or o.drag)), "without --tau and --drag"),
        ("arc", not o.arc or o.to[0] > 0.0, "--to above 0"),
        ("explicit", 0.0 <= o.explicit <= o.most, "between 0 and --most"),
        ("explicit", not o.explicit or (len(o.to) == 1 and o.to[0] > 0.0), "one value of --to above 0"),
        ("explicit", not (o.explicit and (o.arc or o.drag)), "without --arc and --drag"),
        ("drag", 0.0 <= o.drag < np.inf, "at least 0"),
        (
            "to",
            bool(np.all(np.isfinite(o.to))) and all(np.diff([0.0, *o.to])),
            "finite, each another than before",
        ),
        ("height", not o.height or o.theta, "with --theta"),
        (
            "ranks",
            min(o.ranks) >= 1 and np.prod(o.ranks) == COMM.size,
            f"a product of {COMM.size}, the ranks",
        ),
        ("resume", not o.resume or (o.out and not (o.arc or o.explicit)), "with --out and Newton's method"),
        ("pvd", not o.pvd or COMM.size == 1, "one rank"),
        ("out", not o.out or o.out.parent.is_dir(), "a folder that exists"),
        ("out", not o.out or o.resume or not o.out.exists(), "a new file, or --resume"),
    ):
        if not right:
            bad.append(f"--{name} {getattr(o, name)}: expected {text}")
    if not bad:
        wall = WALLS[o.wall]
        o.masonry = replace(wall, columns=wall.columns * o.scale, courses=wall.courses * o.scale)
        grid = o.masonry.columns, len(o.masonry.heights())
        if o.ranks[0] > grid[0] or o.ranks[1] > grid[1]:
            bad.append(
                f"--ranks {o.ranks}: expected at most {grid[0]} along the length and {grid[1]} courses"
            )
        if "mu" in wall.joint and (o.tau or o.kc != 1.0):
            bad.append(
                f"--tau {o.tau:g}, --kc {o.kc:g}: expected 0 and 1 for dry joints, which do not soften"
            )
        try:
            changed = {name: float(value) for name, value in (one.split("=", 1) for one in o.joint)}
            if unknown := set(changed) - set(wall.joint):
                raise ValueError(f"{', '.join(sorted(unknown))}: expected {', '.join(wall.joint)}")
            pattern = Pattern.regular(o.sides, o.theta, turn=o.turn) if o.theta else Pattern.regular(0, 0.0)
            o.laws = laws(o.masonry, pattern, o.height, o.kc, o.tau, **changed)
        except (ValueError, TypeError) as error:
            bad.append(f"constants: {error}")
    if bad:
        parser.error("\n".join(bad))


class Run:
    """A run: its wall, displacements u, top `at` mm, last change of u and of the top, rows."""

    def __init__(self, options: argparse.Namespace) -> None:
        """Build the wall and press it."""
        self.o, o = options, options
        self.wall = w = Wall(o.masonry, o.laws, o.elements, o.ranks)
        self.steps = Steps(w, o.tolerance, o.iterations, o.drag)
        turns = o.masonry.beam > 0.0
        fixed = np.zeros((len(w.nodes), w.d), bool)
        fixed[w.bottom] = True
        fixed[w.pushed, 0] = True
        if w.d == 3:
            fixed[w.pushed, 1] = True
        w.restrain(fixed, o.solver)
        load = np.zeros((w.own, w.d))
        weight = o.masonry.weight * w.volume
        load[:, -1] = -weight - w.area * (o.masonry.pressure - total(weight.sum()) / total(w.area.sum()))
        self.u, none = (np.zeros(w.own * w.d) for _ in range(2))
        for part in (0.25, 0.5, 0.75, 1.0):
            self.u = self.steps.newton(self.u, none, part * load.ravel(), 1.0)
        if not turns:
            fixed[w.pushed] = True
            w.restrain(fixed, o.solver)
        self.load = load.ravel() if turns else none
        self.push = np.zeros((w.own, w.d))
        self.push[w.pushed[: w.own], 0] = 1.0
        self.push = self.push.ravel()
        self.at, self.move, self.last, self.step, self.arc = 0.0, 0.0, none, o.step, 0.0
        self.rows: list[tuple[float, ...]] = []
        self.cuts, self.taken, self.reason = 0, 0, ""
        self.motion = Explicit(w, self.u, self.push, self.load, o.explicit) if o.explicit else None

    def row(self) -> tuple[float, ...]:
        """Displacement, forces at the base, energy of rupture and friction, iterations."""
        w = self.wall
        F = (w.F - self.load).reshape(-1, w.d)[w.bottom[: w.own]]
        kinds = [contract.statev_index(name) for name in ("rupture", "friction")]
        spent = total(sum(float(g.area @ g.state[:, kinds].sum(1)) for g in w.joints))
        return (
            self.at,
            -total(F[:, 0].sum()) / 1e3,
            total(F[:, -1].sum()) / 1e3,
            spent / 1e3,
            self.steps.iterations,
        )

    def advance(self, target: float) -> None:
        """Take one step towards a displacement, or cut it."""
        if self.motion:
            self.march(target)
            return
        o, w, left = self.o, self.wall, target - self.at
        last = abs(left) <= self.step * (1.0 + 1e-6)  # no step of rounding errors is left
        move = left if last else np.copysign(self.step, left)
        try:
            if self.arc:
                new = self.steps.path(self.u, self.push, self.load, self.arc)
                move = total((new - self.u) @ self.push) / total(self.push.sum())
            else:
                ahead = self.last * (move / self.move) if self.move * move > 0.0 else None
                new = self.steps.newton(self.u, move * self.push, self.load, abs(move), ahead)
        except NotConvergedError as error:
            self.cuts += 1
            self.taken += self.steps.iterations
            if self.arc:
                self.arc /= 2.0
                over = self.arc < LEAST_ARC
            else:
                self.step = min(self.step, abs(move)) / 2.0
                over = self.step < LEAST_STEP
                self.arc = 0.5 if o.arc and self.step < 0.002 else 0.0
            self.reason = f"stopped at {self.at:.5g} mm: {error}" if over else ""
            return
        self.last, self.u, self.move = new - self.u, new, move
        self.at = target if last and not self.arc else self.at + move
        self.taken += self.steps.iterations
        self.rows.append(self.row())
        if self.steps.iterations <= FAST:
            self.step = min(GROWTH * self.step, o.most)
        if self.arc:
            pace = GROWTH if self.steps.iterations < FAST else 1.0 if self.steps.iterations <= SLOW else 0.6
            self.arc = min(pace, o.arc / self.steps.length * self.arc)
            if largest(np.concatenate([g.growth for g in w.joints])) <= 1e-9:
                self.arc, self.step = 0.0, PLAIN  # nothing is damaged any more

    def march(self, target: float) -> None:
        """Move on by explicit dynamics for a row."""
        try:
            moved = self.motion.move(min(self.o.most, target - self.at))
        except NotConvergedError as error:
            self.reason = f"stopped at {self.at:.5g} mm: {error}"
            return
        self.u, self.at, self.taken = self.motion.u, self.at + moved, self.motion.steps
        self.rows.append(self.row())

    def names(self) -> dict[str, Floats]:
        """What a run goes on from, on this rank."""
        joints = {
            f"{what}{k}": getattr(g, what) for k, g in enumerate(self.wall.joints) for what in ("s", "state")
        }
        now = np.array([self.at, self.move, self.step, self.cuts, self.taken, len(self.rows)])
        kept = {name: value for name, value in vars(self.o).items() if name in MODEL}
        return joints | {"u": self.u, "last": self.last, "now": now, "model": np.array(str(kept))}

    def file(self) -> Path:
        """File of this rank to go on from."""
        return self.o.out.with_suffix(f".{COMM.rank}.npz")

    def save(self) -> None:
        """Write what a run goes on from."""
        new = self.file().with_suffix(".new.npz")
        np.savez(new, **self.names())
        new.replace(self.file())  # whole even if the run is ended here

    def resume(self) -> None:
        """Go on from the files of an earlier run."""
        try:
            found, rows = (
                dict(np.load(self.file())),
                np.loadtxt(self.o.out, delimiter=",", skiprows=1, ndmin=2),
            )
            now = self.names()
            problem = [name for name, value in now.items() if found[name].shape != value.shape]
            problem += ["model"] * (str(found["model"]) != str(now["model"]))
        except (OSError, KeyError, ValueError, EOFError, BadZipFile) as error:
            problem = [str(error)]
        at = COMM.allgather(b"" if problem else found["now"].tobytes())
        problem += ["ranks at different steps"] * (len(set(at)) > 1)
        if worst := max(COMM.allgather(", ".join(problem))):
            raise ValueError(
                f"--resume: {worst}: expected the files of a run with the same ranks and options"
            )
        for k, g in enumerate(self.wall.joints):
            g.s, g.state = found[f"s{k}"], found[f"state{k}"]
        self.u, self.last = found["u"], found["last"]
        self.at, self.move, self.step, self.cuts, self.taken, count = found["now"].tolist()
        self.rows = [tuple(row) for row in rows[: int(count)]]

    def structure(self) -> paraview.Structure:
        """Mesh for ParaView."""
        w, d = self.wall, self.wall.d
        around = [0, 2, 3, 1] if d == 2 else [0, 4, 6, 2, 1, 5, 7, 3]
        low, high = ([0, 1], [1, 0]) if d == 2 else ([0, 2, 3, 1],) * 2
        sides = [
            np.concatenate([g.nodes[g.faces[:, c], k] for g in w.joints]) for k, c in enumerate((low, high))
        ]
        return paraview.Structure(w.X, w.solids[:, around], np.concatenate(sides, 1), (1,) * d)

    def fields(self) -> paraview.Step:
        """Fields for ParaView; a value in an element of a joint is the mean of those at its nodes."""
        w, parts = self.wall, [[], [], []]
        for g, (s, r) in zip(w.joints, w.accepted, strict=True):
            for part, values in zip(
                parts, (s, r.traction, r.state[:, : contract.N_POINT_STATEV]), strict=True
            ):
                part.append(values[g.faces].mean(1))
        return paraview.Step(self.at, w.spread(self.u), *(np.concatenate(part) for part in parts))


def write(out: Path, rows: Sequence[tuple[float, ...]], mode: str = "a") -> None:
    """Add rows to a file."""
    with out.open(mode, encoding="utf-8") as file:
        if mode == "w":
            file.write(HEAD + "\n")
        file.writelines(",".join(f"{value:.12g}" for value in row) + "\n" for row in rows)


def main() -> int:
    """Run the program."""
    warnings.simplefilter("ignore")
    o = read_options()
    PETSc.Options().insertString(f"{SOLVERS[o.solver]} {o.petsc}")
    say = print if COMM.rank == 0 else lambda *words, **how: None
    begin = time.process_time()
    try:
        run = Run(o)
        if o.resume:
            run.resume()
    except (NotConvergedError, ValueError) as error:
        say(f"shear_wall.py: {error}", file=sys.stderr)
        return 2
    if o.out and COMM.rank == 0:
        write(o.out, run.rows, "w")
    w, steps = run.wall, []
    points = int(total(sum(len(g.area) for g in w.joints)))
    say(f"{o.wall}: {w.M.size[0]} unknowns, {points} points, {COMM.size} ranks", flush=True)
    ends = [end for end in o.to[:-1] if not any(row[0] == end for row in run.rows)] + o.to[-1:]
    for end in ends:
        while run.at != end and not run.reason:
            done = len(run.rows)
            run.advance(end)
            if len(run.rows) == done:
                continue
            if o.out and COMM.rank == 0:
                write(o.out, run.rows[-1:])
            if o.out and len(run.rows) % SAVED == 0:
                run.save()
            if (o.arc or o.explicit) and run.at >= end:
                break
        steps += [run.fields()] if o.pvd and run.at == end else []
    if o.out:
        run.save()
    if o.pvd:
        paraview.write(o.pvd, run.structure(), steps)
    rows = np.array(run.rows).reshape(-1, 5)
    peak = int(np.abs(rows[:, 1]).argmax()) if len(rows) else 0
    summary = {
        "unknowns": w.M.size[0], "points": points, "ranks": COMM.size, "steps": len(rows), "cuts": run.cuts,
        "iterations": int(run.taken), "linear": w.linear, "seconds": time.process_time() - begin, **w.clock,
        "memory": COMM.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) / 1e6,
        "peak": float(rows[peak, 1]) if len(rows) else 0.0, "at": float(rows[peak, 0]) if len(rows) else 0.0,
        "kinetic": run.motion.kinetic if run.motion else 0.0, "end": run.at, "reason": run.reason,
    }  # fmt: skip
    say(json.dumps(summary))
    if run.reason:
        say(f"shear_wall.py: {run.reason}", file=sys.stderr)
    return STOPPED if run.reason else 0


if __name__ == "__main__":
    sys.exit(main())
