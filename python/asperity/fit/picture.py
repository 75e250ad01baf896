"""Picture of a fit."""

from __future__ import annotations

from pathlib import Path

from .outcome import Fit

MARKS = "osD^v"


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
        for i, (test, track, (tau, s_N, done)) in enumerate(rows):
            colour, mark = COLOURS[i % len(COLOURS)], MARKS[i % len(MARKS)]
            label = rf"$\sigma_N$ = {test.sigma_N:g}".replace("-", "−")
            label += f", $k_N$ = {test.k_N:g}" if test.k_N else ""
            for ax, measured, model in zip(axes, (test.tau, test.s_N), (tau, s_N), strict=False):
                if measured is not None and test.envelope:
                    ax.axhline(measured[0], color=colour, linewidth=0.6)
                    ax.plot(test.slip[1:], measured[1:], mark, color=colour, markersize=4.0)
                elif measured is not None and of_tests:
                    ax.plot(test.slip, measured, "--", color=colour)
                elif measured is not None:
                    ax.plot(test.slip, measured, mark, color=colour, markersize=2.0, alpha=0.5)
                line = "-" if of_tests else LINES[i % len(LINES)]
                ax.plot(track.slips[:done], model[:done], line, color=colour, label=label)
        labels = (rf"traction $\tau$ [{stress}]", f"dilation $s_N$ [{length}]")
        for ax, name in zip(axes, labels, strict=False):
            label_axes(ax, f"slip [{length}]", name)
        handles, texts = axes[0].get_legend_handles_labels()
        shown = f"dashed: {of_tests}, solid" if of_tests else "points: test data, lines"
        title = f"{shown}: fit; stresses in {stress}"
        figure.legend(handles, texts, loc="outside upper center", ncols=min(4, len(texts)), title=title)
        save(figure, path)
