"""The figures and tables of the paper, a row for each with cases and findings."""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from asperity.cli import execute
from asperity.options import add_options, add_output, add_workers, check_outputs, progress_bar, workers
from asperity.parallel import map_in_order
from asperity.tools import style
from asperity.tools.tables import markdown
from matplotlib.figure import Figure
from pandas import DataFrame
from scipy.integrate import trapezoid

from . import outcome
from .fracture_energy import MATERIAL, TABLE_5, fracture_energy, pattern, sampled
from .outcome import FIVE, ROUNDING, Case, curve_rows, percent, run_case

SIGMA_N, THETA_M, THETA_L = r"$\sigma_N$ [MPa]", r"$\theta_m$ [°]", r"$\theta_L$ [°]"
ENERGIES = f"{THETA_M}, {style.ENERGY}"
LABELS = {"tau_L": style.TRACTION, "s_N": style.DILATION}

Outcome = tuple[Figure | None, Iterable[str], DataFrame]
"""Picture (None: a table), findings, and the rows of the CSV."""


@dataclass(frozen=True)
class Entry:
    """A figure or table of the paper.

    stem: name of the files, and of the markers of a page.  cases: stems of the case files, whose results are
    the arguments of `make`, which computes and draws.
    """

    stem: str
    cases: tuple[str, ...]
    make: Callable[..., Outcome]


def over_slip(
    labels: str, finding: Callable[[Case], str], *columns: str, inside: bool = False
) -> Callable[..., Outcome]:
    """Curves of columns (tau_L) over the slip, a panel for each case or column; labels: what the labels are.

    inside: whether a legend inside the part of the diagram with small slips has the labels and the energies.
    """

    def make(*cases: Case) -> Outcome:
        panels, several = [(case, y) for case in cases for y in columns or ["tau_L"]], len(cases) > 1
        size = (style.TWO, 2.9 if several else 2.6) if len(panels) > 1 else (1.3 * style.ONE, 3.0)
        figure, axes = style.new_figure(*size, ncols=len(panels), sharey=several)
        for ax, part, (case, y) in zip(axes, "ab", panels, strict=False):
            names = [f"{c.name}, {c.energy:.4f}" if inside else c.name for c in case.curves]
            lines = [(n, c.s_L, getattr(c, y), c.lost) for n, c in zip(names, case.curves, strict=True)]
            shown = labels if inside or ax is axes[-1] else ""
            style.curves(ax, lines if several else style.merged(lines), style.SLIP, LABELS[y], shown, inside)
            if inside:
                ax.set_xlim(-0.005, 0.25)
            if several:
                letter = "" if inside else f"({part}) "
                ax.set_title(rf"{letter}$\theta_L$ = {case.curves[0].test.direction:g}°")
        findings = [f"*{case.name}*: {finding(case)}" if several else finding(case) for case in cases]
        return figure, findings, curve_rows(cases)

    return make


def isotropy(*cases: Case) -> Outcome:
    """A row for each pattern: curves in several directions on the left, energy on the right."""
    figure = Figure(figsize=(style.TWO, 2.7 * len(cases)), layout="constrained")
    for i, case in enumerate(cases):
        left = figure.add_subplot(len(cases), 2, 2 * i + 1)
        right = figure.add_subplot(len(cases), 2, 2 * i + 2, projection="polar")
        lines = [(c.name, c.s_L, c.tau_L, c.lost) for c in case.curves]
        style.curves(left, style.merged(lines), style.SLIP, style.TRACTION, THETA_L)
        left.set_title(rf"{case.name}, $\sigma_N$ = −5 MPa")
        energy = fracture_energy(MATERIAL, pattern(case.name))
        title = rf"{case.name}, {style.ENERGY} at $\sigma_N$ = 0, radius from 0.28"
        style.polar(right, energy.directions, energy.values, (0.28, 0.37), title)
    return figure, [f"*{case.name}*: {outcome.spread(case)}" for case in cases], curve_rows(cases)


def _figure_2(case: Case) -> Outcome:
    (curve,) = case.curves
    m = curve.test.material
    s, t = curve.s_N, curve.t_N
    triangle = np.interp(s, [0.0, m.s_0, m.s_f, s[-1]], [0.0, m.sigma0, 0.0, 0.0])
    figure, (ax,) = style.new_figure(style.ONE, 2.3)
    style.curves(ax, [("", s, t, False)], "opening $s_N$ [mm]", r"traction $\sigma_N$ [MPa]")
    ax.plot([m.s_0, m.s_f], [m.sigma0, 0.0], "o", color=style.COLOURS[1], markersize=5)
    ax.text(m.s_0 + 0.006, m.sigma0, r"$(s_0, \sigma_0)$")
    ax.text(m.s_f, 0.12, "$s_f$", ha="center")
    ax.text(0.075, 0.6, "area $G_c$")
    off = float(np.abs(t - triangle).max())
    text = (
        f"The largest traction is {t.max():.6g} MPa, the area {trapezoid(t, s):.6g} N/mm, the largest "
        f"difference from the triangle {f'{off:.0e}' if off > ROUNDING else f'below {ROUNDING:.0e}'} MPa."
    )
    return figure, [text], DataFrame({"s_N": s, "t_N": t})


def _figure_10(*cases: Case) -> Outcome:
    figure, axes = style.new_figure(style.TWO, 2.9, ncols=2)
    findings = []
    for ax, pair, title in zip(axes, (cases[:2], cases[2:]), ("(a) monotonic", "(b) cyclic"), strict=True):
        ratios = []
        whole = zip(*([c for c in case.curves if not c.lost] for case in pair), strict=True)
        for colour, (along_axis, diagonal) in zip(style.COLOURS, whole, strict=False):
            ax.plot(along_axis.s_L, along_axis.tau_L, "-", color=colour, label=along_axis.name)
            ax.plot(diagonal.s_L, diagonal.tau_L, "--", color=colour)
            ratios.append(f"{along_axis.name}: {along_axis.tau_L.max() / diagonal.tau_L.max():.3f}")
        title += f", η = {pair[0].curves[0].test.material.eta:g}"
        style.label_axes(ax, style.SLIP, style.TRACTION)
        ax.set_title(f"{title}; — 0°, - - 45°")
        style.label_ends(ax, SIGMA_N)
        findings.append(f"*{title}*: {', '.join(ratios)}.")
    return figure, findings, curve_rows(cases)


def _figure_12(case: Case) -> Outcome:
    pairs = [(c.test.value, c.energy) for c in case.curves]
    converged = fracture_energy(MATERIAL, FIVE)
    figure, (ax,) = style.new_figure(style.ONE, 3.2, subplot_kw={"projection": "polar"})
    style.polar(ax, converged.directions, converged.values, (0.32, 0.35), f"{style.ENERGY}, radius from 0.32")
    texts = [
        f"{energies.min():.6f} to {energies.max():.6f} N/mm, spread {percent(energies)}"
        for energies in (np.array([energy for _, energy in pairs]), converged.values)
    ]
    text = f"With steps of 0.0025 mm, in 24 directions: {texts[0]}. Converged, in 64 directions: {texts[1]}."
    return figure, [text], DataFrame(pairs, columns=["theta_L", "G_T"])


def _table_5() -> Outcome:
    kinds, cells = ("max", "min", "ratio"), []
    for name, (_, *printed) in TABLE_5.items():
        energy = fracture_energy(MATERIAL, pattern(name))
        converged = energy.values.max(), energy.values.min(), energy.values.max() / energy.values.min()
        cells.append([name, *printed, *sampled(name), *converged, energy.error.max()])
    names = [f"{source}_{kind}" for source in ("paper", "sampled", "converged") for kind in kinds]
    table = DataFrame(cells, columns=["pattern", *names, "error"])
    rows: list[Sequence[str]] = []
    for kind in kinds:
        rows.append([f"paper, {kind}", *table[f"paper_{kind}"]])
        rows.append([f"converged, {kind}", *table[f"converged_{kind}"].map("{:.6f}".format)])
    equal = sum((table[f"paper_{kind}"] == table[f"sampled_{kind}"]).sum() for kind in kinds)
    texts = (
        f"\n{markdown(['', *TABLE_5], rows, numbers=True)}\n",
        "A sampling with steps of 0.0025 mm, 64 directions, and the trapezoidal rule over $s_L$ = 0 and "
        f"every tenth point from 0.0225 mm on gives {equal} of the 15 printed numbers to the last digit.",
        "For the converged values the steps are halved until no energy changes by more than 3e-7 N/mm.",
    )
    return None, texts, table


MONOTONIC = ("figure07a_08a_10a", "figure07b_08b_10a")
CYCLIC = ("figure09a_10b", "figure09b_10b")

ENTRIES = (
    Entry("figure02", ("figure02",), _figure_2),
    Entry("figure04a", ("figure04a",), over_slip(SIGMA_N, outcome.ends)),
    Entry("figure04b", ("figure04b",), over_slip(THETA_M, outcome.ends)),
    Entry("figure05a", ("figure05a",), over_slip(SIGMA_N, outcome.ends)),
    Entry("figure05b", ("figure05b",), over_slip("", outcome.strokes, "tau_L", "s_N")),
    Entry("figure07", MONOTONIC, over_slip(SIGMA_N, outcome.ends)),
    Entry("figure08", MONOTONIC, over_slip(SIGMA_N, outcome.climb, "s_N")),
    Entry("figure09", CYCLIC, over_slip(SIGMA_N, outcome.strokes)),
    Entry("figure10", (*MONOTONIC, *CYCLIC), _figure_10),
    Entry("figure11", ("figure11",), over_slip(THETA_L, outcome.spread)),
    Entry("figure12", ("figure12",), _figure_12),
    Entry("figure13a", ("figure13a_00", "figure13a_45"), over_slip(ENERGIES, outcome.energies, inside=True)),
    Entry("figure13b", ("figure13b_00", "figure13b_45"), over_slip(ENERGIES, outcome.energies, inside=True)),
    Entry("figure15", ("figure15a", "figure15b", "figure15c"), isotropy),
    Entry("figure16", ("figure16a", "figure16b"), isotropy),
    Entry("table5", (), _table_5),
)
"""Figures with computed curves, and Table 5, in the order of the paper."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command with arguments, or with those of the command line, and return its exit code."""
    summary = "Recompute the figures and tables of the paper."
    paper = argparse.ArgumentParser(prog="python -m harness.studies.paper", description=summary)
    add_output(paper, "DIR", "folder of the pictures and the numbers", Path("gallery"))
    add_options(
        paper,
        ("--figure NUMBER", "only these, such as 4a or table5 (default: all)", str, {"nargs": "+"}),
    )
    add_workers(paper)
    paper.set_defaults(action=_action)
    return execute(paper, sys.argv[1:] if arguments is None else arguments)


def _action(options: argparse.Namespace) -> int:
    wanted = select(options.figure or [])
    with workers(options, os.cpu_count()) as executor:
        findings = write(wanted, options.output, executor, options.force)
    print("\n".join(f"{name}\n{text}" for name, text in findings.items()))
    print(options.output)
    return 0


def select(numbers: Sequence[str]) -> list[Entry]:
    """Entries by their numbers, all without numbers; raises ValueError for an unknown number."""
    known = {entry.stem.removeprefix("figure").lstrip("0"): entry for entry in ENTRIES}
    for number in numbers:
        if number not in known:
            raise ValueError(f"--figure {number}: expected one of {', '.join(known)}")
    return [entry for number, entry in known.items() if number in numbers or not numbers]


def write(
    entries: Sequence[Entry], folder: Path, executor: Executor | None = None, force: bool = True
) -> dict[str, str]:
    """Write pictures and numbers of entries into a folder; return their findings by the names of the files.

    executor: as in `map_in_order`; without one, one entry after the other.  force: as in `check_outputs`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    # the last entries take longest, so they start first
    numbers = [ENTRIES.index(entry) for entry in reversed(entries)]
    with progress_bar(len(entries), "figure") as bar:
        made = map_in_order(_make_entry, numbers, executor or ThreadPoolExecutor(1), bar.update)[::-1]
    contents = {folder / name: content for files, _ in made for name, content in files.items()}
    for path, content in contents.items():
        header = [re.escape(content.decode().partition("\n")[0])] if path.suffix == ".csv" else []
        check_outputs(force, [], ("-o", path, *header))
    for path, content in contents.items():
        path.write_bytes(content)
    return {entry.stem: text for entry, (_, text) in zip(entries, made, strict=True)}


def _make_entry(number: int) -> tuple[dict[str, bytes], str]:
    """Files of one entry by name, picture and numbers, and its findings as a list in Markdown."""
    entry, files = ENTRIES[number], {}
    with style.printed():
        figure, findings, rows = entry.make(*map(run_case, entry.cases))
        if figure is not None:
            files[f"{entry.stem}.png"] = style.encoded(figure, ".png")
    numeric = rows.select_dtypes("number")
    rows[numeric.columns] = numeric.where(numeric.abs() > ROUNDING, 0)
    files[f"{entry.stem}.csv"] = rows.to_csv(index=False, float_format="%.6g", lineterminator="\n").encode()
    # a table stands by itself
    return files, "\n".join(text if text.startswith("\n") else f"- {text}" for text in findings)
