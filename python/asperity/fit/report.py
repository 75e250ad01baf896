"""Results of a fit as text and case file."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable

import numpy as np

from ..case_writer import Word, case_text, pattern_entries, rounded
from .constants import DEFAULTS, KS, MATERIAL, MORTAR, ROCK, UNITS, material_of
from .outcome import COUPLED, ENOUGH, REFINE, Estimate, Fit, residual_ratio
from .shear_test import ShearTest
from .units import NONE

POOR = 0.2
"""Scatter, as a fraction of the range of a test, above which correlated residuals are called a poor fit."""

WIDTH = 110
"""Characters of a line of text."""

MOST_TURNS = 20
"""Largest number of reversals that a case file repeats; noise on the slip makes more."""

CASE_INCREMENTS = 100
"""Increments of a step in the case file."""

FORMS = {MORTAR: "mortar joint, with bond", ROCK: "rock joint, without bond"}

SHOWN_BY = {
    "sigma0": "rows at the peak",
    "Gc": "rows between peak and residual strength",
    "eta": "rows before the peak",
    "mu": "rows after the peak",
    "theta": "the dilation",
    "flat": "tests at several pressures with the dilation",
    "kc": "the closure under pressure",
    KS: "rows before the peak",
    "height": "a slip until the dilation ends",
    "W0": "cycles",
    "closure": "the closure under pressure",
    "crush": "tests at several pressures",
    "damage0": "rows before the peak",
    "sigma02": "a tension test",
    "Gc2": "a tension test",
}
"""What in the test data determines a constant."""


def report(found: Fit, units: tuple[str, str] = NONE) -> str:
    """Lines of the report: tests, assumptions, constants with intervals, correlations, doubts."""
    problem = found.problem
    lines = []
    for test in problem.tests:
        load = f"sigma_N {test.sigma_N:g}" + (f", k_N {test.k_N:g}" if test.k_N > 0.0 else "")
        load += "" if test.path_N is None else f" to {test.path_N[-1]:g} as measured"
        if test.envelope:
            lines.append(f"test        {test.name}: peak {test.tau[0]:g}, residual {test.tau[1]:g}, {load}")
            continue
        seen = "with dilation" if test.s_N is not None else "no dilation"
        turns = len(test.turns) - 1
        points = f"{turns} reversal{'s' * (turns != 1)}"
        lines.append(f"test        {test.name}: {test.slip.size} rows, {seen}, {load}, {points}")
    pattern = f"RP-{problem.sides}" if problem.sides > 2 else ("RT" if problem.sides == 2 else "flat")
    given = {
        name: value
        for name, value in problem.fixed.items()
        if (problem.sides > 0 or name not in ("theta", "flat")) and (value or DEFAULTS.get(name) != 0.0)
    }
    lines += [
        *_form(found),
        f"assumed     {pattern}, slip along {problem.direction:g} degrees"
        + "".join(f", {name} = {value:g}" for name, value in given.items()),
        f"scatter     of the residuals, relative to the range of each test: tau {found.scatter[0]:.2%}"
        + ("" if np.isnan(found.scatter[1]) else f", dilation {found.scatter[1]:.2%}"),
        f"starts      sums of squares {', '.join(f'{cost:.4g}' for cost in found.costs)}",
        f"increments  1/{problem.increments * problem.refinement} of a test or shorter; divided by {REFINE} "
        f"they change a constant by at most {found.shift:.1g} standard errors",
        "",
        f"{'':<14}{'measured':>12}{'fitted':>12}{'difference':>13}",
    ]
    for number, (test, one) in enumerate(zip(problem.tests, found.comparison, strict=True), 1):
        lines.append(f"test {number}, sigma_N {test.sigma_N:g}")
        for name, (measured, fitted) in one.items():
            change = f"{fitted / measured - 1.0:>13.1%}" if measured else ""
            lines.append(f"  {name:<12}{measured:>12.5g}{fitted:>12.5g}{change}")
    lines += ["", f"{'':<12}{'value':>12}{'low':>12}{'high':>12}  {found.confidence:g} intervals"]
    for name, estimate in (found.estimates | _derived(found)).items():
        unit = UNITS[name].replace("stress", units[1]).replace("length", units[0]).replace("*", " ")
        ends = f"{estimate.low:>12.5g}{estimate.high:>12.5g}  {unit}"
        if name in found.undetermined:
            ends = f"{'not determined':>24}  {unit}; {SHOWN_BY.get(name, 'another test')} would"
        elif not 0.0 < estimate.high < 1e6 * max(estimate.low, 1e-300):
            ends = f"{'not determined':>24}  {unit}"
        lines.append(f"{name:<12}{estimate.value:>12.5g}{ends}")
    lines += ["", "correlation " + "".join(f"{name:>9}" for name in problem.free)]
    for name, row in zip(problem.free, found.correlation, strict=True):
        lines.append(f"{name:<12}" + "".join(f"{value:>9.3f}" for value in row))
    return "\n".join([*lines, "", lines_of(doubts_of(found))]).rstrip()


def _form(found: Fit) -> list[str]:
    """Line with the form of the joint and why it is this one, and that theta is not fitted."""
    others = [name for name in found.criteria if name != found.form]
    why = ""
    if others:
        more = found.criteria[others[0]]
        why = (
            f": the information criterion (BIC) is {found.criteria[found.form]:.5g}, that of a "
            f"{FORMS[others[0]]}, {more:.5g}"
        )
    lines = [f"form        {FORMS[found.form]}{why}"] if found.form else []
    if not found.problem.dilation and "theta" not in found.problem.free and not found.problem.fixed["theta"]:
        lines.append(
            "theta       is not fitted, as no dilation was measured: mu contains the slope of the planes; "
            "give --set theta="
        )
    return lines


def lines_of(texts: Iterable[str]) -> str:
    """Sentences in lines."""
    return "\n".join(line for text in texts for line in textwrap.wrap(text, WIDTH, subsequent_indent="  "))


def props_line(found: Fit) -> str:
    """Line with the vector PROPS."""
    props = found.interface.props()
    values = ", ".join(f"{float(f'{value:.6g}')!r}" for value in props.tolist())
    return f"PROPS({len(props)})   {values}"


def _derived(found: Fit) -> dict[str, Estimate]:
    """Intervals of s_f, s0, K and of the residual ratio, where they depend on free constants."""
    free = set(found.problem.free)
    numbers = {}
    for name, entry in (("s_f", "s_f"), ("s0", "s_0"), ("K", "K")):
        if ({"sigma0", "Gc"} | ({"eta"} if name != "s_f" else set())) & free:
            numbers[name] = found.of(lambda values, entry=entry: getattr(material_of(values), entry))  # type: ignore[misc]
    if {"mu", "theta"} & free and np.isfinite(residual_ratio(found.values)):
        numbers["ratio"] = found.of(residual_ratio)
    return numbers


def doubts_of(found: Fit) -> list[str]:
    """Sentences on constants that cannot be separated, on their determined combination, and on doubts."""
    problem, texts = found.problem, []
    free = problem.free
    poor = [value for value in found.scatter if value > POOR]
    if poor and found.dependent:
        texts.append(
            f"the fit is poor: the residuals are {max(poor):.0%} of the range. Check the plot, the units "
            "and the constants that are set; the numbers are not reliable"
        )
    if {"mu", "theta"} <= set(free):
        texts.append(_mu_and_theta(found))
    for i, j in np.argwhere(np.triu(np.abs(found.correlation) > COUPLED, 1)).tolist():
        if {free[i], free[j]} != {"mu", "theta"}:
            number = f"(correlation {found.correlation[i, j]:.4f})"
            texts.append(f"{free[i]} and {free[j]} cannot be separated {number}: set one of them")
    for name in found.at_bounds:
        low, high = problem.bounds[name]
        texts.append(
            f"{name} = {found.values[name]:.4g} is at one of its bounds, {low:g} to {high:g}: "
            "its interval has no meaning"
        )
    if not found.converged:
        texts.append("the least squares ended before they converged: give a --start, or fewer free constants")
    if found.shift > ENOUGH:
        texts.append(
            f"the increments are too long: finer ones change a constant by {found.shift:.2g} standard "
            "errors; raise --increments"
        )
    if found.agreeing == 1 and len(found.costs) > 1:
        texts.append(
            "only one start reached the smallest sum of squares: there may be a smaller one; raise --starts"
        )
    if found.dependent:
        width = "are widened" if found.model_error > 0.0 else "are too narrow"
        texts.append(
            f"residuals of neighbouring rows are correlated ({found.neighbours:.2f}): the model differs from "
            f"the test data by more than noise, so the intervals {width} by a factor of about "
            f"{found.dependence_factor:.1f}"
        )
    return texts


def _mu_and_theta(found: Fit) -> str:
    """Sentence on how well friction and inclination are separated."""
    free, ratio = found.problem.free, "(mu + tan theta)/(1 - mu tan theta)"
    correlation = found.correlation[free.index("mu"), free.index("theta")]
    if not np.isfinite(residual_ratio(found.values)):
        return f"mu and theta: {ratio} is infinite, because the planes lock; correlation {correlation:.3f}"
    one = found.of(residual_ratio)
    width = (one.high - one.low) / (2.0 * one.value)
    known = f"{ratio} = {one.value:.5g} is known to +-{width:.2%} (correlation {correlation:.4f})"
    apart = abs(correlation) <= COUPLED and not {"mu", "theta"} & {*found.undetermined, *found.at_bounds}
    if found.problem.dilation:
        return f"mu and theta {'are separated by the dilation' if apart else 'cannot be separated'}: {known}"
    how = "are separated only by the shape of tau" if apart else "cannot be separated"
    return f"no dilation: mu and theta {how}: {known}; measure the dilation or set one of them"


def accepted_text(found: Fit, reasons: Iterable[str]) -> str:
    """What the user has accepted of a fit, for case, covariance and card; empty where there is nothing."""
    tau, dilation = found.deviation
    parts = [f"{100.0 * tau:.2g} % of tau"] + [f"{100.0 * dilation:.2g} % of s_N"] * (dilation > 0.0)
    texts = [f"the law differs from the tests by {' and '.join(parts)}"] * (tau > 0.0)
    text = "; ".join([*texts, *reasons])
    return f"accepted with {text}" if text else ""


def case_of(found: Fit) -> str:
    """Case file with the identified interface and the tests as a sweep; normal springs are left out.

    `asperity card`, `select` and `run` read this file.
    """
    problem = found.problem
    longest = max(problem.tests, key=lambda test: float(np.abs(np.diff([0.0, *test.turns])).sum()))
    turns = longest.turns if len(longest.turns) <= MOST_TURNS else _ends(longest)
    stresses = sorted({rounded(test.sigma_N, 4) for test in problem.tests}, reverse=True)
    several = len(stresses) > 1
    values = found.values
    material = {name: values[name] for name in MATERIAL if values.get(name, 0.0) or name in problem.free}
    if KS in values:
        material = {"kn": values[KS] * material.pop("kc"), KS: values[KS]} | material
    slips = {"slip": [rounded(slip, 6) for slip in turns], "direction": rounded(problem.direction, 6)}
    text = case_text(
        ("case", {"title": "Shear box"}),
        ("material", {name: rounded(value, 6) for name, value in material.items()}),
        ("pattern", pattern_entries(found.interface.pattern)),
        *([("sweep", {"name": "sigma_N", "values": stresses})] if several else []),
        ("step", {"t_N": Word("sigma_N") if several else stresses[0], "increments": CASE_INCREMENTS}),
        ("step", slips | {"increments": [CASE_INCREMENTS] * len(turns)}),
    )
    if any(test.k_N > 0.0 for test in problem.tests):
        note = "The tests had a normal stiffness k_N; this case keeps their initial normal traction constant."
        text = f"! {note}\n{text}"
    return text


def _ends(test: ShearTest) -> list[float]:
    """Largest and smallest slip of a path, in the order of the path, without the start."""
    ends = sorted({int(np.argmax(test.slip)), int(np.argmin(test.slip))})
    return [float(test.slip[i]) for i in ends if i > 0 or len(ends) == 1]
