"""Results of a fit as text, case file, file of the covariance and picture."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ...case_writer import rounded, slip_case
from .model import DEFAULTS, KS, MATERIAL, MORTAR, ROCK, SCALES, UNITS
from .records import NONE
from .result import CONFIDENCE, REFINE, Fit, checks

MOST_TURNS = 20
"""Largest number of reversals that a case repeats, as noise on the slip makes more."""

FORMS = {MORTAR: "mortar joint, with bond", ROCK: "rock joint, without bond"}

MARKS = "osD^v"
"""Marks of the tests in the picture."""


def report(found: Fit, units: tuple[str, str] = NONE, verdict: str = "no result") -> str:
    """Lines of the report: tests, assumptions, measured and fitted numbers, constants, checks.

    verdict: word before the reasons why the fit is no result.
    """
    problem, lines = found.problem, []
    for test in problem.tests:
        load = f"sigma_N {test.sigma_N:g}" + (f", k_N {test.k_N:g}" if test.k_N > 0.0 else "")
        load += "" if test.path_N is None else f" to {test.path_N[-1]:g} as measured"
        seen, turns = "with dilation" if test.s_N is not None else "no dilation", len(test.turns) - 1
        rows = f"{test.slip.size} rows, {seen}, {load}, {turns} reversal{'s' * (turns != 1)}"
        if test.envelope:
            rows = f"peak {test.tau[0]:g}, residual {test.tau[1]:g}, {load}"
        lines.append(f"test        {test.name}: {rows}")
    criteria = ", ".join(f"{name} {one:.5g}" for name, one in found.criteria.items())
    compared = f"; information criterion (BIC): {criteria}" if len(found.criteria) > 1 else ""
    lines.append(f"form        {FORMS[problem.form]}{compared}")
    dilates = problem.is_dilation.any()
    if not dilates and "theta" not in problem.free and not problem.fixed["theta"]:
        lines.append(
            "theta       is not fitted, as no dilation was measured: mu contains the slope of the planes"
        )
    pattern = f"RP-{problem.sides}" if problem.sides > 2 else ("RT" if problem.sides == 2 else "flat")
    given = [
        f", {name} = {value:g}"
        for name, value in problem.fixed.items()
        if (problem.sides > 0 or name not in ("theta", "flat")) and (value or DEFAULTS.get(name) != 0.0)
    ]
    scatter = [f"{name} {one:.2%}" for name, one in zip(("tau", "dilation"), found.scatter, strict=True)]
    lines += [
        f"assumed     {pattern}, slip along {problem.direction:g} degrees{''.join(given)}",
        f"scatter     of the residuals over the range of each test: {', '.join(scatter[: 1 + dilates])}",
        f"starts      sums of squares {', '.join(f'{cost:.4g}' for cost in found.costs)}",
        f"increments  1/{problem.increments * problem.refinement} of a test; divided by {REFINE} they change "
        f"constants by up to {found.shift:.1g} standard errors",
        "",
        f"{'':<14}{'measured':>12}{'fitted':>12}{'difference':>13}",
    ]
    for number, test in enumerate(problem.tests):
        lines.append(f"test {number + 1}, sigma_N {test.sigma_N:g}")
        for name, measured, fitted in found.comparison.loc[number].itertuples():
            change = f"{fitted / measured - 1.0:>13.1%}" if measured else ""
            lines.append(f"  {name:<12}{measured:>12.5g}{fitted:>12.5g}{change}")
    lines += ["", f"{'':<12}{'value':>12}{'low':>12}{'high':>12}  {CONFIDENCE:g} intervals"]
    for name, (value, low, high) in (found.estimates | found.derived).items():
        unit = unit_of(name, units)
        ends = f"{low:>12.5g}{high:>12.5g}  {unit}"
        if name in found.undetermined or not 0.0 < high < 1e6 * max(low, 1e-300):
            ends = f"{'not determined':>24}  {unit}"
        lines.append(f"{name:<12}{value:>12.5g}{ends}")
    told = [f"{verdict if bad else 'note'}: {text}" for bad, text in checks(found)]
    return "\n".join([*lines, "", *told]).rstrip()


def unit_of(name: str, units: tuple[str, str]) -> str:
    """Unit of a constant with these units of length and stress."""
    return UNITS[name].replace("stress", units[1]).replace("length", units[0]).replace("*", " ")


def accepted_text(found: Fit, reasons: Iterable[str]) -> str:
    """What the user has accepted of a fit, for case, covariance and card; empty where there is nothing."""
    tau, dilation = found.deviation
    parts = [f"{100.0 * tau:.2g} % of tau"] + [f"{100.0 * dilation:.2g} % of s_N"] * (dilation > 0.0)
    text = "; ".join([*[f"the law misses the tests by {' and '.join(parts)}"] * (tau > 0.0), *reasons])
    return f"accepted with {text}" if text else ""


def case_of(found: Fit) -> str:
    """Case file with the identified interface and the tests as a sweep; normal springs are left out.

    `asperity card`, `select` and `run` read this file.
    """
    problem, values = found.problem, found.values
    turns = max((test.turns for test in problem.tests), key=lambda one: np.abs(np.diff([0.0, *one])).sum())
    if len(turns) > MOST_TURNS:
        turns = [max(turns, key=abs)]
    material = {name: values[name] for name in MATERIAL if values.get(name, 0.0) or name in problem.free}
    if KS in values:
        material = {"kn": values[KS] * material.pop("kc"), KS: values[KS]} | material
    material = {name: rounded(value, 6) for name, value in material.items()}
    tractions = [rounded(test.sigma_N, 4) for test in problem.tests]
    text = slip_case("Shear box", material, found.interface.pattern, tractions, turns, problem.direction)
    note = "The tests had a normal stiffness k_N; this case keeps their initial normal traction constant."
    return (f"! {note}\n" if any(test.k_N > 0.0 for test in problem.tests) else "") + text


def covariance_text(found: Fit, accepted: str = "") -> str:
    """Content of CASE.fit.json, from which `asperity uncertainty` draws samples; accepted: by the user.

    The covariance is widened as the intervals of the fit are.
    """
    names = found.problem.free
    content = {
        "parameters": names,
        "values": [found.values[name] for name in names],
        "scales": [SCALES[name] for name in names],
        "covariance on the scales": (found.covariance * found.widening**2).tolist(),
        "accepted": accepted,
        "model error of tau and s_N": found.deviation if accepted else (0.0, 0.0),
    }
    return json.dumps(content, indent=1) + "\n"


def file_of(case: Path) -> Path:
    """File beside a case, where `asperity fit` writes the covariance."""
    return case.parent / f"{case.stem}.fit.json"


def draw(found: Fit, units: tuple[str, str], path: Path, of_tests: str = "") -> None:
    """Draw tests and fit over the slip: tau, and s_N where it was measured.

    of_tests: what the tests are where they are curves, which are drawn as dashed lines.
    """
    from ..style import COLOURS, LINES, ONE, TWO, label_axes, new_figure, printed, save

    problem, (length, stress) = found.problem, units
    columns = 1 + any(test.s_N is not None for test in problem.tests)
    rows = zip(problem.tests, problem.paths, found.curves, strict=True)
    with printed():
        figure, axes = new_figure(TWO if columns > 1 else ONE, 3.0, ncols=columns)
        for i, (test, (slips, _), (tau, s_N, done)) in enumerate(rows):
            colour, mark = COLOURS[i % len(COLOURS)], MARKS[i % len(MARKS)]
            label = rf"$\sigma_N$ = {test.sigma_N:g}".replace("-", "−")
            label += f", $k_N$ = {test.k_N:g}" if test.k_N else ""
            for ax, measured, model in zip(axes, (test.tau, test.s_N), (tau, s_N), strict=False):
                if measured is not None and test.envelope:
                    ax.axhline(measured[0], color=colour, linewidth=0.6)
                    ax.plot(test.slip[1:], measured[1:], mark, color=colour, markersize=4.0)
                elif measured is not None:
                    style = {} if of_tests else {"markersize": 2.0, "alpha": 0.5}
                    ax.plot(test.slip, measured, "--" if of_tests else mark, color=colour, **style)
                line = "-" if of_tests else LINES[i % len(LINES)]
                ax.plot(slips[:done], model[:done], line, color=colour, label=label)
        labels = (rf"traction $\tau$ [{stress}]", f"dilation $s_N$ [{length}]")
        for ax, name in zip(axes, labels, strict=False):
            label_axes(ax, f"slip [{length}]", name)
        handles, texts = axes[0].get_legend_handles_labels()
        shown = f"dashed: {of_tests}, solid" if of_tests else "points: test data, lines"
        title = f"{shown}: fit; stresses in {stress}"
        figure.legend(handles, texts, loc="outside upper center", ncols=min(4, len(texts)), title=title)
        save(figure, path)
