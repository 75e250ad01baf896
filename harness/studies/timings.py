"""Timings of the benchmark."""

from __future__ import annotations

import os
import subprocess
import tempfile
from pathlib import Path

import pandas

BUILDS = [Path(__file__).parents[2] / "build" / name / "bin" / "bench" for name in ("release", "suites")]
BENCH = next((path for path in BUILDS if path.exists()), BUILDS[0])
"""The benchmark, built by `make build` or with the Python package."""

COLUMNS = {
    "pattern": str, "planes": int, "kernel": str, "precision": str, "tangent": bool,
    "ns_per_point": float, "isa": int,
}  # fmt: skip
"""Columns of the benchmark, a row for a kernel on a pattern.

isa: level of x86-64 of the kernels, 3 or 1; 0: the library has one set of kernels.
"""


def read_timings(path: Path) -> pandas.DataFrame:
    """Rows of a CSV of the benchmark; raises ValueError for another file."""
    try:
        found = pandas.read_csv(
            path,
            usecols=[*COLUMNS],
            dtype=COLUMNS,
            true_values=["yes"],
            false_values=["no"],
            skipinitialspace=True,
        )
        if found.empty:
            raise ValueError("no rows")
    except ValueError as error:
        raise ValueError(f"{path}: expected a CSV written by bench --csv ({error})") from error
    return found


def measure(*options: str, level: str = "v3") -> pandas.DataFrame:
    """Run the benchmark, which prints its table, and return its rows; level: the kernels, "v3" or "v1"."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "bench.csv")
        environment = os.environ | {"ASPERITY_ISA": level}
        done = subprocess.run([BENCH, "--csv", path, *options], check=False, env=environment)
        if done.returncode != 0:
            raise ValueError(f"{BENCH}: exit code {done.returncode}: expected 0")
        return read_timings(path)
