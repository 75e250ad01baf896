"""Results of a fit of strengths as a report, a case and rows."""

from __future__ import annotations

import numpy as np

from ...case_writer import rounded
from ...interface import Interface
from ...material import Material
from ...pattern import Pattern
from .columns import NONE
from .model import KS
from .report import (
    cell_of,
    comment,
    compared_rows,
    coverage,
    first_upper,
    shear_case,
    sheet,
)
from .strengths import StrengthFit

EARLY, PAST_PEAK = 0.02, 1.25
"""Slip of a first step of a case, with its own increments: over the last slip, and over that at the peak."""


def strength_report(fit: StrengthFit, units: tuple[str, str] = NONE, verbose: bool = False) -> str:
    """Report of a fit of strengths without curves."""
    low, high, _ = coverage(fit.tests)
    tests = f"{len(fit.tests)} strengths, pressure {low:.4g} to {high:.4g} {units[1]}"
    numbers = compared_rows(fit.tests, fit.fitted, fit.blind, verbose, peaks=fit.peaks, units=units)
    return sheet(tests, [], numbers, fit, units)


def strength_case(fit: StrengthFit) -> str:
    """Case file of the joint of strengths; what they do not show is assumed and said."""
    material, pattern, notes = _joint_of(fit)
    # in tension the equilibrium ends at the strength
    tractions = [rounded(test.sigma_N, 4) for test in fit.tests if test.sigma_N <= 0.0] or [0.0]
    stiffnesses = [test.peak / test.peak_slip for test in fit.tests if np.isfinite(test.peak_slip)]
    spring = float(np.median(stiffnesses)) if stiffnesses else 0.0
    # the peak lies near the start, where the increments are short
    end, peaks = _slip(fit), [test.peak_slip for test in fit.tests if np.isfinite(test.peak_slip)]
    early = PAST_PEAK * max(peaks) if spring else EARLY * end
    slips = [early, end] if early < end else [end]
    text = shear_case("Shear strengths", material, pattern, tractions, slips, spring=spring)
    return "".join(f"! {note}\n" for note in [first_upper(comment(fit)), *notes]) + text


def strength_interface(fit: StrengthFit) -> Interface:
    """Joint of strengths, with what they do not show assumed."""
    material, pattern, _ = _joint_of(fit)
    constructor = Material.from_joint if KS in material else Material
    return Interface(constructor(**material), pattern)


def _slip(fit: StrengthFit) -> float:
    """Slip at the residual strength, or at the peak, or 1."""
    slips = [test.slip for test in fit.tests] + [test.peak_slip for test in fit.tests]
    return max((slip for slip in slips if np.isfinite(slip)), default=1.0)


def _joint_of(fit: StrengthFit) -> tuple[dict[str, float], Pattern, list[str]]:
    """Constants of the material, pattern, and what is assumed."""
    values, slip = fit.values, _slip(fit)
    slope = float(np.tan(np.radians(values.get("theta", 0.0))))
    notes = []
    if not any(np.isfinite([test.slip, test.peak_slip]).any() for test in fit.tests):
        notes.append("The strengths have no slips: a slip of 1 is assumed.")
    if "sigma0" in values:
        material = {
            "sigma0": values["sigma0"],
            "Gc": 0.05 * values["sigma0"] * slip,
            "eta": 0.999,
            "mu": values["mu"],
            "kc": 1.0,
        }
        notes.append("Gc is assumed: strengths do not show it.")
        if "sigma02" in values:
            material |= {"sigma02": values["sigma02"], "Gc2": 0.05 * values["sigma02"] * slip}
        if not slope:
            return material, Pattern.regular(0, 0.0), notes
        notes.append("The height is assumed: the slope ends before the residual strength.")
        material["height"] = slip * slope / 6.0
        return material, Pattern.regular(2, values["theta"], flat=0.0), notes
    ks = 1e3 * max(test.peak for test in fit.tests) / slip
    material = {"kn": 20.0 * ks, "ks": ks, "mu": values["mu"]}
    if not slope:
        return material, Pattern.regular(0, 0.0), notes
    material["height"] = values.get("height", slip * slope / 6.0)
    if "height" not in values:
        notes.append("The height is assumed: the slope ends before the residual strength.")
    if "crush" in values:
        material["crush"] = values["crush"]
    return material, Pattern.regular(2, values["theta"], flat=0.0), notes


def strength_residuals(fit: StrengthFit) -> str:
    """CSV of the measured, fitted and blind strengths with their relative errors."""
    lines = ["test,sigma_N,quantity,measured,fitted,relative_error,blind,blind_relative_error"]
    for test, row, unseen in zip(fit.tests, fit.fitted, fit.blind, strict=True):
        for name, measured in row.measured.items():
            parts = [test.sigma_N, name, measured]
            for comparison in (row, unseen):
                predicted, error = comparison.predicted[name], comparison.errors[name]
                parts += [predicted, error if predicted >= measured else -error]
            texts = (part if isinstance(part, str) else f"{part:.7g}" for part in parts)
            lines.append(f"{cell_of(test.name)},{','.join(texts)}")
    return "\n".join(lines) + "\n"
