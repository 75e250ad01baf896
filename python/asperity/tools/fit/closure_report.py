"""Results of a fit of closure tests as a report, a case, rows and a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...case_writer import Group, case_text, rounded
from .closures import ASSUMED_MU, ClosureFit
from .columns import NONE
from .report import (
    INCREMENTS_OF_CASE,
    cell_of,
    comment,
    compared_rows,
    first_upper,
    sheet,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def closure_report(fit: ClosureFit, units: tuple[str, str] = NONE, verbose: bool = False) -> str:
    """Report of a fit of closure tests."""
    rows = sum(len(test.loading) for test in fit.tests)
    pressures = [float(pressure) for test in fit.tests for pressure in test.pressure[test.loading[[0, -1]]]]
    tests = (
        f"{len(fit.tests)} closure test{'s' if len(fit.tests) > 1 else ''}, {rows} rows of loading, "
        f"pressure {min(pressures):.4g} to {max(pressures):.4g} {units[1]}"
    )
    numbers = compared_rows(fit.tests, fit.fitted, fit.blind, verbose, units=units)
    back = [error for error, test in zip(fit.unloading, fit.tests, strict=True) if len(test.unloading)]
    more = ["", f"unloading   predicted, missed by {max(back):.1%} of the closure"] if back else []
    return sheet(tests, [], numbers, fit, units, more)


def closure_case(fit: ClosureFit) -> str:
    """Case file of a flat joint with this contact, which is pressed and released."""
    top = max(float(test.pressure[test.loading[-1]]) for test in fit.tests)
    first = min(float(test.pressure[0]) for test in fit.tests)
    kn = rounded(fit.values["kn"], 6)
    material = {"kn": kn, "ks": kn, "mu": ASSUMED_MU}
    material |= {name: rounded(value, 6) for name, value in fit.values.items() if name == "closure"}
    of_step = {"increments": INCREMENTS_OF_CASE}
    steps: list[Group] = [("step", {"t_N": -rounded(p, 6)} | of_step) for p in (first, top, first)]
    if first <= 0.0:
        steps = steps[1:]
    groups: list[Group] = [("case", {"title": "Closure"}), ("material", material), ("pattern", {"sides": 0})]
    text = case_text(*groups, *steps)
    notes = [first_upper(comment(fit)), "ks and mu are assumed: closure tests do not show them."]
    return "".join(f"! {note}\n" for note in notes) + text


def closure_residuals(fit: ClosureFit) -> str:
    """CSV of the measured closures, those of the law, and the differences over the largest closure."""
    lines = ["test,row,quantity,pressure,measured,fitted,residual_over_range"]
    for test in fit.tests:
        law = fit.curve(test.pressure, float(test.pressure[0]))
        for i, (pressure, closure) in enumerate(zip(test.pressure, test.closure, strict=True)):
            kind = "loading" if i in test.loading else "unloading" if i in test.unloading else "later"
            away = (law[i] - closure) / test.size
            cells = f"{pressure:.7g},{closure:.7g},{law[i]:.7g},{away:.5g}"
            lines.append(f"{cell_of(test.name)},{i + 1},{kind},{cells}")
    return "\n".join(lines) + "\n"


def closure_figure(fit: ClosureFit, units: tuple[str, str]) -> Figure:
    """Pressure over the closure of the tests, and of the law."""
    from ..style import COLOURS, ONE, label_axes, new_figure

    figure, (ax,) = new_figure(ONE, 3.4, ncols=1)
    for i, test in enumerate(fit.tests):
        colour = COLOURS[i % len(COLOURS)]
        parts = (("loading", test.loading, "full"), ("unloading", test.unloading, "none"))
        for label, rows, fill in parts:
            if rows.size:
                style = {"color": colour, "markersize": 4.0, "fillstyle": fill}
                label = label if i == 0 else ""
                ax.plot(test.closure[rows], test.pressure[rows], "o", label=label, **style)
        first, top = test.pressure[0], test.pressure[test.loading[-1]]
        fine = np.linspace(first, top, 100)
        ax.plot(fit.curve(fine, float(first)), fine, color=colour, label="law" if i == 0 else "")
    ax.locator_params(axis="x", nbins=6)
    label_axes(ax, f"closure since the first row [{units[0]}]", f"pressure [{units[1]}]")
    ax.legend()
    return figure
