"""Command `asperity uncertainty`: quantiles of a load case whose constants are uncertain."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .. import contract
from ..case_files import Case, read_case
from ..fit.command import NO_RESULT
from ..fit.report import file_of
from ..options import (
    add_options,
    add_output,
    add_workers,
    check_outputs,
    numbers,
    progress_bar,
    units_of,
    workers,
)
from ..remarks import shown_warnings
from .distribution import CONSTANTS, Distribution, distribution_of
from .paths import CURVES
from .spread import BATCH, RESULTS, Spread, check_samples, spreads

MOST_LEFT_OUT = 0.01
"""Fraction of samples without a result above which the quantiles must not be used."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    parser.description = (
        "Draw the uncertain constants of a case, run its load path with each sample, and report quantiles of "
        "the curves, of peak, end and work. The uncertainty is that of a fit, which asperity fit -o CASE.nml "
        "writes to CASE.fit.json, or is given by --sd. Samples without a result are counted; if they are "
        f"more than {MOST_LEFT_OUT:.0%}, the exit code is {NO_RESULT}."
    )
    names = ", ".join(CONSTANTS)
    drawn = {"nargs": "?", "const": Path("uncertainty.png")}
    add_options(
        parser,
        ("case CASE.nml", "case file with a prescribed slip or opening", Path),
        ("--fit FILE.json", "written by asperity fit (default: CASE.fit.json, unless --sd is given)", Path),
        ("--sd NAME=VALUE", f"standard deviation (normal, about the value of the case), of {names}", list),
        ("--correlation NAME,NAME=VALUE", "correlation of two of them (default: 0)", list),
        ("--samples SAMPLES", "number of samples", 10_000),
        ("--seed SEED", "of the random numbers", 0),
        ("--quantiles LEVELS", "between 0 and 1", "0.05,0.5,0.95"),
        ("--plot FILE", "draw them, .png or .pdf (default: uncertainty.png)", Path, drawn),
        ("--label-units LENGTH,STRESS", "units for the labels", "mm,MPa"),
    )
    add_output(parser, "OUT.csv", "write the quantiles of the curves")
    add_workers(parser)
    parser.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    levels = [contract.number("--quantiles", text) for text in options.quantiles.split(",")]
    check_samples(options.samples, options.seed, levels)
    units = units_of(options.label_units)
    read = options.case, options.fit or file_of(options.case)
    table = rf"(\w+,)?(slip|opening),{CURVES[0]}_case,"
    check_outputs(options.force, read, ("-o", options.output, table), ("--plot", options.plot))
    with shown_warnings():
        case = read_case(options.case)
    deviations = {name: one for name, (one,) in numbers("--sd", options.sd, 1).items()}
    correlations = _correlations(options.correlation)
    distribution, source = distribution_of(case, options.fit, deviations, correlations)
    given = distribution, options.samples, options.seed, levels
    with (
        workers(options, os.cpu_count()) as executor,
        progress_bar(options.samples * len(case.runs), "sample") as bar,
    ):
        found = spreads(case, *given, executor, lambda: bar.update(min(BATCH, bar.total - bar.n)))
    print(report(case, distribution, source, options.samples, options.seed, found))
    if options.output is not None:
        write_curves(options.output, case.sweep, found)
        print(options.output)
    if options.plot is not None:
        from .picture import draw

        draw(options.plot, case.title, case.sweep, found, units)
        print(options.plot)
    worst = max(one.left_out for one in found)
    if worst > MOST_LEFT_OUT:
        print(
            f"\nno result: {worst:.2%} of the samples have none, and the quantiles are those of the others: "
            f"expected at most {MOST_LEFT_OUT:.0%}"
        )
        return NO_RESULT
    return 0


def _correlations(texts: Sequence[str]) -> dict[tuple[str, str], float]:
    """Correlations by the pair of names."""
    found = {}
    for name, (value,) in numbers("--correlation", texts, 1).items():
        first, comma, second = name.partition(",")
        if not comma:
            raise ValueError(f"--correlation {name}={value:g}: expected NAME,NAME=VALUE")
        found[first.strip(), second.strip()] = value
    return found


def report(
    case: Case, distribution: Distribution, source: str, samples: int, seed: int, found: Sequence[Spread]
) -> str:
    """Text with the samples, what was left out, and the quantiles of the results."""
    deviations = np.sqrt(np.diag(distribution.covariance))
    kind = (
        "those of the logarithm, logit or value, as a fit has it" if distribution.transformed else "absolute"
    )
    lines = [f"constants   {source}; standard deviations are {kind}"]
    for name, value, size in zip(distribution.names, distribution.values, deviations, strict=True):
        lines.append(f"  {name:<10}{value:>12.5g} +- {size:.4g}")
    if any(distribution.model_error):
        tau, dilation = distribution.model_error
        lines.append(
            f"model error {tau:.2g} of the traction, {dilation:.2g} of s_N: by which the law misses the tests"
        )
    lines.append(f"samples     {samples}, seed {seed}")
    for one in found:
        head = "" if one.path.value is None else f"{case.sweep} = {one.path.value:g}: "
        out = [f"{count} out of the range of {name}" for name, count in one.refused.items()]
        out += [f"{one.lost} without equilibrium on the whole path"] if one.lost else []
        lines.append(f"left out    {head}{', '.join(out) or 'none'}")
    for one in found:
        title = "" if one.path.value is None else f"{case.sweep} = {one.path.value:g}"
        names = [f"{level:.6g}" for level in one.levels]
        lines += ["", f"{title:<22}" + "".join(f"{name:>12}" for name in ("case", "mean", "sd", *names))]
        table = zip(RESULTS, one.case[1], one.results.T, strict=True)
        for name, own, values in table:
            row = [own, values.mean(), (values - values[0]).std(ddof=1), *np.quantile(values, one.levels)]
            label = name if one.path.slips else name.replace("slip", "opening")
            lines.append(f"{label:<22}" + "".join(f"{value:>12.5g}" for value in row))
    return "\n".join(lines)


def write_curves(path: Path, sweep: str, found: Sequence[Spread]) -> None:
    """Write the quantiles of the curves: a row for each point, a column for each curve and level."""
    names = [f"{curve}_{level:g}" for curve in CURVES for level in found[0].levels]
    start = ["slip" if found[0].path.slips else "opening", *(f"{curve}_case" for curve in CURVES)]
    parts = []
    for one in found:
        curves = one.curves.transpose(1, 2, 0).reshape(len(one.points), -1)
        rows = np.column_stack([one.path.x[one.points], one.case[0][one.points], curves])
        value = [] if one.path.value is None else [one.path.value]
        parts.append(np.insert(rows, [0] * len(value), value, axis=1))
    header = ",".join([*([sweep] if sweep else []), *start, *names])
    np.savetxt(path, np.vstack(parts), "%.7g", ",", header=header, comments="", encoding="utf-8")
