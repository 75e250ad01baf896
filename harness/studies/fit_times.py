"""Processor time of `asperity fit`: `python -m harness.studies.fit_times --write 4`.

Files are drawn from laws that are not that of asperity, and fitted by the command in this process, after its
imports: three tests of 300 rows, a test with cycles and 800 rows, a table of strengths.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pandas
from asperity.cli import main as asperity
from asperity.tools.tables import markdown

from . import other_laws, other_strengths
from .other_laws import Drawn
from .program import program
from .tables import refreshed

DATA = Path(__file__).parent / "validation" / "data" / "fit_times.csv"
PAGE = Path(__file__).parents[2] / "docs" / "validation" / "fits.md"
"""Times of each file, and the page."""

TESTS, ROWS, CYCLIC = 3, 300, 800
"""Tests of a file and their rows; rows of the test with cycles."""


Draw = Callable[[np.random.Generator], pandas.DataFrame]
"""Function that draws a file."""


def curves(law: Callable[..., Drawn], count: int, length: int) -> Draw:
    """Function that draws the file of tests of a law."""

    def drawn(rng: np.random.Generator) -> pandas.DataFrame:
        frames = []
        for number, test in enumerate(law(rng, count, length).tests, 1):
            columns = {"test": number, "slip [mm]": test.slip, "tau [MPa]": test.tau}
            columns |= {"sigma_N [MPa]": test.pressure, "k_N [MPa/mm]": test.k_N}
            columns |= {} if test.dilation is None else {"dilation [mm]": test.dilation}
            frames.append(pandas.DataFrame(columns))
        return pandas.concat(frames)

    return drawn


def _without_dilation(rng: np.random.Generator, count: int, length: int) -> Drawn:
    return other_laws.without_dilation(rng, partial(other_laws.mohr_coulomb, count=count, length=length))


def strengths(rng: np.random.Generator) -> pandas.DataFrame:
    """File of a table of strengths."""
    criteria = [name for name in other_strengths.STRENGTHS if not name.endswith("nonsense")]
    table = other_strengths.STRENGTHS[str(rng.choice(criteria))](rng)
    columns = {"sigma_N [MPa]": table.pressure, "peak [MPa]": table.peak}
    return pandas.DataFrame(columns | ({} if table.residual is None else {"residual [MPa]": table.residual}))


FILES: dict[str, tuple[float, Draw]] = {
    "Mohr-Coulomb": (1.5, curves(other_laws.mohr_coulomb, TESTS, ROWS)),
    "dilation not measured": (1.5, curves(_without_dilation, TESTS, ROWS)),
    "cohesion": (1.5, curves(other_laws.cohesion, TESTS, ROWS)),
    "Barton-Bandis": (4.0, curves(other_laws.barton_bandis, TESTS, ROWS)),
    "Plesha, cycles": (5.0, curves(other_laws.plesha, 1, CYCLIC)),
    "strengths": (0.2, strengths),
}
"""Target, s, and files by law."""


def seconds(frame: pandas.DataFrame) -> float:
    """Processor time of the command for one file."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = Path(folder) / "tests.csv"
        frame.to_csv(path, index=False, float_format="%.6g")
        begin = time.process_time()
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            asperity(["fit", str(path)])
        return time.process_time() - begin


def measured(count: int, seed: int) -> pandas.DataFrame:
    """Times of so many files of each law."""
    seconds(strengths(np.random.default_rng(seed)))  # with the imports
    rows = []
    for place, (law, (_, drawn)) in enumerate(FILES.items()):
        for number in range(count):
            frame = drawn(np.random.default_rng([seed, place, number]))
            rows.append({"law": law, "seed": seed, "rows": len(frame), "cpu": seconds(frame)})
    return pandas.DataFrame(rows)


def table(rows: pandas.DataFrame) -> str:
    """Times by law, and the targets."""
    lines = []
    for law, part in rows.groupby("law", sort=False):
        ends = sorted({part["rows"].min(), part["rows"].max()})
        times = f"{part.cpu.median():.2f} / {part.cpu.max():.2f}"
        target = f"{FILES[str(law)][0]:g}"
        lines.append([str(law), str(len(part)), " to ".join(map(str, ends)), times, target])
    return markdown(["tests by", "files", "rows", "CPU, median / largest, s", "target, s"], lines)


def _write(options: argparse.Namespace) -> int:
    """Measure, if asked for, and fill the page."""
    if options.write:
        measured(options.write, options.seed).to_csv(DATA, index=False, float_format="%.4g")
    rows = pandas.read_csv(DATA)
    return refreshed(PAGE, options.check, {"fits-times": lambda: table(rows)})


main = program(
    _write,
    ("--write FILES", "draw and fit this many files of each law; else use the times of the last run", 0),
    ("--seed SEED", "of the files", 0),
    ("--check", "write nothing; exit with 1 if the page differs"),
)

if __name__ == "__main__":
    sys.exit(main())
