"""Timings of the benchmark that comes with the package."""

from __future__ import annotations

import csv
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from ..installed import bench


@dataclass(frozen=True)
class Timing:
    """Row of the benchmark: a kernel on a pattern, nanoseconds per point."""

    pattern: str
    planes: int
    kernel: str
    precision: str
    tangent: bool
    states: str
    ns_per_point: float


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
                )
                for row in csv.DictReader(file)
            ]
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{path}: expected a CSV written by bench --csv ({error!r})") from error
    if not timings:
        raise ValueError(f"{path}: expected rows written by bench --csv")
    return timings


def measure(*options: str, quiet: bool = False) -> list[Timing]:
    """Run the benchmark and return its rows; the benchmark prints its table unless `quiet`."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "bench.csv")
        command = [bench(), "--csv", path, *options]
        done = subprocess.run(command, check=False, stdout=subprocess.DEVNULL if quiet else None)
        if done.returncode != 0:
            raise ValueError(f"{bench()}: exit code {done.returncode}: expected 0")
        return read_timings(path)
