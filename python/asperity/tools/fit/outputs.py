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


def report_of(found: AnyFit, units: tuple[str, str], verbose: bool = False) -> str:
    """Report of one screen."""
    if isinstance(found, StrengthFit):
        return strength_report(found, units, verbose)
    if isinstance(found, ClosureFit):
        return closure_report(found, units, verbose)
    return report(found, units, verbose)


def case_text_of(found: AnyFit) -> str:
    """Case file of the joint."""
    if isinstance(found, StrengthFit):
        return strength_case(found)
    return closure_case(found) if isinstance(found, ClosureFit) else case_of(found)


def interface_of(found: AnyFit) -> Interface:
    """The joint; what the tests do not show is assumed."""
    return strength_interface(found) if isinstance(found, StrengthFit) else found.interface


def residuals_of(found: AnyFit) -> str:
    """CSV of measured and fitted numbers with their differences."""
    if isinstance(found, StrengthFit):
        return strength_residuals(found)
    return closure_residuals(found) if isinstance(found, ClosureFit) else residuals_text(found)


def figure_of(found: AnyFit, units: tuple[str, str], of_tests: str = "") -> Figure:
    """Tests and law; of_tests: what the tests are where they are curves, which are drawn as dashed lines."""
    from .picture import curves_figure, envelope_figure

    if isinstance(found, StrengthFit):
        return envelope_figure(found, units)
    if isinstance(found, ClosureFit):
        return closure_figure(found, units)
    return curves_figure(found, units, of_tests)


def draw(found: AnyFit, units: tuple[str, str], path: Path, of_tests: str = "") -> None:
    """Draw a fit into a file; of_tests: as in `figure_of`."""
    from ..style import printed, save

    with printed():
        save(figure_of(found, units, of_tests), path)
