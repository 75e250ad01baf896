"""Results of a fit as text and case file."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence

import numpy as np

from ..case_files import case_lines
from ..contract import Floats
from .model import KS, MATERIAL, TIMELESS, material_of, transformed
from .outcome import COUPLED, ENOUGH, REFINE, UNDETERMINED, Estimate, Fit, residual_ratio
from .shear_test import ShearTest
from .units import NONE

POOR = 0.2
"""Scatter, as a fraction of the range of a test, above which correlated residuals are called a poor fit."""

UNKNOWN = 1.0e6
"""Ratio of the ends of an interval above which nothing is known of the parameter."""

WIDTH = 110
"""Characters of a line of text."""

MOST_TURNS = 20
"""Largest number of reversals that a case file repeats; noise on the slip makes more."""

ABSENT = tuple(row.name for row in TIMELESS if row.default == 0.0)
"""Parameters that are left out where they are 0, their default."""

CASE_INCREMENTS = 100
"""Increments of a step in the case file."""


def report(found: Fit, units: tuple[str, str] = NONE) -> str:
    """Lines of the report: tests, assumptions, parameters with intervals, correlations, doubts."""
    problem = found.problem
    length, stress = units
    of = {"sigma0": stress, "Gc": f"{stress} {length}", "theta": "degree", "K": f"{stress}/{length}"}
    of |= {"s_f": length, "s0": length, "height": length, "W0": f"{stress} {length}", "closure": length}
    of |= {"sigma02": stress, "Gc2": f"{stress} {length}", KS: f"{stress}/{length}"}
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
    given = {
        name: value
        for name, value in problem.fixed.items()
        if (problem.sides > 0 or name not in ("theta", "flat")) and (value or name not in ABSENT)
    }
    pattern = f"RP-{problem.sides}" if problem.sides > 2 else ("RT" if problem.sides == 2 else "flat")
    lines += [
        f"assumed     {pattern}, slip along {problem.direction:g} degrees"
        + "".join(f", {name} = {value:g}" for name, value in given.items()),
        f"scatter     of the residuals, relative to the range of each test: tau {found.scatter[0]:.2%}"
        + ("" if np.isnan(found.scatter[1]) else f", dilation {found.scatter[1]:.2%}"),
        f"starts      sums of squares {', '.join(f'{cost:.4g}' for cost in found.costs)}",
        f"increments  1/{problem.increments * problem.refinement} of a test or shorter; divided by {REFINE} "
        f"they change a parameter by at most {found.shift:.1g} standard errors",
        "",
        f"{'':<12}{'value':>12}{'low':>12}{'high':>12}  {found.confidence:g} intervals",
    ]
    lines += [_row(name, one, of.get(name, "-")) for name, one in found.estimates.items()]
    lines += [_row(name, one, of.get(name, "-")) for name, one in _derived(found).items()]
    lines += ["", "correlation " + "".join(f"{name:>9}" for name in problem.free)]
    for name, row in zip(problem.free, found.correlation, strict=True):
        lines.append(f"{name:<12}" + "".join(f"{value:>9.3f}" for value in row))
    return "\n".join([*lines, "", lines_of(identifiability(found))])


def lines_of(texts: Iterable[str]) -> str:
    """Sentences in lines."""
    return "\n".join(line for text in texts for line in textwrap.wrap(text, WIDTH, subsequent_indent="  "))


def props_line(found: Fit) -> str:
    """Line with the vector PROPS."""
    props = found.interface.props()
    values = ", ".join(f"{float(f'{value:.6g}')!r}" for value in props.tolist())
    return f"PROPS({len(props)})   {values}"


def _row(name: str, one: Estimate, unit: str) -> str:
    return f"{name:<12}{one.value:>12.5g}{one.low:>12.5g}{one.high:>12.5g}  {unit}"


def _derived(found: Fit) -> dict[str, Estimate]:
    """Intervals of s_f, s0, K and of the residual ratio, where they depend on free parameters."""
    free = set(found.problem.free)
    numbers = {}
    for name, entry in (("s_f", "s_f"), ("s0", "s_0"), ("K", "K")):
        if ({"sigma0", "Gc"} | ({"eta"} if name != "s_f" else set())) & free:
            numbers[name] = found.of(lambda values, entry=entry: getattr(material_of(values), entry))  # type: ignore[misc]
    if {"mu", "theta"} & free and np.isfinite(residual_ratio(found.values)):
        numbers["ratio"] = found.of(residual_ratio)
    return numbers


def identifiability(found: Fit) -> list[str]:
    """Sentences on parameters that cannot be separated, on their determined combination, and on doubts."""
    problem, texts = found.problem, []
    free = problem.free
    poor = [value for value in found.scatter if value > POOR]
    if poor and found.dependent:
        texts.append(
            f"the fit is poor: the residuals are {max(poor):.0%} of the range. Check the plot, the units "
            "and the constants that are set; the numbers are not reliable"
        )
    if {"mu", "theta"} <= set(free):
        texts += _mu_and_theta(found)
    if {"sigma0", "Gc"} <= set(free):
        texts.append(_bond(found))
    for i, first in enumerate(free):
        for j in range(i + 1, len(free)):
            pair = {first, free[j]}
            if abs(found.correlation[i, j]) > COUPLED and pair not in ({"mu", "theta"}, {"sigma0", "Gc"}):
                texts.append(_pair(found, i, j))
    for name in found.undetermined:
        one = found.estimates[name]
        texts.append(f"{name} is not determined: {one.low:.3g} to {one.high:.3g}")
    weak = found.directions[-1] * np.sign(found.directions[-1][np.argmax(np.abs(found.directions[-1]))])
    size = found.quantile * float(np.sqrt(weak @ found.covariance @ weak))
    texts.append(
        f"weakest     {_combination(free, weak)} is known to +-{size:.2g} (singular values "
        + ", ".join(f"{value:.3g}" for value in found.singular)
        + ")"
    )
    for name in found.at_bounds:
        low, high = problem.bounds[name]
        texts.append(
            f"{name} = {found.values[name]:.4g} is at one of its bounds, {low:g} to {high:g}: "
            "its interval has no meaning"
        )
    if not found.converged:
        texts.append(
            "the least squares ended before they converged: give a --start, or fewer free parameters"
        )
    if found.shift > ENOUGH:
        texts.append(
            f"the increments are too long: finer ones change a parameter by {found.shift:.2g} standard "
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


def _mu_and_theta(found: Fit) -> list[str]:
    """Sentence on how well friction and inclination are separated."""
    free = found.problem.free
    i, j = free.index("mu"), free.index("theta")
    correlation = found.correlation[i, j]
    ratio = found.estimates["mu"], found.estimates["theta"]
    formula = "(mu + tan theta)/(1 - mu tan theta)"
    if not np.isfinite(residual_ratio(found.values)):
        return [
            f"mu and theta: {formula} is infinite, because the planes lock; correlation {correlation:.3f}"
        ]
    together = found.of(residual_ratio)
    alone = [(one.high - one.low) / (2.0 * one.value) for one in ratio]
    width = (together.high - together.low) / (2.0 * together.value)
    numbers = (
        f"{formula} = {together.value:.5g} is known to +-{width:.2%}, mu to +-{alone[0]:.2%}, theta to "
        f"+-{alone[1]:.2%} (correlation {correlation:.4f})"
    )
    at_bounds = [name for name in ("mu", "theta") if name in found.at_bounds]
    if at_bounds:
        return [f"mu and theta are not separated, with {' and '.join(at_bounds)} at a bound: {numbers}"]
    apart = abs(correlation) <= COUPLED and max(alone) <= UNDETERMINED - 1.0
    if found.problem.dilation:
        verdict = "are separated by the dilation" if apart else "cannot be separated"
        return [f"mu and theta {verdict}: {numbers}"]
    worse = max(alone) / width if width > 0.0 else np.inf
    verdict = (
        "are separated only by the shape of tau, which depends on the assumed pattern"
        if apart
        else f"cannot be separated; each alone is known {worse:.0f} times worse than the ratio"
    )
    return [f"no dilation: mu and theta {verdict}: {numbers}; measure the dilation or set one of them"]


def _bond(found: Fit) -> str:
    """Sentence on how well strength, rupture energy and stiffness are separated."""
    free = found.problem.free
    names = [name for name in ("sigma0", "Gc", "eta") if name in free]
    numbers = {name: found.estimates[name] for name in names} | {
        "K": found.of(lambda values: material_of(values).K)
    }
    widths = {name: _width(one) for name, one in numbers.items()}
    known = ", ".join(f"{name} {text}" for name, text in widths.items())
    places = [free.index(name) for name in names]
    block = np.abs(found.correlation[np.ix_(places, places)] - np.eye(len(places)))
    wide = any(_is_wide(one) for one in numbers.values())
    if not wide and block.max() <= COUPLED:
        return f"sigma0, Gc and K are separated: {known}"
    sizes, vectors = np.linalg.eigh(found.covariance[np.ix_(places, places)])
    half = found.quantile * float(np.sqrt(max(sizes[0], 0.0)))
    best = _combination(names, vectors[:, 0] * np.sign(vectors[np.argmax(np.abs(vectors[:, 0])), 0]))
    return (
        f"sigma0, Gc and K cannot be separated: {known}; best known is {best}, to +-{half:.2g}. Rows before "
        "the peak determine K, rows at the peak sigma0, rows beyond it Gc"
    )


def _is_wide(one: Estimate) -> bool:
    """Whether an end of the interval is off the value by more than the factor UNDETERMINED."""
    return one.high > UNDETERMINED**2 * one.low


def _width(one: Estimate) -> str:
    """Half width of an interval as a fraction of the value, or the ratio of its ends."""
    if one.high > UNKNOWN * one.low:
        return "not at all"
    if _is_wide(one):
        return f"within a factor of {one.high / one.low:.2g}"
    return f"+-{(one.high - one.low) / (2.0 * one.value):.2%}"


def _pair(found: Fit, i: int, j: int) -> str:
    """Sentence on two correlated parameters and their combination of the smallest variance."""
    free = found.problem.free
    block = found.covariance[np.ix_([i, j], [i, j])]
    sizes, vectors = np.linalg.eigh(block)
    vector = vectors[:, 0] / vectors[0, 0]
    value = float(vector @ found.x[[i, j]])
    half = found.quantile * float(np.sqrt(max(sizes[0], 0.0))) * float(np.linalg.norm(vector))
    return (
        f"{free[i]} and {free[j]} cannot be separated (correlation {found.correlation[i, j]:.4f}): "
        f"{_combination((free[i], free[j]), vector)} = {value:.4g} is known to +-{half:.2g}, "
        f"{transformed(free[i])} to +-{found.quantile * np.sqrt(block[0, 0]):.2g}"
    )


def _combination(names: Sequence[str], weights: Floats) -> str:
    """Text such as 0.7 log mu - 0.7 logit theta/90; terms below a hundredth are left out."""
    least = 0.01 * float(np.abs(weights).max())
    terms = [
        f"{'-' if weight < 0.0 else '+'} {abs(weight):.2g} {transformed(name)}"
        for name, weight in zip(names, weights, strict=True)
        if abs(weight) > least
    ]
    return " ".join(terms).removeprefix("+ ")


def case_text(found: Fit) -> str:
    """Case file with the identified interface and the tests as a sweep; normal springs are left out.

    `asperity card`, `select` and `run` read this file.
    """
    problem = found.problem
    values = {name: f"{value:.6g}" for name, value in found.values.items()}
    longest = max(problem.tests, key=lambda test: float(np.abs(np.diff([0.0, *test.turns])).sum()))
    turns = longest.turns if len(longest.turns) <= MOST_TURNS else _ends(longest)
    held = sorted({float(f"{test.sigma_N:.4g}") for test in problem.tests}, reverse=True)
    several = len(held) > 1
    if KS in values:
        values["kn"] = f"{found.values[KS] * found.values['kc']:.6g}"
    there = ["kn", KS] if KS in values else []
    there += [
        name
        for name in MATERIAL
        if name in values and (found.values[name] or name not in ABSENT) and not (there and name == "kc")
    ]
    material = ", ".join(f"{name} = {values[name]}" for name in there)
    slips = ", ".join(f"{slip:.6g}" for slip in turns)
    increments = ", ".join([str(CASE_INCREMENTS)] * len(turns))
    lines = []
    if any(test.k_N > 0.0 for test in problem.tests):
        lines.append(
            "! The tests had a normal stiffness k_N; this case keeps their initial normal traction constant."
        )
    lines += ["&case title = 'Shear box' /", f"&material {material} /", case_lines(found.interface.pattern)]
    if several:
        lines.append(f"&sweep name = 'sigma_N', values = {', '.join(map(str, held))} /")
    lines += [
        f"&step t_N = {'sigma_N' if several else held[0]}, increments = {CASE_INCREMENTS} /",
        f"&step slip = {slips}, direction = {problem.direction:g}, increments = {increments} /",
    ]
    return "\n".join(lines) + "\n"


def _ends(test: ShearTest) -> list[float]:
    """Largest and smallest slip of a path, in the order of the path, without the start."""
    ends = sorted({int(np.argmax(test.slip)), int(np.argmin(test.slip))})
    return [float(test.slip[i]) for i in ends if i > 0 or len(ends) == 1]
