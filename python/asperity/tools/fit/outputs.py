"""What a fit writes, by its kind: of curves, of strengths, or of closures."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...interface import Interface
from .closure_report import closure_case, closure_figure, closure_report, closure_residuals
from .closures import ClosureFit
from .report import AnyFit, case_of, report, residuals_text
from .strength_report import strength_case, strength_interface, strength_report, strength_residuals
from .strengths import StrengthFit

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.figure import Figure


def report_of(fit: AnyFit, units: tuple[str, str], verbose: bool = False) -> str:
    """Report of one screen."""
    if isinstance(fit, StrengthFit):
        return strength_report(fit, units, verbose)
    if isinstance(fit, ClosureFit):
        return closure_report(fit, units, verbose)
    return report(fit, units, verbose)


def case_text_of(fit: AnyFit) -> str:
    """Case file of the joint."""
    if isinstance(fit, StrengthFit):
        return strength_case(fit)
    return closure_case(fit) if isinstance(fit, ClosureFit) else case_of(fit)


def interface_of(fit: AnyFit) -> Interface:
    """The joint; what the tests do not show is assumed."""
    return strength_interface(fit) if isinstance(fit, StrengthFit) else fit.interface


def residuals_of(fit: AnyFit) -> str:
    """CSV of measured and fitted numbers with their differences."""
    if isinstance(fit, StrengthFit):
        return strength_residuals(fit)
    return closure_residuals(fit) if isinstance(fit, ClosureFit) else residuals_text(fit)


def figure_of(fit: AnyFit, units: tuple[str, str], of_tests: str = "") -> Figure:
    """Tests and law; of_tests: what the tests are where they are curves, which are drawn as dashed lines."""
    from .picture import curves_figure, envelope_figure

    if isinstance(fit, StrengthFit):
        return envelope_figure(fit, units)
    if isinstance(fit, ClosureFit):
        return closure_figure(fit, units)
    problem = fit.solution.problem
    curves = [
        (slips[:done], tau[:done], s_N[:done])
        for (slips, _), (tau, s_N, done) in zip(problem.paths, problem.curves(fit.values), strict=True)
    ]
    return curves_figure(problem.tests, curves, units, "fit", of_tests)


def draw(fit: AnyFit, units: tuple[str, str], path: Path, of_tests: str = "") -> None:
    """Draw a fit into a file; of_tests: as in `figure_of`."""
    from ..style import printed, save

    with printed():
        save(figure_of(fit, units, of_tests), path)
