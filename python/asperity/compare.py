"""The driver against the NumPy reference and the 2D law, on the cases of the paper's figures."""

from __future__ import annotations

import math
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import planar, reference
from .case_files import SlipTest, slip_tests
from .contract import Floats
from .installed import cases, driver
from .results import Rows, read_rows, results_of

LAW_TOLERANCE = 1.0e-12
"""Difference of tractions along given separations, relative to K |s|: rounding of sums over the planes."""

TEST_TOLERANCE = 1.0e-10
"""Difference where each implementation solves for s_N itself: its residual over the smallest slope met."""


@dataclass(frozen=True)
class Comparison:
    """Largest differences on a case, relative to K |s|; NaN where there is nothing to compare with.

    law: along the driver's separations.  test: each implementation follows the equilibrium itself.  _planar:
    the 2D law, where the pattern and the slip have its plane of symmetry.
    """

    case: str
    curves: int
    rows: int
    law_reference: float
    test_reference: float
    law_planar: float
    test_planar: float

    @property
    def agrees(self) -> bool:
        """Whether every difference is within its tolerance."""
        law = np.array([self.law_reference, self.law_planar])
        test = np.array([self.test_reference, self.test_planar])
        return self.rows > 0 and not (np.any(law > LAW_TOLERANCE) or np.any(test > TEST_TOLERANCE))


def find(figure: str) -> list[Path]:
    """Cases that belong to a figure, "5b" or "5"; raises ValueError for one that has none."""
    known = {path: _figures(path) for path in cases()}
    wanted = figure.strip().lower()
    found = [
        path for path, names in known.items() if wanted in names or wanted in (n.rstrip("ab") for n in names)
    ]
    if not found:
        names = dict.fromkeys(name for names in known.values() for name in names)
        raise ValueError(f"figure {figure}: expected one of {', '.join(names)}")
    return found


def _figures(path: Path) -> list[str]:
    """Figures of figure09a_10b.nml; later parts without a letter are none, as in figure13a_45.nml."""
    first, *others = path.stem.removeprefix("figure").split("_")
    return [name.lstrip("0") for name in [first, *others] if name == first or not name.isdigit()]


def compare(case: Path) -> Comparison:
    """Run a case by the driver and compare; raises ValueError with the driver's message if it fails."""
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "out.csv"
        run = subprocess.run(
            [driver(), case, "-o", output, "--quiet"], capture_output=True, text=True, check=False
        )
        if run.returncode != 0:
            raise ValueError(run.stderr.strip())
        results = {value: read_rows(path) for value, path in results_of(output).items()}
    curves = [
        (len(rows), *_differences(test, rows)) for test in slip_tests(case) for rows in [results[test.value]]
    ]
    columns = [[v for v in column if not math.isnan(v)] for column in zip(*curves, strict=True)]
    worst = [max(column, default=math.nan) for column in columns[1:]]
    return Comparison(case.stem, len(curves), int(sum(columns[0])), *worst)


def _differences(test: SlipTest, rows: Rows) -> Iterator[float]:
    """Law and test against the reference, law and test against the 2D law."""
    m, p = test.material, test.pattern
    parameters = reference.Parameters(m.sigma0, m.Gc, m.eta, m.mu, m.sigma02, m.Gc2, m.kc)
    pattern = reference.regular_pattern(p.m, p.theta, p.flat, p.turn)
    # a lost equilibrium, which may only be the end, is a part of an increment
    whole = len(rows) - ("lost" in rows.events[-1])
    if any("substeps" in event for event in rows.events[:whole]):
        raise ValueError("an increment was solved in parts: expected a case with smaller increments")
    s, t = rows.separation[:whole], rows.traction[:whole]
    slipping = slice(test.preload, whole)

    yield _difference(parameters, s, t, reference.replay(parameters, pattern, s).traction)
    if len(test.slips) == 0:
        yield math.nan
    else:
        preload = max(test.preload, 1)
        solved = reference.confined_slip(
            parameters, pattern, test.direction, test.slips, test.sigma_N, preload
        )
        same_end = np.isfinite(solved.damage).sum() == whole - test.preload
        theirs = solved.traction[: whole - test.preload]
        yield _difference(parameters, s[slipping], t[slipping], theirs) if same_end else math.inf

    if p.m not in (0, 2) or test.direction != 0.0:
        yield from (math.nan, math.nan)
        return
    planes = [(0.0, 1.0)] if p.m == 0 else planar.trapezoid(p.theta)
    yield _difference(parameters, s, t[:, :2], np.array(planar.replay(parameters, planes, s[:, :2].tolist())))
    if len(test.slips) == 0:
        yield math.nan
        return
    slips = test.slips[: whole - test.preload].tolist()
    solved_2d = planar.confined_slip(parameters, planes, slips, test.sigma_N, max(test.preload, 1))
    yield _difference(parameters, s[slipping], t[slipping, :2], np.array(solved_2d)[:, 2:])


def _difference(parameters: reference.Parameters, separation: Floats, ours: Floats, theirs: Floats) -> float:
    """Largest difference of two histories of tractions relative to K times the largest |s| so far."""
    largest = np.maximum.accumulate(np.linalg.norm(separation, axis=1))
    scale = max(parameters.Kn, parameters.Kt) * max(1.0, parameters.kc) * largest
    difference = np.abs(ours - theirs).max(axis=1)
    return float(np.divide(difference, scale, out=difference.copy(), where=scale > 0.0).max())
