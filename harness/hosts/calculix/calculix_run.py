"""Runs of CalculiX with the UMAT of libasperity: parts of the input, the run, and its output."""

from __future__ import annotations

import argparse
import os
import re
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from asperity.contract import Floats
from numpy.typing import ArrayLike

DIVERGED = 201
"""Exit code of ccx for an error, such as an increment below its limit."""

DIGITS = 5.0e-7
"""Relative rounding error of the seven digits in a .dat file."""

STATES = "initial_state.txt"
"""File of initial state variables, read by sdvini.f90."""

N, TX, TY = 2, 4, 5
"""Positions of the components among 11, 22, 33, 12, 13, 23 (PROPS map 0)."""


@dataclass(frozen=True)
class Run:
    """Results of a run: output, errors, tables of the .dat file by heading.

    iterations: of every increment that converged; attempts: number of all attempted increments.
    """

    output: str
    errors: str
    tables: dict[str, list[tuple[float, Floats]]]
    iterations: list[int]
    attempts: int
    data: bytes

    def table(self, start: str) -> tuple[Floats, Floats]:
        """Times (T,) and rows (T, rows, columns) of the table whose heading begins with a text."""
        (name,) = [name for name in self.tables if name.startswith(start)]
        times, rows = zip(*self.tables[name], strict=True)
        return np.array(times), np.array(rows)

    def vectors(self, start: str) -> Floats:
        """N, Tx, Ty (T, points, 3) of a table of stresses, or of strains, whose shears are halves."""
        return self.table(start)[1][:, :, 2:][..., [N, TX, TY]]

    def state(self, elset: str) -> Floats:
        """State variables of the points of a set (T, points, nstatv)."""
        return self.table(f"{elset} internal")[1][:, :, 2:]


def program_file(text: str) -> Path:
    """Path of a program, for argparse."""
    path = Path(text).resolve()
    if not path.is_file():
        raise argparse.ArgumentTypeError(f"{path}: expected a ccx linked with libasperity, by link.sh")
    return path


def run(program: Path, folder: Path, text: str, threads: int = 1, code: int = 0) -> Run:
    """Write an input and run it, with one thread in the equation solver for reproducible sums.

    Raises RuntimeError for another exit code, ValueError if rows of `write_states` are for points that the
    model does not have.
    """
    (folder / "job.inp").write_text(text)
    for old in ("job.dat", "job.sta"):
        (folder / old).unlink(missing_ok=True)
    environment = os.environ | {
        "OMP_NUM_THREADS": str(threads), "CCX_NPROC_RESULTS": str(threads),
        "CCX_NPROC_STIFFNESS": str(threads), "CCX_NPROC_EQUATION_SOLVER": "1",
    }  # fmt: skip
    done = subprocess.run(
        [program, "job"], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    if done.returncode != code:
        raise RuntimeError(f"ccx ended with {done.returncode}:\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}")
    asked = re.search(r"^\*INITIAL CONDITIONS, *TYPE=SOLUTION, *USER", text, re.MULTILINE | re.IGNORECASE)
    if asked and code == 0 and f"{STATES}: every row has found its point" not in done.stdout:
        raise ValueError(
            f"{folder / STATES}: rows are left over: expected points of elements of the model, "
            f"and a program of link.sh, here {program}"
        )
    data, status = folder / "job.dat", folder / "job.sta"
    rows = [line.split() for line in status.read_text().splitlines()] if status.is_file() else []
    attempts = [row for row in rows if row and row[0].isdigit()]
    converged = [row for row in attempts if not row[2].endswith("U")]  # A U marks a failed attempt.
    iterations = [int(row[3]) for row in converged]
    content = data.read_bytes() if data.is_file() else b""
    return Run(done.stdout, done.stderr, _tables(content.decode()), iterations, len(attempts), content)


def _tables(text: str) -> dict[str, list[tuple[float, Floats]]]:
    """Tables of a .dat file: heading (components) for set X and time T, an empty line, rows of numbers."""
    tables: dict[str, list[tuple[float, Floats]]] = {}
    pieces = re.split(r"^ (\S.*) for set (\S+) and time +(\S+)\n\n", text, flags=re.MULTILINE)
    for heading, name, time, body in zip(*(pieces[i::4] for i in range(1, 5)), strict=True):
        rows = [line.split() for line in body.splitlines() if line.strip()]
        # the name of an orientation may follow the numbers
        table = np.array([[_number(cell) for cell in row if not cell[0].isalpha()] for row in rows])
        tables.setdefault(f"{name} {heading}", []).append((float(time), table))
    return tables


def _number(text: str) -> float:
    """Number from Fortran output, which leaves out the E of an exponent of three digits."""
    try:
        return float(text)
    except ValueError:
        return float(re.sub(r"(?<=\d)([+-]\d{3})$", r"E\1", text))


def nset(name: str, members: ArrayLike) -> str:
    """Set of the nodes of a mask."""
    return f"*NSET, NSET={name}\n" + "".join(f"{node},\n" for node in np.flatnonzero(members) + 1)


def write_states(folder: Path, states: Mapping[tuple[int, int], Floats]) -> None:
    """Initial state variables by element and integration point, for TYPE=SOLUTION, USER (sdvini.f90)."""
    rows = (f"{e} {p} {' '.join(map(repr, state.tolist()))}\n" for (e, p), state in sorted(states.items()))
    (folder / STATES).write_text("".join(rows))
