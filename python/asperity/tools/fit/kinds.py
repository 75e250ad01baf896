"""What each kind of tests has: its fit, its prediction, and what both say and write."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...interface import Interface
from ...model_checks import model_warnings
from .closure_report import closure_case, closure_figure, closure_report, closure_residuals
from .closure_test import ClosureTest
from .closures import fit_closures
from .fitting import fit
from .prediction import (
    Asked,
    Prediction,
    figure_of_closures,
    figure_of_curves,
    figure_of_strengths,
    predicted_closures,
    predicted_curves,
    predicted_strengths,
)
from .report import AnyFit, case_of, report, residuals_text
from .shear_test import ShearTest
from .strength import Strength
from .strength_report import strength_case, strength_interface, strength_report, strength_residuals
from .strengths import StrengthFit, fit_strengths
from .verdict import AnyTest, Fit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Kind:
    """What tests of a kind have.

    fit: of tests, with the arguments of `fit`.  refuses: options of the command that it does not have.
    doubts: what is unusual about the joint of a fit.  report: of a fit, with units, all of it or one screen.
    case, interface, residuals: case file, joint and rows of a fit; what the tests do not show is assumed.
    figure: of a fit, with units and what tests are that are drawn as dashed lines.  predict: of what is asked
    and tests.  predicted: figure of a prediction, its tests and units.
    """

    fit: Callable[..., AnyFit]
    refuses: tuple[str, ...]
    doubts: Callable[[Any], Iterable[str]]
    report: Callable[[Any, tuple[str, str], bool], str]
    case: Callable[[Any], str]
    interface: Callable[[Any], Interface]
    residuals: Callable[[Any], str]
    figure: Callable[[Any, tuple[str, str], str], Figure]
    predict: Callable[[Asked, Any], Prediction]
    predicted: Callable[[Prediction, Any, tuple[str, str]], Figure]

    def draw(self, found: AnyFit, units: tuple[str, str], path: Path, of_tests: str = "") -> None:
        """Draw a fit into a file; of_tests: what the tests are where they are drawn as dashed lines."""
        from ..style import printed, save

        with printed():
            save(self.figure(found, units, of_tests), path)


def _doubts(fit: Fit) -> Iterable[str]:
    """Warnings about the joint of curves, at their pressures and slips."""
    joint, slip = fit.interface, max(float(abs(test.slip).max()) for test in fit.tests)
    pressed = [test.pressed for test in fit.tests]
    return model_warnings(joint.material, joint.pattern, *pressed, slip=slip)


def _figure_of_curves(fit: Fit, units: tuple[str, str], of_tests: str) -> Figure:
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


KINDS = {
    ShearTest: Kind(
        fit=fit,
        refuses=(),
        doubts=_doubts,
        report=report,
        case=case_of,
        interface=lambda fit: fit.interface,
        residuals=residuals_text,
        figure=_figure_of_curves,
        predict=predicted_curves,
        predicted=figure_of_curves,
    ),
    Strength: Kind(
        fit=lambda tests, joint, known, *_: fit_strengths(tests, joint, known),
        refuses=("--free", "--sides", "--direction"),
        doubts=lambda _: (),
        report=strength_report,
        case=strength_case,
        interface=strength_interface,
        residuals=strength_residuals,
        figure=_envelope,
        predict=predicted_strengths,
        predicted=figure_of_strengths,
    ),
    ClosureTest: Kind(
        fit=lambda tests, *_: fit_closures(tests),
        refuses=("--free", "--sides", "--direction", "--set", "--joint"),
        doubts=lambda _: (),
        report=closure_report,
        case=closure_case,
        interface=lambda fit: fit.interface,
        residuals=closure_residuals,
        figure=lambda fit, units, _: closure_figure(fit, units),
        predict=predicted_closures,
        predicted=figure_of_closures,
    ),
}
"""What tests have, by their kind."""


def kind_of(tests: Sequence[AnyTest]) -> Kind:
    """What tests of one kind have.  Raises ValueError for tests of several kinds, and for what is no test."""
    first: type = type(tests[0])
    kind = first if first in KINDS else ShearTest
    stranger = next((type(test) for test in tests if type(test) is not kind), None)
    if stranger:
        raise ValueError(f"tests: {stranger.__name__} beside {kind.__name__}: expected tests of one kind")
    return KINDS[kind]
