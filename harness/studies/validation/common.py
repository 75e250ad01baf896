"""What the comparisons share: data, joints, least squares, tables of a page and the program."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas
from asperity.contract import Floats
from asperity.interface import Interface
from asperity.material import Material
from asperity.pattern import Pattern
from asperity.tools.fit import Fit
from asperity.tools.fit.closures import ClosureFit
from asperity.tools.fit.model import from_scale, plausible, to_scale
from asperity.tools.fit.search import least
from asperity.tools.fit.strengths import StrengthFit
from asperity.tools.style import printed, save
from matplotlib.figure import Figure

from ..program import DIFFERS, program
from ..tables import refresh

DATA = Path(__file__).parent / "data"
DOCS = Path(__file__).parents[3] / "docs"

ETA, KC = 0.9, 100.0
"""Shape of the softening and stiffness of the contact of a joint with a bond."""

LOST = 10.0
"""Residual of a path on which the equilibrium is lost."""

Constants = dict[str, float]
"""Constants of a joint by name."""


def rows(name: str, **options: object) -> pandas.DataFrame:
    """Rows of a file of the folder `data`, without its comments; options: of pandas.read_csv."""
    return pandas.read_csv(DATA / f"{name}.csv", comment="#", **options)


def joint(constants: Mapping[str, float]) -> Interface:
    """Joint of two slopes and a flat plane of weight `flat`; without sigma0 it has no bond."""
    values = dict(constants)
    pattern = Pattern.regular(2, values.pop("theta"), flat=values.pop("flat", 0.0))
    if "sigma0" in values:
        return Interface(Material(eta=ETA, kc=KC, **values), pattern)
    return Interface(Material.from_joint(**values), pattern)


def rms(difference: Floats) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(difference))))


def fitted(
    residuals: Callable[[Constants], Floats],
    starts: Sequence[Mapping[str, float]],
    size: tuple[float, float],
    fixed: Mapping[str, float] | None = None,
    step: float = 1e-3,
    ends: Mapping[str, tuple[float, float]] | None = None,
) -> Constants:
    """Constants of the smallest sum of squares from all starts, rounded to four digits, and the fixed ones.

    size: largest stress, MPa, and length, mm, of the tests, for the plausible ranges of the constants, which
    those of `ends` replace.  step: of the differences.
    """
    names = list(starts[0])
    bounds = {name: plausible(name, *size) for name in names} | dict(ends or {})
    low_high = np.transpose([to_scale(name, bounds[name]) for name in names])

    def named(x: Floats) -> Constants:
        pairs = zip(names, x, strict=True)
        return dict(fixed or {}) | {name: float(from_scale(name, scaled)) for name, scaled in pairs}

    points = [np.array([float(to_scale(name, start[name])) for name in names]) for start in starts]
    results = [least(lambda x: residuals(named(x)), point, low_high, step=step) for point in points]
    best = min(results, key=lambda solution: float(solution[1] @ solution[1]))
    return {name: float(f"{value:.4g}") for name, value in named(best[0]).items()}


def by_product(outcome: Fit | StrengthFit | ClosureFit) -> Constants:
    """What `asperity fit` finds: constants with the ends of their intervals, errors, and exit code.

    Errors are named as "error blind peak".
    """
    values = {name: outcome.values[name] for name in outcome.estimates}
    ends = {
        f"{name}_{end}": getattr(estimate, end)
        for name, estimate in outcome.estimates.items()
        for end in ("low", "high")
    }
    errors = {f"error {name}": error for name, error in outcome.errors.items()}
    return values | ends | errors | {"code": 0.0 if outcome.is_result else 3.0}


def of_product(constants: Mapping[str, float], names: Sequence[str], errors: Sequence[str]) -> list[str]:
    """Cells of a table: constants with their intervals, errors in percent, blind ones bold, and exit code."""
    shown = [f"{name} {constants[name]:.3g} [{constants[f'{name}_low']:.3g}, {constants[f'{name}_high']:.3g}]"
             for name in names if name in constants]  # fmt: skip
    cells = []
    for name in errors:
        error = f"{100.0 * constants[f'error {name}']:.1f}" if f"error {name}" in constants else ""
        cells.append(f"**{error}**" if error and name.startswith("blind") else error)
    return [", ".join(shown), *cells, f"{constants['code']:.0f}"]


@dataclass(frozen=True)
class Study:
    """A comparison: fits by their names (none: it stores what it needs), tables and picture of its page."""

    name: str
    fit: Callable[[], dict[str, Constants]]
    tables: Callable[[Mapping[str, Constants]], dict[str, str]]
    draw: Callable[[Mapping[str, Constants]], Figure]

    @property
    def page(self) -> Path:
        """Page with the tables."""
        return DOCS / "validation" / f"{self.name}.md"

    @property
    def picture(self) -> Path:
        """File of the picture."""
        return DOCS / "images" / f"validation_{self.name}.png"

    def constants(self) -> dict[str, Constants]:
        """Constants that the fits have found, from the folder `data`; none if there are no fits."""
        if not self._constants_file.exists():
            return {}
        table = rows(f"{self.name}_constants").set_index("fit").astype(float)
        return {fit: row.dropna().to_dict() for fit, row in table.iterrows()}

    @property
    def _constants_file(self) -> Path:
        return DATA / f"{self.name}_constants.csv"

    def write_constants(self) -> None:
        """Fit, and write what is found to the folder `data`; nothing if there are no fits."""
        results = self.fit()
        if not results:
            return
        heading = f"# Found by python -m harness.studies.validation.{self.name.replace('-', '_')} --fit\n"
        table = pandas.DataFrame([{"fit": fit} | constants for fit, constants in results.items()])
        self._constants_file.write_text(
            heading + table.to_csv(index=False, float_format="%g"), encoding="utf-8"
        )

    def main(self, arguments: Sequence[str] | None = None) -> int:
        """Run the program."""
        fit = ("--fit", "repeat the fits or runs; else use what they found")
        check = ("--check", "write nothing; exit with 1 if the page differs")
        return program(self._action, fit, check)(arguments)

    def _action(self, options: argparse.Namespace) -> int:
        """Fill the page and draw its picture, or check the page."""
        if options.fit and not options.check:
            self.write_constants()
        same = refresh(self.page, options.check, self.tables(self.constants()))
        if options.check:
            print(f"{self.page}: {'up to date' if same else 'not up to date'}")
            return 0 if same else DIFFERS
        with printed():
            save(self.draw(self.constants()), self.picture)
        print(self.page, self.picture, sep="\n")
        return 0
