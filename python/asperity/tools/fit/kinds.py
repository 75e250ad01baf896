"""What a fit writes, by its kind: of curves, of strengths, or of closures."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ...interface import Interface
from .closure_report import closure_case, closure_figure, closure_report, closure_residuals
from .closures import ClosureFit
from .report import AnyFit, case_of, report, residuals_text
from .strength_report import strength_case, strength_interface, strength_report, strength_residuals
from .strengths import StrengthFit
from .verdict import Fit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Writers(NamedTuple):
    """Functions of a fit: report with units, case, joint, rows, and picture with units."""

    report: Callable[[Any, tuple[str, str], bool], str]
    case: Callable[[Any], str]
    interface: Callable[[Any], Interface]
    residuals: Callable[[Any], str]
    figure: Callable[[Any, tuple[str, str], str], Figure]


def _curves(fit: Fit, units: tuple[str, str], of_tests: str) -> Figure:
    from .picture import curves_figure

    problem = fit.solution.problem
    curves = [
        (slips[:done], tau[:done], s_N[:done])
        for (slips, _), (tau, s_N, done) in zip(problem.paths, problem.curves(fit.values), strict=True)
    ]
    return curves_figure(problem.tests, curves, units, "fit", of_tests)


def _envelope(fit: StrengthFit, units: tuple[str, str], _: str) -> Figure:
    from .picture import envelope_figure

    return envelope_figure(fit, units)


WRITERS = {
    Fit: Writers(report, case_of, lambda fit: fit.interface, residuals_text, _curves),
    StrengthFit: Writers(strength_report, strength_case, strength_interface, strength_residuals, _envelope),
    ClosureFit: Writers(
        closure_report,
        closure_case,
        lambda fit: fit.interface,
        closure_residuals,
        lambda fit, units, _: closure_figure(fit, units),
    ),
}
"""Functions by the kind of a fit."""


def report_of(fit: AnyFit, units: tuple[str, str], verbose: bool = False) -> str:
    """Report of one screen."""
    return WRITERS[type(fit)].report(fit, units, verbose)


def case_text_of(fit: AnyFit) -> str:
    """Case file of the joint."""
    return WRITERS[type(fit)].case(fit)


def interface_of(fit: AnyFit) -> Interface:
    """The joint; what the tests do not show is assumed."""
    return WRITERS[type(fit)].interface(fit)


def residuals_of(fit: AnyFit) -> str:
    """CSV of measured and fitted numbers with their differences."""
    return WRITERS[type(fit)].residuals(fit)


def figure_of(fit: AnyFit, units: tuple[str, str], of_tests: str = "") -> Figure:
    """Tests and law; of_tests: what the tests are where they are curves, which are drawn as dashed lines."""
    return WRITERS[type(fit)].figure(fit, units, of_tests)


def draw(fit: AnyFit, units: tuple[str, str], path: Path, of_tests: str = "") -> None:
    """Draw a fit into a file; of_tests: as in `figure_of`."""
    from ..style import printed, save

    with printed():
        save(figure_of(fit, units, of_tests), path)
