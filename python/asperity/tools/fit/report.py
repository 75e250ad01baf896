"""Results of a fit as a report of one screen, a case file and the file of the intervals."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np

from ...case_writer import Word, case_text, pattern_entries, rounded
from ...contract import Floats
from ...pattern import Pattern
from .closures import ClosureFit
from .columns import NONE
from .intervals import Estimate
from .model import KS, KT, MATERIAL, SCALES, UNITS
from .shear_test import ShearTest, cycles, first_stroke
from .strengths import StrengthFit
from .thresholds import CONFIDENCE, FAIR, GOOD
from .verdict import AnyTest, Comparison, Fit, short

MOST_TURNS, MOST_TESTS, INCREMENTS_OF_CASE = 20, 8, 100
"""Most reversals that a case repeats; most tests of which the report shows the numbers; increments."""

AnyFit: TypeAlias = Fit | StrengthFit | ClosureFit
"""What a fit of curves, of strengths or of closures has found."""

COLUMNS = {
    "peak": "peak",
    "tension": "tension",
    "slip at peak": "at slip",
    "residual": "residual",
    "dilation": "dilation",
    "closure": "closure",
}
LENGTHS = ("slip at peak", "dilation", "closure")
"""Numbers of a test and their headings; those that are lengths, as the others are stresses."""


def report(fit: Fit, units: tuple[str, str] = NONE, verbose: bool = False) -> str:
    """Report of a fit; verbose: also all tests, the models of the ladder and the correlations."""
    tests = fit.tests
    low, high, slip = coverage(tests)
    scatter = ", ".join(f"{name} {value:.1%}" for name, value in fit.scatter.items())
    more = [*_assumptions(fit)]
    if verbose:
        steps = ", ".join(f"{'+'.join(free)} {value:+.1f}" for free, value in fit.models)
        more += ["", f"ladder      information criterion over that of the choice: {steps}"]
        more += _correlations(fit.free, fit.covariance)
    return sheet(
        f"{len(tests)}, {sum(test.slip.size for test in tests)} rows, pressure {low:.4g} to {high:.4g} "
        f"{units[1]}, slip to {slip:.4g} {units[0]}",
        [f"scatter     {scatter} of the range of each test"],
        compared_rows(tests, fit.fitted, fit.blind, verbose, units=units),
        fit,
        units,
        more,
    )


def sheet(
    tests: str,
    scatter: Sequence[str],
    numbers: Sequence[str],
    fit: AnyFit,
    units: tuple[str, str],
    more: Sequence[str] = (),
) -> str:
    """Report of any fit: tests, model, numbers of the tests, constants, what else is said, and verdict."""
    head = [f"tests       {tests}", f"model       {fit.model_text}", *scatter]
    constants = constant_rows(fit.estimates, units, fit.loose)
    return "\n".join([*head, "", *numbers, "", *constants, *more, "", *verdict(fit)])


def compared_rows(
    tests: Sequence[AnyTest],
    fitted: Sequence[Comparison],
    unseen: Sequence[Comparison],
    verbose: bool,
    title: str = "",
    peaks: Sequence[Estimate] = (),
    units: tuple[str, str] = NONE,
) -> list[str]:
    """Pressure, and measured, fitted and blind numbers of each test, under a title.

    peaks: intervals of the peaks.  units: of length and stress, for the headings.
    """
    title = title or ("measured / fitted / blind" if unseen else "measured / fitted")
    names = [name for name in COLUMNS if any(name in row.measured for row in fitted)]
    head = [f"pressure [{units[1]}]", *(heading(name, units) for name in names)]
    if peaks:
        head.append(f"peak, {CONFIDENCE:g} interval")
    table = []
    shown = len(fitted) if verbose else MOST_TESTS
    for i, row in enumerate(fitted[:shown]):
        cells = [f"{tests[i].level:.4g}"]
        for name in names:
            kinds = [row.measured, row.predicted, *([unseen[i].predicted] if unseen else [])]
            values = [numbers[name] for numbers in kinds] if name in row.measured else []
            cells.append(" / ".join(f"{value:.4g}" for value in values))
        cells += [f"{peak.low:.4g} to {peak.high:.4g}" for peak in peaks[i : i + 1]]
        table.append(cells)
    widths = [max(26, *(len(cell) + 2 for cell in column)) for column in zip(head, *table, strict=True)]
    widths[0] = len(head[0]) + 2
    starts = [title, *(short(row.test) for row in fitted)]
    lines = [
        f"{start:<28}" + "".join(f"{cell:>{width}}" for cell, width in zip(cells, widths, strict=True))
        for start, cells in zip(starts, [head, *table], strict=False)
    ]
    more = len(fitted) - shown
    if more > 0:
        lines.append(f"... and {more} more (--verbose)")
    return lines


def heading(name: str, units: tuple[str, str]) -> str:
    """Heading of a number of a test, with its unit."""
    return f"{COLUMNS[name]} [{units[name not in LENGTHS]}]"


def constant_rows(
    estimates: Mapping[str, Estimate], units: tuple[str, str], loose: Sequence[str] = ()
) -> list[str]:
    """Constants with their intervals; loose: those that are not determined."""
    lines = [f"{'':<12}{'value':>12}{'low':>12}{'high':>12}  {CONFIDENCE:g} intervals"]
    for name, (value, low, high) in estimates.items():
        words = [unit_of(name, units), *(["(not determined)"] if name in loose else [])]
        lines.append(f"{name:<12}{value:>12.4g}{low:>12.4g}{high:>12.4g}  {' '.join(words)}")
    return lines


def _assumptions(fit: Fit) -> Iterator[str]:
    """What other assumptions do to the constants and the misfit."""
    if not fit.assumptions:
        return
    names = [name for name in fit.free if name != KT]
    yield ""
    yield f"{'assumed instead':<36}{'misfit':>8}  " + "".join(f"{name:>10}" for name in names)
    for assumption in fit.assumptions:
        values = "".join(
            f"{assumption.values[name]:>10.4g}" if name in assumption.values else f"{'':>10}"
            for name in names
        )
        note = "" if assumption.admissible else "  (the tests exclude it)"
        yield f"{assumption.name[:35]:<36}{assumption.difference:>+8.1f}  {values}{note}".rstrip()


def _correlations(names: Sequence[str], covariance: Floats) -> Iterator[str]:
    sizes = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    table = covariance / np.outer(sizes, sizes)
    pairs = ((table[i, j], a, b) for i, a in enumerate(names) for j, b in enumerate(names) if i < j)
    strong = [f"{a}, {b} {value:.2f}" for value, a, b in pairs if abs(value) > 0.9]
    if strong:
        yield f"correlation {'; '.join(strong)}"


def verdict(fit: AnyFit) -> list[str]:
    """Grade with the errors on which it rests, reasons and notes."""
    errors = ", ".join(f"{name} {value:.1%}" for name, value in fit.errors.items())
    lines = [f"grade       {fit.grade} (good: at most {GOOD:.0%}, fair: {FAIR:.0%}); errors: {errors}"]
    lines += [f"no result   {text}" for text in fit.reasons]
    return lines + [f"note        {text}" for text in fit.notes]


def unit_of(name: str, units: tuple[str, str]) -> str:
    """Unit of a constant with these units of length and stress."""
    unit = UNITS.get(name, "stress/length" if name == "kn" else "")
    return unit.replace("stress", units[1]).replace("length", units[0]).replace("*", " ")


def comment(fit: AnyFit) -> str:
    """Grade and intervals as one line, for cases and cards."""
    intervals = ", ".join(
        f"{name} {estimate.low:.3g} to {estimate.high:.3g}" for name, estimate in fit.estimates.items()
    )
    state = "" if fit.is_result else f"; no result: {fit.reasons[0]}"
    loose = f"; not determined: {', '.join(fit.loose)}" if fit.loose else ""
    return f"grade {fit.grade}{state}; {CONFIDENCE:g} intervals: {intervals}{loose}"


def case_of(fit: Fit) -> str:
    """Case file with the identified joint, its spring in series and the tests as a sweep, with their k_N."""
    tests, values = fit.tests, fit.values
    turns = max((test.turns for test in tests), key=lambda slips: np.abs(np.diff([0.0, *slips])).sum())
    first = max(tests, key=lambda test: float(np.abs(test.slip).max()))
    if fit.spring and not cycles(tests):  # as it was fitted, along the first stroke
        turns = [float(first.slip[np.argmax(np.abs(first.slip[first_stroke(first)]))])]
    elif len(turns) > MOST_TURNS:
        turns = [max(turns, key=abs)]
    needed = ("mu", *fit.free)
    material = {name: values[name] for name in MATERIAL if values.get(name, 0.0) or name in needed}
    if KS in values:
        material = {"kn": values[KS] * material.pop("kc"), KS: values[KS]} | material
    stiffnesses = {test.k_N for test in tests}
    k_N = tests[0].k_N
    notes = []
    if len(stiffnesses) > 1:
        notes.append(f"The tests have {len(stiffnesses)} stiffnesses k_N; this is that of the first.")
    if any(test.path_N is not None for test in tests):
        notes.append("The tests were fitted with their measured normal tractions.")
    tractions = [rounded(test.sigma_N, 4) for test in tests]
    joint, direction = (material, fit.interface.pattern), fit.solution.problem.direction
    text = shear_case("Shear box", *joint, tractions, turns, direction, k_N, fit.spring)
    return "".join(f"! {note}\n" for note in [first_upper(comment(fit)), *notes]) + text


def coverage(tests: Sequence[AnyTest]) -> tuple[float, float, float]:
    """Smallest and largest pressure, and largest slip of the tests: where the constants have been seen.

    The slip is 0 without curves.
    """
    low, high, slip = zip(*(test.covers for test in tests), strict=True)
    return min(low), max(high), max(slip)


def first_upper(text: str) -> str:
    """Text as a sentence."""
    return text[0].upper() + text[1:] + "."


def shear_case(
    title: str,
    material: Mapping[str, float],
    pattern: Pattern,
    tractions: Sequence[float],
    slips: Sequence[float],
    direction: float = 0.0,
    k_N: float = 0.0,
    spring: float = 0.0,
) -> str:
    """Case file of a shear box: normal traction, then slips, with a normal stiffness and a spring in series.

    With a spring of stiffness k the shear traction is k times the slip of the box less that of the joint.
    """
    held, several = sorted({*tractions}, reverse=True), len({*tractions}) > 1
    parts = [INCREMENTS_OF_CASE] * len(slips)
    slide: dict[str, object] = {"k_N": rounded(k_N, 6)} if k_N else {}
    slide |= {"t_N": Word("sigma_N") if several else held[0]} if k_N else {}
    if spring:
        k = rounded(spring, 6)
        for axis, part in (("x", np.cos(np.radians(direction))), ("y", np.sin(np.radians(direction)))):
            # without negative zeros
            targets = [rounded(k * float(part) * slip, 6) + 0.0 for slip in slips]
            slide |= {f"t_T{axis}": targets, f"k_T{axis}": k}
    else:
        slide |= {"slip": [rounded(slip, 6) for slip in slips], "direction": direction}
    return case_text(
        ("case", {"title": title}),
        ("material", {name: rounded(value, 6) for name, value in material.items()}),
        ("pattern", pattern_entries(pattern)),
        *([("sweep", {"name": "sigma_N", "values": held})] if several else []),
        ("step", {"t_N": Word("sigma_N") if several else held[0], "increments": INCREMENTS_OF_CASE}),
        ("step", slide | {"increments": parts}),
    )


def intervals_text(fit: AnyFit, units: tuple[str, str] = NONE) -> str:
    """Content of CASE.fit.json: constants, units, intervals and covariance, grade, errors, predictions."""
    names = [name for name in fit.free if name != KT]
    places = [fit.free.index(name) for name in names]
    covariance = fit.covariance[np.ix_(places, places)]
    peaks = fit.peaks
    blind: Sequence[Comparison | None] = fit.blind or [None] * len(fit.fitted)
    low, high, slip = coverage(fit.tests)
    content = {
        "parameters": names,
        "units": list(units),
        "pressures": [low, high],
        "slip": slip,
        "values": [fit.values[name] for name in names],
        "scales": [SCALES.get(name, "log") for name in names],
        "covariance on the scales": covariance.tolist(),
        "intervals": {name: list(estimate[1:]) for name, estimate in fit.estimates.items()},
        "not determined": fit.loose,
        "grade": fit.grade,
        "no result": fit.reasons,
        "notes": fit.notes,
        "errors": fit.errors,
        "model error of tau and s_N": fit.model_error,
        "tests": [
            {"test": short(row.test), "measured": dict(row.measured), "fitted": dict(row.predicted)}
            | ({"peak interval": list(peaks[i][1:])} if peaks else {})
            | ({"blind": dict(unseen.predicted)} if unseen else {})
            for i, (row, unseen) in enumerate(zip(fit.fitted, blind, strict=True))
        ],
    }
    return json.dumps(content, indent=1, default=float) + "\n"


def cell_of(name: str) -> str:
    """Name of a test as a cell of a CSV file."""
    return short(name).replace(",", ";").replace('"', "'")


def residuals_text(fit: Fit) -> str:
    """CSV of the measured and fitted rows with their residuals over the range."""
    problem = fit.solution.problem
    columns = ["test", "row", "quantity", "slip", "measured", "fitted", "residual_over_range"]
    rows, residuals = problem.rows, fit.residuals
    lines = [",".join(columns)]
    for i, (number, row, measured) in enumerate(zip(rows.test, rows.row, rows.measured, strict=True)):
        test: ShearTest = problem.tests[number]
        fitted = measured + residuals[i] * rows.scale[i]
        name = cell_of(test.name)
        values = f"{test.slip[row]:.7g},{measured:.7g},{fitted:.7g},{residuals[i]:.5g}"
        line = test.lines[row] if test.lines else row + 1
        lines.append(f"{name},{line},{rows.name[i]},{values}")
    return "\n".join(lines) + "\n"


def file_of(case: Path) -> Path:
    """File beside a case, where `asperity fit` writes the intervals."""
    return case.parent / f"{case.stem}.fit.json"
