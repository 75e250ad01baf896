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
from .evidence import first_stroke
from .intervals import CONFIDENCE, Estimate
from .model import KS, KT, MATERIAL, SCALES, UNITS
from .records import NONE
from .result import Fit
from .shear_test import ShearTest
from .strengths import StrengthFit
from .verdict import FAIR, GOOD, Comparison, coverage

MOST_TURNS, MOST_TESTS, INCREMENTS = 20, 8, 100
"""Most reversals that a case repeats; most tests of which the report shows the numbers; increments."""

AnyFit: TypeAlias = Fit | StrengthFit | ClosureFit
"""What a fit of curves, of strengths or of closures has found."""

COLUMNS = {
    "peak": "peak",
    "slip at peak": "at slip",
    "residual": "residual",
    "dilation": "dilation",
    "closure": "closure",
}
"""Numbers of a test and their headings."""


def report(found: Fit, units: tuple[str, str] = NONE, verbose: bool = False) -> str:
    """Report of a fit; verbose: also all tests, the models of the ladder and the correlations."""
    tests, model = found.tests, found.solution.model
    low, high, slip = coverage(tests)
    form = "with bond" if model.bond else "without bond"
    pattern = f"{model.sides} sides" if "theta" in {*model.free, *model.fixed} else "flat"
    lines = [
        f"tests       {len(tests)}, {sum(one.slip.size for one in tests)} rows, pressure "
        f"{low:.4g} to {high:.4g} "
        f"{units[1]}, slip to {slip:.4g} {units[0]}",
        f"model       joint {form}, {pattern}; free: {', '.join(model.free)}{_known(found)}",
        "scatter     "
        + ", ".join(f"{name} {value:.1%}" for name, value in found.scatter.items())
        + " of the range of each test",
        "",
        *compared_rows(found.fitted, found.blind, verbose),
        "",
        *constant_rows(found.estimates, units),
        *_assumptions(found),
    ]
    if verbose:
        steps = ", ".join(f"{'+'.join(free)} {value:+.1f}" for free, value in found.models)
        lines += ["", f"ladder      information criterion over that of the choice: {steps}"]
        lines += _correlations(found.free, found.covariance)
    return "\n".join([*lines, "", *verdict(found)])


def _known(found: Fit) -> str:
    """Values that are not those of the usual model; a spring that the rows do not show is rigid."""
    hidden = {"theta": 0.0, "flat": 0.0, "height": 0.0, "crush": 0.0, "W0": 0.0, "closure": 0.0}
    fixed = found.solution.model.fixed
    shown = [f"{name} = {value:.4g}" for name, value in fixed.items() if value != hidden.get(name)]
    return f"; fixed: {', '.join(shown)}" if shown else ""


def compared_rows(
    fitted: Sequence[Comparison],
    unseen: Sequence[Comparison],
    verbose: bool,
    title: str = "",
    peaks: Sequence[Estimate] = (),
) -> list[str]:
    """Measured, fitted and blind numbers of each test, under a title; peaks: intervals of the peaks."""
    title = title or ("measured / fitted / blind" if unseen else "measured / fitted")
    names = [name for name in COLUMNS if any(name in row.measured for row in fitted)]
    head = [COLUMNS[name] for name in names]
    if peaks:
        head.append(f"peak, {CONFIDENCE:g} interval")
    table = []
    shown = len(fitted) if verbose else MOST_TESTS
    for i, row in enumerate(fitted[:shown]):
        cells = []
        for name in names:
            kinds = [row.measured, row.predicted, *([unseen[i].predicted] if unseen else [])]
            values = [one[name] for one in kinds] if name in row.measured else []
            cells.append(" / ".join(f"{value:.4g}" for value in values))
        cells += [f"{one.low:.4g} to {one.high:.4g}" for one in peaks[i : i + 1]]
        table.append(cells)
    widths = [max(26, *(len(cell) + 2 for cell in column)) for column in zip(head, *table, strict=True)]
    starts = [title, *(short(row.test) for row in fitted)]
    lines = [
        f"{start:<28}" + "".join(f"{cell:>{width}}" for cell, width in zip(cells, widths, strict=True))
        for start, cells in zip(starts, [head, *table], strict=False)
    ]
    more = len(fitted) - shown
    if more > 0:
        lines.append(f"... and {more} more (--verbose)")
    return lines


def short(name: str) -> str:
    """Name of a test without the folder of its file, 27 characters at most."""
    text = name.replace("\\", "/").rsplit("/", 1)[-1]
    return text if len(text) <= 27 else f"...{text[-24:]}"


def constant_rows(estimates: Mapping[str, Estimate], units: tuple[str, str]) -> list[str]:
    """Constants with their intervals."""
    lines = [f"{'':<12}{'value':>12}{'low':>12}{'high':>12}  {CONFIDENCE:g} intervals"]
    for name, (value, low, high) in estimates.items():
        lines.append(f"{name:<12}{value:>12.4g}{low:>12.4g}{high:>12.4g}  {unit_of(name, units)}")
    return lines


def _assumptions(found: Fit) -> Iterator[str]:
    """What other assumptions do to the constants and the misfit."""
    if not found.assumptions:
        return
    names = [name for name in found.free if name != KT]
    yield ""
    yield f"{'assumed instead':<34}{'misfit':>8}  " + "".join(f"{name:>10}" for name in names)
    for one in found.assumptions:
        values = "".join(
            f"{one.values[name]:>10.4g}" if name in one.values else f"{'':>10}" for name in names
        )
        note = "" if one.admissible else "  (the tests exclude it)"
        yield f"{one.name[:33]:<34}{one.difference:>+8.1f}  {values}{note}".rstrip()


def _correlations(names: Sequence[str], covariance: Floats) -> Iterator[str]:
    sizes = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    table = covariance / np.outer(sizes, sizes)
    pairs = ((table[i, j], a, b) for i, a in enumerate(names) for j, b in enumerate(names) if i < j)
    strong = [f"{a}, {b} {value:.2f}" for value, a, b in pairs if abs(value) > 0.9]
    if strong:
        yield f"correlation {'; '.join(strong)}"


def verdict(found: AnyFit) -> list[str]:
    """Grade with the errors on which it rests, reasons and notes."""
    errors = ", ".join(f"{name} {value:.1%}" for name, value in found.errors.items())
    lines = [f"grade       {found.grade} (good: at most {GOOD:.0%}, fair: {FAIR:.0%}); errors: {errors}"]
    lines += [f"no result   {text}" for text in found.reasons]
    return lines + [f"note        {text}" for text in found.notes]


def unit_of(name: str, units: tuple[str, str]) -> str:
    """Unit of a constant with these units of length and stress."""
    unit = UNITS.get(name, "stress/length" if name == "kn" else "")
    return unit.replace("stress", units[1]).replace("length", units[0]).replace("*", " ")


def comment(found: AnyFit) -> str:
    """Grade and intervals as one line, for cases and cards."""
    intervals = ", ".join(f"{name} {one.low:.3g} to {one.high:.3g}" for name, one in found.estimates.items())
    state = "" if found.is_result else f"; no result: {found.reasons[0]}"
    return f"grade {found.grade}{state}; {CONFIDENCE:g} intervals: {intervals}"


def case_of(found: Fit) -> str:
    """Case file with the identified joint, its spring in series and the tests as a sweep, with their k_N."""
    tests, values = found.tests, found.values
    turns = max((test.turns for test in tests), key=lambda one: np.abs(np.diff([0.0, *one])).sum())
    first = max(tests, key=lambda one: float(np.abs(one.slip).max()))
    if found.spring:  # as it was fitted, along the first stroke
        turns = [float(first.slip[np.argmax(np.abs(first.slip[first_stroke(first)]))])]
    elif len(turns) > MOST_TURNS:
        turns = [max(turns, key=abs)]
    needed = ("mu", *found.free)
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
    joint, direction = (material, found.interface.pattern), found.solution.problem.direction
    text = shear_case("Shear box", *joint, tractions, turns, direction, k_N, found.spring)
    return "".join(f"! {note}\n" for note in [first_upper(comment(found)), *notes]) + text


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
    parts = [INCREMENTS] * len(slips)
    slide: dict[str, object] = {"k_N": rounded(k_N, 6)} if k_N else {}
    slide |= {"t_N": Word("sigma_N") if several else held[0]} if k_N else {}
    if spring:
        k = rounded(spring, 6)
        for axis, part in (("x", np.cos(np.radians(direction))), ("y", np.sin(np.radians(direction)))):
            slide |= {f"t_T{axis}": [rounded(k * float(part) * one, 6) for one in slips], f"k_T{axis}": k}
    else:
        slide |= {"slip": [rounded(one, 6) for one in slips], "direction": direction}
    return case_text(
        ("case", {"title": title}),
        ("material", {name: rounded(value, 6) for name, value in material.items()}),
        ("pattern", pattern_entries(pattern)),
        *([("sweep", {"name": "sigma_N", "values": held})] if several else []),
        ("step", {"t_N": Word("sigma_N") if several else held[0], "increments": INCREMENTS}),
        ("step", slide | {"increments": parts}),
    )


def intervals_text(found: AnyFit) -> str:
    """Content of CASE.fit.json: constants with intervals and covariance, grade, errors, predictions."""
    names = [name for name in found.free if name != KT]
    places = [found.free.index(name) for name in names]
    covariance = found.covariance[np.ix_(places, places)]
    if isinstance(found, Fit):
        error = found.model_error
    elif isinstance(found, StrengthFit):
        error = found.errors.get("blind peak", found.errors["peak"]), 0.0
    else:
        error = 0.0, found.errors.get("blind closure", found.errors["closure"])
    peaks = found.peaks if isinstance(found, StrengthFit) else []
    if isinstance(found, Fit):
        peaks = [found.number(i, "peak") for i in range(len(found.fitted))]
    blind: Sequence[Comparison | None] = found.blind or [None] * len(found.fitted)
    content = {
        "parameters": names,
        "values": [found.values[name] for name in names],
        "scales": [SCALES.get(name, "log") for name in names],
        "covariance on the scales": covariance.tolist(),
        "intervals": {name: list(one[1:]) for name, one in found.estimates.items()},
        "grade": found.grade,
        "no result": found.reasons,
        "notes": found.notes,
        "errors": found.errors,
        "model error of tau and s_N": error,
        "tests": [
            {"test": short(row.test), "measured": dict(row.measured), "fitted": dict(row.predicted)}
            | ({"peak interval": list(peaks[i][1:])} if peaks else {})
            | ({"blind": dict(unseen.predicted)} if unseen else {})
            for i, (row, unseen) in enumerate(zip(found.fitted, blind, strict=True))
        ],
    }
    return json.dumps(content, indent=1, default=float) + "\n"


def cell_of(name: str) -> str:
    """Name of a test as a cell of a CSV file."""
    return short(name).replace(",", ";").replace('"', "'")


def residuals_text(found: Fit) -> str:
    """CSV of the measured and fitted rows with their residuals over the range."""
    problem = found.solution.problem
    columns = ["test", "row", "quantity", "slip", "measured", "fitted", "residual_over_range"]
    rows, residuals = problem.rows, found.residuals
    lines = [",".join(columns)]
    for i, row in enumerate(rows.itertuples()):
        test: ShearTest = problem.tests[row.test]
        fitted = row.measured + residuals[i] * row.scale
        name = cell_of(test.name)
        values = f"{test.slip[row.row]:.7g},{row.measured:.7g},{fitted:.7g},{residuals[i]:.5g}"
        line = test.lines[row.row] if test.lines else row.row + 1
        lines.append(f"{name},{line},{row.name},{values}")
    return "\n".join(lines) + "\n"


def file_of(case: Path) -> Path:
    """File beside a case, where `asperity fit` writes the intervals."""
    return case.parent / f"{case.stem}.fit.json"
