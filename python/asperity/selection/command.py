"""Command `asperity select`: the pattern that a load case needs, and the map of the planes needed."""

from __future__ import annotations

import argparse
import csv
import os
import sys
import warnings
from concurrent.futures import Executor
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path

import numpy as np

from ..case_files import SlipTest, read_case, slip_tests
from ..material import Material, ModelWarning
from ..options import add_workers, check_picture, progress_bar, workers
from ..parallel import map_in_order
from ..pattern import Pattern
from ..remarks import shown_warnings, warn_of_physics
from ..steps import turns_of
from .search import (
    REFERENCE_SIDES,
    Errors,
    LoadCase,
    NoPatternError,
    Search,
    Selection,
    select,
)
from .timings import Timing, measure, read_timings

BAD_INPUT = 1

TOLERANCE = 0.01
"""Largest error where none is given."""

FEW_PLANES = 5
"""Largest number of planes of the listed patterns that miss the tolerance; the last one is always listed."""

KERNELS = (("UMAT", "umat", True), ("VUMAT", "block", False))
"""Costs in the report: host, kernel of the benchmark, whether with tangent."""

MAP_TOLERANCES = (0.01, 0.001)
MAP_MU = (0.0, 0.25, 0.5, 0.75)
MAP_THETA = (10.0, 20.0, 30.0, 40.0)
MAP_SIGMA_N = (0.0, -1.0, -5.0, -10.0)
"""Grid of the map: friction, inclination (degrees), normal traction (MPa) at Table 2."""

MAP_TURNS = (0.6,)
"""Slip path of the map, mm."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    parser.add_argument(
        "case",
        nargs="?",
        type=Path,
        metavar="CASE.nml",
        help="case file of the driver: t_N, then slip under it; a sweep gives the stress range",
    )
    parser.add_argument(
        "--tolerance",
        type=float,
        metavar="ERROR",
        help=f"largest error of traction, dilation and residual strength (default: {TOLERANCE})",
    )
    parser.add_argument(
        "--planar",
        action="store_true",
        help="the surface is a ridge and slips across it, along the direction of the case only",
    )
    parser.add_argument(
        "--bench",
        type=Path,
        metavar="BENCH.csv",
        help="costs from bench --csv (default: run bench --quick now)",
    )
    parser.add_argument(
        "--map",
        action="store_true",
        help="instead of a case: draw the planes needed over mu, theta and sigma_N",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="the case with the selected pattern, for run and card; with --map the picture, .png or .pdf, "
        "beside which a CSV is written",
    )
    add_workers(parser, "threads, one for each processor; with --map processes")
    parser.set_defaults(action=_run)


def read_load_case(path: Path, planar: bool = False) -> LoadCase:
    """Read the load case from a case file of the driver; a sweep may give several sigma_N or directions.

    Raises ValueError with the messages of the driver, and for a case that is not a slip under a constant t_N.
    Doubts about the joint are a ModelWarning.
    """
    tests = list(slip_tests(read_case(path)))
    first = tests[0]
    if any((test.material, test.pattern) != (first.material, first.pattern) for test in tests):
        raise ValueError(
            f"{path}: &sweep: expected one over sigma_N or direction, of one surface and material"
        )
    if first.pattern.m < 0:
        raise ValueError(
            f"{path}: &pattern: expected sides, theta and flat; with listed planes there is nothing to select"
        )
    turns = _turns(first)
    if len(turns) == 0 or any(_turns(test) != turns for test in tests):
        raise ValueError(f"{path}: expected &step with t_N, then with slip, the same path in every run")
    if planar and any(test.direction != first.direction for test in tests):
        raise ValueError(f"{path}: expected one direction for a planar load case")
    slip = max(abs(test.slips).max(initial=0.0) for test in tests)
    warn_of_physics(first.material, first.pattern, *(test.sigma_N for test in tests), slip=slip)
    return LoadCase(
        first.material,
        first.pattern.theta if first.pattern.m else 0.0,
        tuple(dict.fromkeys(test.sigma_N for test in tests)),
        turns,
        first.pattern.flat,
        planar,
        first.direction,
    )


def _turns(test: SlipTest) -> tuple[float, ...]:
    """Slips at the reversals of a path, and its last slip."""
    path = np.append(0.0, test.slips)
    return tuple(path[turns_of(path)[1:]].tolist()) if path.any() else ()


@dataclass(frozen=True)
class Costs:
    """Nanoseconds per point and update over the number of planes: a line fitted to the benchmark."""

    lines: dict[str, tuple[float, float]]

    def of(self, host: str, planes: int) -> float:
        """Cost of a pattern, ns."""
        constant, slope = self.lines[host]
        return constant + slope * planes


def read_costs(path: Path | None) -> Costs:
    """Read costs from a CSV of the benchmark, or measure them now.

    Raises ValueError if the CSV has no rows of a kernel.
    """
    timings = measure("--quick", "--costs", quiet=True) if path is None else read_timings(path)
    source = str(path or "bench")
    return Costs({host: _line(timings, kernel, tangent, source) for host, kernel, tangent in KERNELS})


def _line(timings: list[Timing], kernel: str, tangent: bool, source: str) -> tuple[float, float]:
    """Constant and slope of the cost over the planes, by least squares of the relative errors."""
    rows = [
        (t.planes, t.ns_per_point)
        for t in timings
        if (t.kernel, t.precision, t.tangent, t.states) == (kernel, "double", tangent, "slip")
    ]
    if len({planes for planes, _ in rows}) < 2:
        raise ValueError(f"{source}: expected rows of the kernel {kernel} for two patterns")
    planes, times = np.array(rows).T
    slope, constant = np.polyfit(planes, times, 1, w=1.0 / times)
    return float(constant), float(slope)


def _run(options: argparse.Namespace) -> int:
    """Select a pattern for a load case, or draw the map."""
    if options.map:
        if options.case is not None:
            raise ValueError(f"--map: expected without {options.case}")
        if options.planar or options.tolerance is not None or options.bench is not None:
            raise ValueError(
                "--map: expected without --planar, --tolerance and --bench, which belong to a case"
            )
        with workers(options, os.cpu_count()) as executor:
            return _map(options.output or Path("select.png"), executor)
    if options.case is None:
        raise ValueError("expected CASE.nml or --map")
    if options.output is not None and options.output.resolve() == options.case.resolve():
        raise ValueError(f"-o {options.output}: expected another name than that of the case that is read")
    with shown_warnings():
        case = read_load_case(options.case, options.planar)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelWarning)  # already reported
        costs = read_costs(options.bench)
        with workers(options) as executor, progress_bar(REFERENCE_SIDES, "pattern") as bar:
            try:
                answer = select(
                    case,
                    TOLERANCE if options.tolerance is None else options.tolerance,
                    lambda name: (bar.update(), bar.set_postfix_str(name)),
                    executor,
                )
            except NoPatternError as error:
                bar.close()
                print(f"asperity: {options.case}: {error}", file=sys.stderr)
                return BAD_INPUT
    print(report(answer, costs))
    if options.output is not None:
        write_case(options.case, answer.pattern, options.output)
        print(options.output)
    return 0


def write_case(source: Path, pattern: Pattern, output: Path) -> None:
    """Write the case of a file with another pattern."""
    from ..surface.command import case_lines

    case = read_case(source)
    output.write_bytes(case.before + case_lines(pattern).encode() + case.after)


def report(answer: Selection, costs: Costs) -> str:
    """Text of the load case, the candidates, the selected pattern, and its line of PROPS."""
    case = answer.case
    path = " to ".join(f"{slip:g}" for slip in (0.0, *case.turns))
    quality = "the surface itself" if case.planar else f"good to {answer.uncertainty:.1e}"
    where = f"along {case.direction:g} degrees, across a ridge" if case.planar else "in any direction"
    lines = [
        f"load case  sigma_N {', '.join(f'{value:g}' for value in case.sigma_N)}; slip {path} {where}",
        f"surface    theta {case.theta:g} degrees, flat fraction {case.flat:g}, mu {case.material.mu:g}",
        f"reference  {answer.reference}, {quality}; tolerance {answer.tolerance:g}",
        *(
            f"lost       sigma_N {sigma_N:g}: no equilibrium beyond a path of {length:.3g}; compared up to it"
            for sigma_N, length in answer.lost
        ),
        "",
        f"{'pattern':<10}{'planes':>6}" + "".join(f"{field.name:>12}" for field in fields(Errors)),
    ]
    *missed, _ = answer.tried
    shown = [one for one in missed if one.planes <= FEW_PLANES or one is missed[-1]]
    lines += [_row(one.name, one.planes, one.errors) for one in shown]
    lines += [_row(answer.name, answer.planes, answer.errors) + "  meets it, checked", ""]
    for host, _, _ in KERNELS:
        mine, dense = costs.of(host, answer.planes), costs.of(host, REFERENCE_SIDES + 1)
        lines.append(
            f"{host:<11}{mine:.0f} ns per point, {dense / mine:.1f} times less than RP-{REFERENCE_SIDES}"
        )
    props = answer.props()
    return "\n".join(
        [*lines, f"PROPS({len(props)})   " + ", ".join(f"{value!r}" for value in props.tolist())]
    )


def _row(name: str, planes: int, errors: Errors) -> str:
    values = (getattr(errors, field.name) for field in fields(errors))
    texts = ("-" if np.isnan(value) else f"{value:.1e}" for value in values)
    return f"{name:<10}{planes:>6}" + "".join(f"{text:>12}" for text in texts)


def planes_needed(tolerances: tuple[float, ...], case: LoadCase) -> list[Selection | None]:
    """Selected pattern for each tolerance, or None."""
    search = Search(case)
    found: list[Selection | None] = []
    for tolerance in tolerances:
        try:
            found.append(search.select(tolerance))
        except NoPatternError:
            found.append(None)
    return found


def _map(output: Path, executor: Executor | None) -> int:
    """Write a picture and a CSV of the planes needed over mu, theta and sigma_N."""
    check_picture(output)
    grid = [(s, m, t) for s in MAP_SIGMA_N for m in MAP_MU for t in MAP_THETA]
    cases = [LoadCase(Material(3.0, 0.3, 0.9, mu), theta, (held,), MAP_TURNS) for held, mu, theta in grid]
    with progress_bar(len(grid), "load case") as bar:
        found_in = map_in_order(partial(planes_needed, MAP_TOLERANCES), cases, executor, bar.update)
    rows = [(*place, found) for place, found in zip(grid, found_in, strict=True)]
    with output.with_suffix(".csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["sigma_N", "mu", "theta", "tolerance", "pattern", "planes", "error"])
        for sigma_N, mu, theta, found in rows:
            for tolerance, one in zip(MAP_TOLERANCES, found, strict=True):
                cells = (one.name, one.planes, f"{one.errors.worst:.2e}") if one else ("none", "", "")
                writer.writerow([sigma_N, mu, theta, tolerance, *cells])
    _draw_map(rows, output)
    print(f"{output}\n{output.with_suffix('.csv')}")
    return 0


def _draw_map(rows: list[tuple[float, float, float, list[Selection | None]]], output: Path) -> None:
    """Draw the planes needed as numbers on colours, with a row of panels for each tolerance."""
    import matplotlib.pyplot as plt

    most = REFERENCE_SIDES + 1
    shape = (len(MAP_TOLERANCES), len(MAP_SIGMA_N))
    figure, axes = plt.subplots(
        *shape, figsize=(10.0, 5.6), layout="constrained", sharex=True, sharey=True, squeeze=False
    )
    for i, tolerance in enumerate(MAP_TOLERANCES):
        for j, sigma_N in enumerate(MAP_SIGMA_N):
            planes = np.full((len(MAP_MU), len(MAP_THETA)), most)
            for pressure, mu, theta, found in rows:
                if pressure == sigma_N and found[i] is not None:
                    planes[MAP_MU.index(mu), MAP_THETA.index(theta)] = found[i].planes
            ax = axes[i, j]
            picture = ax.imshow(planes, origin="lower", cmap="cividis", vmin=1, vmax=most, aspect="auto")
            for (row, column), value in np.ndenumerate(planes):
                text = f"> {most - 1}" if value == most else str(value)
                dark = value < most / 2
                ax.text(column, row, text, ha="center", va="center", color="white" if dark else "black")
            ax.set_xticks(range(len(MAP_THETA)), [f"{value:g}" for value in MAP_THETA])
            ax.set_yticks(range(len(MAP_MU)), [f"{value:g}" for value in MAP_MU])
            ax.set_title(rf"$\sigma_N$ = {sigma_N:g} MPa, {100 * tolerance:g} %", fontsize="medium")
            if i == shape[0] - 1:
                ax.set_xlabel(r"inclination $\theta$ [°]")
            if j == 0:
                ax.set_ylabel(r"friction $\mu$ [-]")
    figure.colorbar(picture, ax=axes, label="planes needed [-]")
    figure.savefig(output, dpi=150)
    plt.close(figure)
