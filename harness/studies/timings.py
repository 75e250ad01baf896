"""Timings of the benchmark."""

from __future__ import annotations

import csv
import os
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

BUILDS = [Path(__file__).parents[2] / "build" / name / "bin" / "bench" for name in ("release", "suites")]
BENCH = next((path for path in BUILDS if path.exists()), BUILDS[0])
"""The benchmark, built by `make build` or with the Python package."""


@dataclass(frozen=True)
class Timing:
    """Row of the benchmark: a kernel on a pattern, nanoseconds per point.

    isa: level of x86-64 of the kernels, 3 or 1; 0: the library has one set of kernels.
    """

    pattern: str
    planes: int
    kernel: str
    precision: str
    tangent: bool
    states: str
    ns_per_point: float
    isa: int


def read_timings(path: Path) -> list[Timing]:
    """Rows of a CSV of the benchmark; raises ValueError for another file."""
    with path.open(encoding="utf-8", newline="") as file:
        try:
            timings = [
                Timing(
                    row["pattern"],
                    int(row["planes"]),
                    row["kernel"],
                    row["precision"],
                    {"yes": True, "no": False}[row["tangent"]],
                    row["states"],
                    float(row["ns_per_point"]),
                    int(row["isa"]),
                )
                for row in csv.DictReader(file)
            ]
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{path}: expected a CSV written by bench --csv ({error!r})") from error
    if not timings:
        raise ValueError(f"{path}: expected rows written by bench --csv")
    return timings


def measure(*options: str, level: str = "v3") -> list[Timing]:
    """Run the benchmark, which prints its table, and return its rows; level: the kernels, "v3" or "v1"."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "bench.csv")
        environment = os.environ | {"ASPERITY_ISA": level}
        done = subprocess.run([BENCH, "--csv", path, *options], check=False, env=environment)
        if done.returncode != 0:
            raise ValueError(f"{BENCH}: exit code {done.returncode}: expected 0")
        return read_timings(path)
