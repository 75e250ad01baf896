"""Command `asperity uncertainty`: quantiles of a load case whose constants are uncertain."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ... import contract
from ...case_files import read_case
from ...installed import case_file
from ...model_checks import shown_warnings
from ...options import (
    add_options,
    add_output,
    add_workers,
    check_outputs,
    numbers,
    progress_bar,
    units_of,
    workers,
)
from ..fit.command import NO_RESULT
from ..fit.report import file_of
from .distribution import CONSTANTS, Distribution
from .spread import BATCH, CURVES, RESULTS, Spread, uncertainty

MOST_LEFT_OUT = 0.01  # fraction of samples without a result above which the quantiles must not be used


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
        ("case CASE.nml", "case file with a prescribed slip or opening", case_file),
        ("--fit FILE.json", "written by asperity fit (default: CASE.fit.json, unless --sd is given)", Path),
        ("--sd NAME=VALUE", f"standard deviation (normal, about the value of the case), of {names}", list),
        ("--correlation NAME,NAME=VALUE", "correlation of two of them (default: 0)", list),
        ("--samples SAMPLES", "number of samples", 10_000),
        ("--seed SEED", "of the random numbers", 0),
        ("--quantiles LEVELS", "between 0 and 1", "0.05,0.5,0.95"),
        ("--plot FILE", "draw them, .png or .pdf (default: uncertainty.png)", Path, drawn),
        ("--label-units LENGTH,STRESS", "units for the labels", "length,stress"),
    )
    add_output(parser, "OUT.csv", "write the quantiles of the curves")
    add_workers(parser, "(default: one for each processor)")
    parser.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    levels = [contract.number("--quantiles", text) for text in options.quantiles.split(",")]
    units = units_of(options.label_units)
    read = options.case, options.fit or file_of(options.case)
    table = rf"(\w+,)?(slip|opening),{CURVES[0]}_case,"
    check_outputs(options.force, read, ("-o", options.output, table), ("--plot", options.plot))
    with shown_warnings():
        case = read_case(options.case)
    deviations = {name: deviation for name, (deviation,) in numbers("--sd", options.sd, 1).items()}
    correlations = {}
    for name, (value,) in numbers("--correlation", options.correlation, 1).items():
        pair = tuple(name.split(","))
        if len(pair) != 2:
            raise ValueError(f"--correlation {name}={value:g}: expected NAME,NAME=VALUE")
        correlations[pair] = value
    arguments = deviations, correlations, options.fit, options.samples, options.seed, levels
    with (
        workers(options, os.cpu_count()) as executor,
        progress_bar(options.samples * len(case.runs), "sample") as bar,
    ):
        spreads = uncertainty(case, *arguments, executor, lambda: bar.update(min(BATCH, bar.total - bar.n)))
    print(head(spreads[0].distribution))
    print(f"samples     {options.samples}, seed {options.seed}")
    print(report(case.sweep, spreads))
    if options.output is not None:
        write_curves(options.output, case.sweep, spreads)
        print(options.output)
    if options.plot is not None:
        from .picture import draw

        draw(options.plot, case.title, case.sweep, spreads, units)
        print(options.plot)
    worst = max(spread.left_out for spread in spreads)
    if worst > MOST_LEFT_OUT:
        print(
            f"\nno result: {worst:.2%} of the samples have none, and the quantiles are those of the others: "
            f"expected at most {MOST_LEFT_OUT:.0%}"
        )
    return NO_RESULT if worst > MOST_LEFT_OUT else 0


def head(distribution: Distribution) -> str:
    """Text of a distribution."""
    of_fit = "those of the logarithm, logit or value, as a fit has it"
    kind = of_fit if distribution.transformed else "absolute"
    lines = [f"constants   {distribution.source}; standard deviations are {kind}"]
    if distribution.grade:
        lines.append(f"grade       {distribution.grade}")
    sizes = np.sqrt(np.diag(distribution.covariance))
    for name, value, size in zip(distribution.names, distribution.values, sizes, strict=True):
        lines.append(f"  {name:<10}{value:>12.5g} +- {size:.4g}")
    if any(distribution.model_error):
        tau, dilation = (f"{error:.2g}" for error in distribution.model_error)
        lines.append(f"model error {tau} of the traction, {dilation} of s_N: the law misses the tests by it")
    return "\n".join(lines)


def report(sweep: str, spreads: Sequence[Spread]) -> str:
    """Text of what was left out, and of the quantiles of the results."""
    values = [spread.path.run.value for spread in spreads]
    titles = ["" if value is None else f"{sweep} = {value:g}" for value in values]
    lines = []
    for title, spread in zip(titles, spreads, strict=True):
        reasons = ", ".join(f"{count} {reason}" for reason, count in spread.out.items())
        lines.append("left out    " + ": ".join(filter(None, (title, reasons or "none"))))
    for title, spread in zip(titles, spreads, strict=True):
        names = ("case", "mean", "sd", *(f"{level:.6g}" for level in spread.levels))
        lines += ["", f"{title:<22}" + "".join(f"{name:>12}" for name in names)]
        for name, of_case, values in zip(RESULTS, spread.case[1], spread.results.T, strict=True):
            row = [
                of_case,
                values.mean(),
                (values - values[0]).std(ddof=1),
                *np.quantile(values, spread.levels),
            ]
            label = name if spread.path.slips else name.replace("slip", "opening")
            lines.append(f"{label:<22}" + "".join(f"{value:>12.5g}" for value in row))
    return "\n".join(lines)


def write_curves(path: Path, sweep: str, spreads: Sequence[Spread]) -> None:
    """Write the quantiles of the curves: a row for each point, a column for each curve and level."""
    from pandas import DataFrame, concat

    frames = []
    for spread in spreads:
        columns = {"slip" if spread.path.slips else "opening": spread.path.x[spread.points]}
        columns |= {f"{curve}_case": spread.case[0][spread.points, k] for k, curve in enumerate(CURVES)}
        for k, curve in enumerate(CURVES):
            columns |= {f"{curve}_{v:g}": spread.curves[i, :, k] for i, v in enumerate(spread.levels)}
        frames.append(DataFrame(columns))
        if sweep:  # which may be called slip
            frames[-1].insert(0, sweep, spread.path.run.value, allow_duplicates=True)
    concat(frames).to_csv(path, index=False, float_format="%.7g", lineterminator="\n")
