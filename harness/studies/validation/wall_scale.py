"""Walls of growing size by several solvers: runs and tables of docs/validation/walls.md."""

from __future__ import annotations

import json

import numpy as np
import pandas
from asperity.tools.tables import markdown

from .common import DATA, rows
from .wall_costs import two_digits
from .wall_runs import BUILD, start

STEP = "--tau 0.02 --elements 4 2 3 --press 1 --step 0.02 --to 0.02 --tolerance 1e-5"
"""A wall in three dimensions, pressed and moved by one step."""

SOLVERS = {
    "LU": "",
    "Cholesky": "--always",
    "CG, gamg": "--always --petsc='-pc_type gamg'",
    "FGMRES, gamg": "--petsc='-pc_type gamg'",
}
"""Options by solver; Newton's method has LU and FGMRES, passes have Cholesky and conjugate gradients."""

FACTORED = "LU", "Cholesky"

SIZES = {
    (1, 1): tuple(SOLVERS),
    (1, 2): FACTORED,
    (2, 1): ("LU", "Cholesky", "CG, gamg"),
    (4, 1): ("LU", "CG, gamg"),
    (6, 1): ("LU", "CG, gamg"),
}
"""Solvers by so many times the half-bricks and courses, and by the ranks."""

GROWN = 4, 6
"""Sizes from which the growth is taken."""

CRACKED = (
    "--tau 0.02 --elements 4 2 3 --press 1 --step 0.1 --most 0.1 --to 0.6 --tolerance 1e-5 "
    "--theta 10 --height 0.1"
)
"""The smallest wall with planes in its joints, until it is cracked."""

LOOSE = "--wall SW30 --elements 2 2 --step 0.1 --most 0.5 --to 2 --tolerance 1e-5"
"""A dry wall in two dimensions, whose blocks come loose."""

HARDER = {
    "cracked": ("J4D in 3D, rough, 0.6 mm", CRACKED, ("Cholesky", "CG, gamg")),
    "loose": ("SW30 in 2D, dry, 2 mm", LOOSE, ("LU", "FGMRES, gamg")),
}
"""Label, options and solvers, by MUMPS and gamg, of walls with more than a step; "loose" has passes, too."""

RUNS = {
    **{
        (str(k), ranks, solver): f"{STEP} --scale {k}"
        for (k, ranks), names in SIZES.items()
        for solver in names
    },
    **{(name, 1, solver): words for name, (_, words, solvers) in HARDER.items() for solver in solvers},
}
"""Options without those of the solver, by size, ranks and solver."""

COLUMNS = (
    *("unknowns", "ranks", "steps", "e_t", "iterations", "linear", "moving", "memory", "peak", "dissipated"),
    "entries",
)
"""What is stored of a run, of those names in its summary."""


def execute() -> None:
    """Run the walls that are not in build/walls, and store the rows of all."""
    folder, lines = BUILD / "walls", []
    folder.mkdir(parents=True, exist_ok=True)
    for (size, ranks, solver), words in RUNS.items():
        name = f"scale {size} {solver} {ranks}"
        done = folder / f"{name.replace(', ', '-').replace(' ', '-')}.json"
        if not done.exists():
            end = start(f"{words} {SOLVERS[solver]}", ranks=ranks)
            if end.returncode != 0:
                raise RuntimeError(f"{name}: exit {end.returncode}: {end.stderr}")
            done.write_text(end.stdout, encoding="utf-8")
            print(f"{name}: {end.stdout.strip()}", flush=True)
        summary = json.loads(done.read_text(encoding="utf-8"))
        lines.append({"size": size, "solver": solver, **{column: summary[column] for column in COLUMNS}})
    heading = "# Made by python -m harness.studies.validation.walls --fit\n"
    table = pandas.DataFrame(lines).to_csv(index=False, float_format="%.12g")
    (DATA / "walls_scale.csv").write_text(heading + table, encoding="utf-8")


def stored() -> pandas.DataFrame:
    """Stored rows, by size, ranks and solver."""
    return rows("walls_scale").set_index(["size", "ranks", "solver"]).sort_index()


def of_iteration(run: pandas.Series) -> str:
    """Processor seconds of an iteration of Newton's method, GB, linear iterations in it where they count."""
    cells = [two_digits(run.moving / run.iterations), two_digits(run.memory)]
    counts = [] if run.entries else [f"{run.linear / run.iterations:.0f}"]
    return ", ".join(cells + counts)


def costs() -> str:
    """Table of the costs of an iteration by solver, unknowns and ranks."""
    runs, body = stored(), []
    for (k, ranks), solvers in SIZES.items():
        of_size = runs.loc[str(k), ranks]
        cells = [of_iteration(of_size.loc[name]) if name in solvers else "" for name in SOLVERS]
        body.append([f"{of_size.unknowns.iloc[0]:.0f}", str(ranks), *cells])
    return markdown(["unknowns", "ranks", *SOLVERS], body)


def power(runs: pandas.DataFrame, values: pandas.Series) -> float:
    """Exponent with which values grow with the unknowns, from one of two sizes to the other."""
    return float(
        np.log(values.iloc[1] / values.iloc[0]) / np.log(runs.unknowns.iloc[1] / runs.unknowns.iloc[0])
    )


def growth() -> str:
    """Table of what grows how, on one rank, and of the force on the wall against that by LU."""
    runs, body = stored(), []
    largest = max(GROWN)
    for name in SIZES[largest, 1]:
        pair = runs.loc[[(str(k), 1, name) for k in GROWN]]
        powers = (power(pair, values) for values in (pair.memory, pair.moving / pair.iterations))
        per_unknown = 1e6 * pair.memory / pair.unknowns
        off = max(
            abs(run.peak / runs.loc[size, 1, "LU"].peak - 1.0)
            for (size, _, solver), run in runs.drop([*HARDER]).iterrows()
            if solver == name and (size, 1, "LU") in runs.index
        )
        body.append(
            [
                name,
                f"{per_unknown.iloc[1]:.1f}",
                *(f"{value:.2f}" for value in powers),
                f"{off:.0e}" if off else "",
            ]
        )
    head = ["solver", "kB of an unknown", "power of memory", "power of time", "force, off by"]
    return markdown(head, body)


def iterations() -> str:
    """Table of the iterations where joints are cracked and where blocks come loose."""
    runs, body = stored(), []
    for size, (label, _, solvers) in HARDER.items():
        direct, iterative = (runs.loc[size, 1, name] for name in solvers)
        counts = [f"{run.iterations:.0f}" for run in (direct, iterative)]
        off = abs(iterative.peak / direct.peak - 1.0)
        each = f"{iterative.linear / iterative.iterations:.0f}"
        body.append([label, f"{direct.unknowns:.0f}", *counts, each, f"{off:.0e}"])
    head = ["wall", "unknowns", "iterations, MUMPS", "gamg", "linear iterations of one", "force, off by"]
    return markdown(head, body)
