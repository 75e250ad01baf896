"""Errors and times of structures over the pattern: rows for `python -m harness.studies.structures`.

The Kratos triplet, the OpenGeoSys block and the explicit block run with slip up a plane and half-way between
two planes.  The first two need gcc, which compiles timed_law.c.
"""

from __future__ import annotations

import argparse
import ctypes
import resource
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from asperity import Interface, ModelWarning
from asperity.installed import generic_library, kratos_adapter
from numpy.typing import NDArray

from harness.studies import structures
from harness.studies.structures import FINEST, PRESSURE, REFERENCE, SLIP, TURNS, Row

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent / "kratos"), str(HERE.parent / "ogs")]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Run:
    """Force and rise over the path, processor time of the run and of the law in it."""

    force: Floats
    rise: Floats
    seconds: float
    law: float


def timed_library(of: Path, folder: Path, *options: str) -> Path:
    """Library that measures the time of another library, which hosts load in its place."""
    out = folder / f"timed_{of.name}"
    command = ["gcc", "-O2", "-shared", "-fPIC", *options, "-o", out, HERE / "timed_law.c"]
    subprocess.run([*command, "-Wl,--no-as-needed", of, f"-Wl,-rpath,{of.parent}"], check=True)
    return out


def kratos(folder: Path) -> Callable[[Interface], Run]:
    """Masonry triplet, slip forward and back."""
    import triplet

    library = timed_library(kratos_adapter(), folder, "-DHOST_UMAT")
    timed = ctypes.CDLL(str(library))
    timed.law_seconds.restype = ctypes.c_double

    def run(law: Interface) -> Run:
        timed.law_seconds()
        cpu, wall = time.process_time(), time.perf_counter()
        found = triplet.run(TURNS["Kratos triplet"], 0.01, law=law, UDSM_NAME=str(library))
        cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
        after = slice(triplet.PRELOAD_STEPS, None)
        rise = found.rise[after] - found.rise[triplet.PRELOAD_STEPS - 1]
        return Run(found.force[after], rise, cpu, timed.law_seconds() * cpu / wall)

    return run


def opengeosys(folder: Path) -> Callable[[Interface], Run]:
    """Block with two joints in three dimensions, slip oblique to the axes."""
    import ogs_block

    library = timed_library(generic_library(), folder)

    def run(law: Interface) -> Run:
        before, wall = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        found = ogs_block.run(folder, law=law, library=library)
        wall, after = time.perf_counter() - wall, resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        (line,) = [text for text in found.run.output.splitlines() if text.startswith("law: ")]
        return Run(found.force[1:, 0], found.rise[1:], cpu, float(line.split()[1]) * cpu / wall)

    return run


def explicit(folder: Path) -> Callable[[Interface], Run]:
    """Block on a rough base by central differences."""
    import explicit_block

    def run(law: Interface) -> Run:
        found = explicit_block.run(law, PRESSURE, SLIP)
        return Run(found.force, found.rise, found.seconds, found.law_seconds)

    return run


STUDIES = {"Kratos triplet": kratos, "OpenGeoSys block": opengeosys, "explicit block": explicit}
DIRECTIONS = {"Kratos triplet": 0.0, "OpenGeoSys block": 20.0, "explicit block": 20.0}
"""Direction of the slip of each structure, degrees from Tx."""


def study(name: str, folder: Path, sides: list[int]) -> list[Row]:
    """Rows of a structure."""
    run, direction = STUDIES[name](folder), DIRECTIONS[name]

    def both(n: int) -> list[Run]:
        laws = [structures.interface_of(n, direction, between) for between in (False, True)]
        print(f"{name}: {structures.name_of(n)}", file=sys.stderr, flush=True)
        return [run(law) for law in laws[: 2 if n else 1]]

    finest = both(FINEST.get(name, REFERENCE))
    force, rise = (np.mean([getattr(one, part) for one in finest], axis=0) for part in ("force", "rise"))
    rows = []
    for n in sides:
        runs = both(n)
        errors = [max(_distance(getattr(one, part), of) for one in runs)
                  for part, of in (("force", force), ("rise", rise))]  # fmt: skip
        times = [float(np.mean([getattr(one, part) for one in runs])) for part in ("seconds", "law")]
        rows.append(Row(name, n, *errors, *times))
    spread = [_distance(finest[0].force, force), _distance(finest[0].rise, rise)]
    print(f"{name}: reference good to {spread[0]:.1e} (force), {spread[1]:.1e} (rise)", file=sys.stderr)
    return rows


def _distance(values: Floats, of: Floats) -> float:
    """L2 norm of a difference over that of the reference."""
    return float(np.linalg.norm(values - of) / np.linalg.norm(of))


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="Errors and times of structures over the pattern.")
    parser.add_argument("-o", "--output", type=Path, default=Path("structures.csv"), metavar="FILE.csv")
    parser.add_argument("--only", choices=tuple(STUDIES), help="one structure")
    options = parser.parse_args()
    warnings.simplefilter("ignore", ModelWarning)  # the contact of a few planes is soft in all of them
    rows = []
    for name in STUDIES if options.only is None else [options.only]:
        with tempfile.TemporaryDirectory() as folder:
            rows += study(name, Path(folder), structures.sides_of(name))
        structures.write_rows(options.output, rows)
    print(options.output)


if __name__ == "__main__":
    main()
