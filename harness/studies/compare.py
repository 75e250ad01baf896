"""Compare the driver with the NumPy reference, on the cases of the figures of the paper."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from asperity import contract
from asperity.case_files import SlipTest, drive, read_case, slip_tests
from asperity.contract import Floats
from asperity.history import ENERGIES, History
from asperity.installed import all_cases
from asperity.material import Material
from asperity.options import add_options
from tqdm import tqdm

from tests.oracle import reference

from .newton import work_along
from .program import DIFFERS, run

LAW_TOLERANCE = 1.0e-12
"""Accepted difference along given separations, in the scales of `Difference`; sums have rounding errors."""

TEST_TOLERANCE = 1.0e-10
"""Accepted difference if each implementation solves for s_N: its residual over the smallest slope."""

OPENING_TOLERANCE = 1.0e-9
"""Accepted difference of a computed s_N; it is large because t_N hardly depends on s_N near a loss."""


class Difference(NamedTuple):
    """Largest differences over rows and curves, each relative to a scale that grows along the history.

    The scales are, with |s| the largest separation so far: traction: K |s|; opening (s_N): |s|; damage: 1;
    energy (largest difference of stored, rupture, friction and work): K |s| times the length of the path.
    """

    traction: float
    opening: float
    damage: float
    energy: float


@dataclass(frozen=True)
class Comparison:
    """Largest differences of the driver on a case by kind of comparison, such as "law/NumPy".

    law: along the driver's separations.  test: each implementation follows the equilibrium itself.
    """

    case: str
    curves: int
    rows: int
    differences: Mapping[str, Difference]

    @property
    def agrees(self) -> bool:
        """Whether there is a comparison and every difference is within its tolerance."""
        return bool(self.rows > 0 and self.differences) and all(
            within(name, found) for name, found in self.differences.items()
        )


def within(name: str, difference: Difference) -> bool:
    """Whether a difference is within the tolerance of its kind; NaN is not."""
    if name.startswith("law"):
        tolerances = Difference(*(4 * [LAW_TOLERANCE]))
    else:
        tolerances = Difference(*(4 * [TEST_TOLERANCE]))._replace(opening=OPENING_TOLERANCE)
    return all(value <= most for value, most in zip(difference, tolerances, strict=True))


def find(figure: str) -> list[Path]:
    """Cases of a figure, such as "5b" or "5"; raises ValueError for a figure without cases."""
    known = {path: _figures(path) for path in cases()}
    wanted = figure.strip().lower()
    found = [
        path for path, names in known.items() if wanted in names or wanted in (n.rstrip("ab") for n in names)
    ]
    if not found:
        names = dict.fromkeys(name for names in known.values() for name in names)
        raise ValueError(f"figure {figure}: expected one of {', '.join(names)}")
    return found


def cases() -> list[Path]:
    """Case files of the figures."""
    return [path for name, path in all_cases().items() if name.startswith("figure")]


def _figures(path: Path) -> list[str]:
    """Figures in a name such as figure09a_10b; a later number without letter is no figure (figure13a_45)."""
    first, *others = path.stem.removeprefix("figure").split("_")
    return [name.lstrip("0") for name in [first, *others] if name == first or not name.isdigit()]


def compare(case: Path) -> Comparison:
    """Run a case by the driver and compare; raises ValueError with the driver's message if it fails."""
    results = drive(case)
    differences: dict[str, Difference] = {}
    curves = rows = 0
    for test in slip_tests(read_case(case)):
        curves += 1
        rows += len(results[test.value])
        for name, found in _differences(test, results[test.value]):
            worst = differences.get(name, found)
            differences[name] = Difference(*np.maximum(worst, found).tolist())  # np.maximum propagates NaN
    return Comparison(case.stem, curves, rows, differences)


class _Curve(NamedTuple):
    """Compared quantities: separation and traction (T, 2 or 3), damage (T,), energies (T, 4)."""

    separation: Floats
    traction: Floats
    damage: Floats
    energies: Floats

    def some(self, rows: slice) -> _Curve:
        return _Curve(*(values[rows] for values in self))


def parameters_of(material: Material) -> reference.Parameters:
    """Constants of a material for the reference; raises ValueError for a constant that it does not have."""
    values = material.values() | {"kc": material.kc or contract.default("kc")}
    known = {field.name for field in fields(reference.Parameters)}
    beyond = [name for name in values if name not in known and values[name] != contract.default(name)]
    if beyond:
        raise ValueError(f"{', '.join(beyond)}: expected constants that the reference knows")
    return reference.Parameters(**{name: value for name, value in values.items() if name in known})


def _differences(test: SlipTest, rows: History) -> Iterator[tuple[str, Difference]]:
    """Compare law and test with the reference."""
    m, p = test.material, test.pattern
    if m.tau_v > 0.0 or m.guard:
        raise ValueError("tau_v, guard: expected a case without viscous damage and without the guard")
    parameters = parameters_of(m)
    pattern = reference.regular_pattern(p.m, p.theta, p.flat, p.turn)
    # The last row of a lost equilibrium lies within an increment.
    whole = len(rows) - rows.lost
    if any("substeps" in event for row, event in rows.events if row < whole):
        raise ValueError("an increment was solved in sub-increments: expected a case with smaller increments")
    energies = np.column_stack([getattr(rows, name) for name in ENERGIES])
    ours = _Curve(rows.separation, rows.traction, rows.damage, energies).some(slice(whole))
    slipping = slice(test.preload, whole)
    preload = max(test.preload, 1)
    s = ours.separation

    law = reference.replay(parameters, pattern, s)
    theirs = _Curve(s, law.traction, law.state[:, 0], _energies(law.state, work_along(s, law.traction)))
    yield "law/NumPy", _difference(parameters, ours, theirs, slice(None))
    if len(test.slips) > 0:
        path = test.direction, test.slips, test.sigma_N, preload
        history = reference.confined_slip(parameters, pattern, *path)
        energies = _energies(history.state, history.work)
        solved = _Curve(history.separation, history.traction, history.damage, energies)
        solved = solved.some(slice(int(np.isfinite(solved.damage).sum())))
        yield "test/NumPy", _difference(parameters, ours, solved, slipping)


def _energies(state: Floats, work: Floats) -> Floats:
    """Energies (T, 4) of the columns of a result."""
    return np.column_stack([*(state[:, contract.statev_index(name)] for name in ENERGIES[:-1]), work])


def _difference(parameters: reference.Parameters, ours: _Curve, theirs: _Curve, rows: slice) -> Difference:
    """Largest differences of some rows of `ours` from `theirs`, in the scales of all rows of `ours`."""
    largest = np.maximum.accumulate(np.linalg.norm(ours.separation, axis=1))
    steps = np.diff(ours.separation, axis=0, prepend=0.0)
    path = np.cumsum(np.linalg.norm(steps, axis=1))[rows]
    largest, ours = largest[rows], ours.some(rows)
    if len(ours.damage) != len(theirs.damage):  # the two lose equilibrium in different rows
        return Difference(*(4 * [math.inf]))
    stiffest = max(parameters.Kn, parameters.Kt) * max(1.0, parameters.kc)
    return Difference(
        _largest(ours.traction - theirs.traction, stiffest * largest),
        _largest(ours.separation[:, :1] - theirs.separation[:, :1], largest),
        float(np.abs(ours.damage - theirs.damage).max()),
        _largest(ours.energies - theirs.energies, stiffest * largest * path),
    )


def _largest(difference: Floats, scale: Floats) -> float:
    """Largest ratio of rows (T, n) to a scale (T,); rows with the scale 0 are not divided."""
    size = np.abs(difference).max(axis=1)
    return float(np.divide(size, scale, out=size.copy(), where=scale > 0.0).max())


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the program."""
    add_options(parser, ("--figure NUMBER", "figure of the paper; may be repeated (default: all)", list))
    parser.set_defaults(action=_compare)


def _compare(options: argparse.Namespace) -> int:
    """Print a line for each case and each kind of comparison."""
    wanted = [path for figure in options.figure for path in find(figure)] if options.figure else cases()
    print("Largest difference between the driver and the NumPy reference, relative:")
    print("traction to K |s|, s_N to |s|, damage to 1, energies to K |s| times the length of the path")
    print(f"  law: along the driver's separations, tolerance {LAW_TOLERANCE:.0e}")
    followed = f"tolerance {TEST_TOLERANCE:.0e}, of s_N {OPENING_TOLERANCE:.0e}"
    print(f"  test: each follows the equilibrium itself, {followed}")
    head = ("traction", "s_N", "damage", "energies")
    print(f"{'case':<20}{'curves':>7}{'rows':>7}  {'against':<10}" + "".join(f"{name:>10}" for name in head))
    agree = True
    for path in tqdm(dict.fromkeys(wanted), unit="case", disable=None, delay=2.0, leave=False):
        result = compare(path)
        start = f"{result.case:<20}{result.curves:>7}{result.rows:>7}"
        for name, found in result.differences.items():
            # s_N is prescribed along given separations
            texts = ("-" if name.startswith("law") and i == 1 else f"{v:.1e}" for i, v in enumerate(found))
            verdict = "agrees" if within(name, found) else "DIFFERS"
            line = f"{start}  {name:<10}" + "".join(f"{text:>10}" for text in texts)
            tqdm.write(f"{line}  {verdict}")
        agree = agree and result.agrees
    return 0 if agree else DIFFERS


main = partial(run, add_arguments)

if __name__ == "__main__":
    sys.exit(main())
