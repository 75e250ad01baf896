"""Command `asperity`. Only the module of the chosen subcommand is imported."""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path

from .installed import cases, driver, named_case
from .results import NO_EQUILIBRIUM, read_rows, results_of

DIFFERS, BAD_INPUT = 1, 1
"""Exit codes."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return the exit code, 0 for success."""
    arguments = sys.argv[1:] if arguments is None else arguments
    # The matrices are small, so further threads of BLAS would only wait, which costs a fit 6 % of its time.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # pictures are written to files, on machines without a display, too
    os.environ.setdefault("MPLBACKEND", "Agg")
    if "_ARGCOMPLETE" in os.environ:
        _complete()
    options = _parser(next((text for text in arguments if text in COMMANDS), "")).parse_args(arguments)
    options.arguments = list(arguments)
    try:
        code = int(options.action(options))
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        # the reader, such as head, has all it wants; the flush at the exit of Python must not fail either
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (OSError, ValueError) as error:
        named = isinstance(error, OSError) and error.filename is not None
        print(f"asperity: {f'{error.filename}: {error.strerror}' if named else error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        return 130


def _complete() -> None:
    """Answer the shell, which asks how the words on its command line go on, and exit."""
    import argcomplete

    words = os.environ.get("COMP_LINE", "").split()
    argcomplete.autocomplete(_parser(next((text for text in words if text in COMMANDS), "")))


class _Version(argparse.Action):
    """Print the version of the library and exit."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from . import __version__

        print(f"asperity {__version__}")
        parser.exit()


class _Help(argparse.HelpFormatter):
    """Help with room for the longest command, whose indent argparse does not count."""

    def __init__(self, prog: str) -> None:
        """Set the length of the longest entry."""
        super().__init__(prog)
        self._action_max_length = INDENT + max(map(len, COMMANDS))


def _parser(chosen: str) -> argparse.ArgumentParser:
    """Parser of all subcommands, with the arguments of the chosen one."""
    parser = argparse.ArgumentParser(
        prog="asperity",
        description="Interface law for rough quasi-brittle interfaces: damage, friction, interlocking.",
        formatter_class=_Help,
    )
    others = [name for name in COMMANDS if name in MAINTAINERS]
    parser.epilog = (
        f"Commands that make the pages and the tests of this project: {', '.join(others)}. "
        "asperity COMMAND --help explains a command."
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="show program's version number and exit")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, (summary, add_arguments) in COMMANDS.items():
        listed = {} if name in MAINTAINERS else {"help": summary}
        command = commands.add_parser(name, **listed)
        if name == chosen:
            add_arguments(command)
    return parser


def _imported(module: str, name: str = "add_arguments") -> Callable[[argparse.ArgumentParser], None]:
    """Function that imports a module and adds the arguments of its subcommand."""
    return lambda parser: getattr(import_module(f".{module}", __package__), name)(parser)


def _run_arguments(run: argparse.ArgumentParser) -> None:
    run.add_argument(
        "case", metavar="CASE.nml", help="case file of rie_driver, or a name of `asperity cases`"
    )
    run.add_argument(
        "-o", "--output", type=Path, metavar="OUT.csv", help="result (default: the case's name, .csv, here)"
    )
    run.add_argument(
        "--plot",
        nargs="?",
        type=Path,
        const=Path(),
        metavar="FILE.png",
        help="draw traction, dilation and damage (default: the result's name, .png)",
    )
    run.add_argument("--planes", action="store_true", help="columns of the state of every plane")
    run.add_argument("--quiet", action="store_true", help="no progress and no summary")
    run.add_argument(
        "--units",
        metavar="LENGTH,STRESS",
        help="units for the labels of the plot (default: mm,MPa)",
    )
    from .parallel import add_workers

    add_workers(run, "one driver runs all values of a sweep")
    run.set_defaults(action=_run)


def _compare_arguments(compare: argparse.ArgumentParser) -> None:
    compare.add_argument(
        "--figure",
        action="append",
        metavar="NUMBER",
        help="figure of the paper; the option may be repeated (default: all)",
    )
    compare.set_defaults(action=_compare)


def _chart_arguments(chart: argparse.ArgumentParser) -> None:
    charts = chart.add_subparsers(required=True, metavar="CHART")
    speed = charts.add_parser("speed", help="time per point against the number of planes, with the limits")
    speed.add_argument(
        "csv", nargs="?", type=Path, metavar="BENCH.csv", help="written by bench --csv (default: run it now)"
    )
    speed.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("speed.png"),
        metavar="FILE",
        help="picture, .png or .pdf (default: %(default)s)",
    )
    speed.add_argument("--quick", action="store_true", help="short run with rough results")
    speed.add_argument("--table", action="store_true", help="also print a table in Markdown")
    speed.set_defaults(action=_speed)
    accuracy = "error against measured cost: increments, planes, precision, tangents (a minute)"
    _imported("studies.accuracy.command")(charts.add_parser("accuracy", help=accuracy))
    structures = "error and time of whole structures against the number of planes"
    _imported("studies.structures")(charts.add_parser("structure", help=structures))
    explain = "pictures that explain the law and the solver"
    _imported("studies.concepts")(charts.add_parser("concepts", help=explain))


def _tables_arguments(table: argparse.ArgumentParser) -> None:
    table.add_argument(
        "files", nargs="*", type=Path, metavar="FILE.md", help="fill between <!-- props --> markers"
    )
    table.add_argument(
        "--check", action="store_true", help="change nothing; exit with 1 if a file is not up to date"
    )
    table.set_defaults(action=_tables)


INDENT = 4
"""Of the commands in the help."""

MAINTAINERS = ("compare", "chart", "paper", "tables", "stability")
"""Commands of the people who change this project, which the help does not list one by one."""

COMMANDS: dict[str, tuple[str, Callable[[argparse.ArgumentParser], None]]] = {
    "new": ("write a case file to start from", _imported("starters", "new_arguments")),
    "cases": ("list or copy the cases of the package", _imported("starters", "cases_arguments")),
    "explore": ("open a page with sliders for constants and load path", _imported("explore.command")),
    "run": ("run a case by the driver and draw it", _run_arguments),
    "compare": ("compare the library with the NumPy reference and the 2D law", _compare_arguments),
    "chart": ("draw speed, or accuracy against cost", _chart_arguments),
    "paper": ("recompute the figures and tables of the paper", _imported("studies.paper.command")),
    "card": ("print the material block for the input of a host program", _imported("cards.command")),
    "export": ("write sources, decks and a README for Abaqus", _imported("export.command")),
    "fit": ("identify parameters from shear-box tests", _imported("fit.command")),
    "barton": ("find the constants that come closest to JRC, JCS and phi_r", _imported("barton.command")),
    "select": ("find the cheapest pattern that a load case needs", _imported("selection.command")),
    "surface": ("find the planes of a scanned profile or height map", _imported("surface.command")),
    "uncertainty": (
        "find the scatter of a load case whose constants are uncertain",
        _imported("uncertainty.command"),
    ),
    "doctor": ("check the installation and look for host programs", _imported("doctor")),
    "tables": ("print the tables of PROPS and STATEV, or fill them into files", _tables_arguments),
    "stability": (
        "show where solution methods fail and which ones succeed",
        _imported("studies.stability.command"),
    ),
}
"""Summary of each subcommand, and the function that adds its arguments."""


def _run(options: argparse.Namespace) -> int:
    """Run the driver, draw its result, return its exit code; after code 2 the converged rows are drawn."""
    if options.units is not None and options.plot is None:
        raise ValueError(f"--units {options.units}: expected with --plot, whose labels have units")
    units = (options.units or "mm,MPa").split(",")
    if len(units) != 2:
        raise ValueError(f"--units {options.units}: expected LENGTH,STRESS")
    if options.plot not in (None, Path()):
        from .style import check

        check(options.plot)
    path = Path(options.case)
    path = path if path.is_file() or path.suffix else named_case(options.case)
    output = options.output or Path(path.stem + ".csv")
    before = {path: path.stat().st_mtime_ns for path in results_of(output).values()}
    passed_on = [f"--{name}" for name in ("planes", "quiet") if getattr(options, name)]
    code = _driven(path, output, passed_on, options)
    written = {v: p for v, p in results_of(output).items() if before.get(p) != p.stat().st_mtime_ns}
    if options.plot is not None and written and code in (0, NO_EQUILIBRIUM):
        from .case_files import read_case
        from .plots import draw

        png = output.with_suffix(".png") if options.plot == Path() else options.plot
        results = {value: read_rows(path) for value, path in written.items()}
        case = read_case(path)
        joints = {(run.material, run.pattern): run.interface for run in case.runs}
        joint = next(iter(joints.values())) if len(joints) == 1 else None
        draw(results, png, case.title, case.sweep, *units, joint)
        print(png)
    if hasattr(signal, "SIGPIPE") and code == -signal.SIGPIPE:
        raise BrokenPipeError
    return code if code >= 0 else BAD_INPUT


def _driven(path: Path, output: Path, passed_on: Sequence[str], options: argparse.Namespace) -> int:
    """Run the driver, or with --jobs one for each value of a sweep; return the exit code."""
    if options.jobs is None:
        return subprocess.run([driver(), path, "-o", output, *passed_on], check=False).returncode
    from .parallel import progress_bar, workers
    from .sweeps import number_of_runs, run_sweep

    with workers(options) as executor, progress_bar(number_of_runs(path), "run") as bar:
        code, messages = run_sweep(path, output, passed_on, executor, bar.update)
    sys.stderr.write(messages)
    return code


def _compare(options: argparse.Namespace) -> int:
    """Yield a line for each case and each solution it is compared with."""
    from .oracle.compare import LAW_TOLERANCE, OPENING_TOLERANCE, TEST_TOLERANCE, compare, find, within

    wanted = [path for figure in options.figure for path in find(figure)] if options.figure else cases()
    print("Largest difference between the driver and others (NumPy reference, 2D law), relative:")
    print("traction to K |s|, s_N to |s|, damage to 1, energies to K |s| times the length of the path")
    print(f"  law: along the driver's separations, tolerance {LAW_TOLERANCE:.0e}")
    followed = f"tolerance {TEST_TOLERANCE:.0e}, of s_N {OPENING_TOLERANCE:.0e}"
    print(f"  test: each follows the equilibrium itself, {followed}")
    head = ("traction", "s_N", "damage", "energies")
    print(f"{'case':<20}{'curves':>7}{'rows':>7}  {'against':<10}" + "".join(f"{name:>10}" for name in head))
    agree = True
    from tqdm import tqdm

    for path in tqdm(dict.fromkeys(wanted), unit="case", disable=None, delay=2.0, leave=False):
        result = compare(path)
        start = f"{result.case:<20}{result.curves:>7}{result.rows:>7}"
        for name, found in result.differences.items():
            # s_N is prescribed along given separations
            texts = ("-" if name.startswith("law") and i == 1 else f"{v:.1e}" for i, v in enumerate(found))
            verdict = "agrees" if within(name, found) else "DIFFERS"
            line = f"{start}  {name:<10}" + "".join(f"{text:>10}" for text in texts)
            tqdm.write(f"{line}  {verdict}")
        agree = agree and result.agrees
    return 0 if agree else DIFFERS


def _speed(options: argparse.Namespace) -> int:
    """Read the CSV of the benchmark, or run the benchmark, then draw."""
    from .studies.speed_charts import draw_speed, measure, read_timings, table

    if options.csv is not None and options.quick:
        raise ValueError(f"--quick: expected without {options.csv}, which is not run again")
    quick = ["--quick"] if options.quick else []
    timings = measure(*quick) if options.csv is None else read_timings(options.csv)
    draw_speed(timings, options.output)
    if options.table:
        print(table(timings))
    print(options.output)
    return 0


def _tables(options: argparse.Namespace) -> int:
    """Print the tables, fill them into files, or check the files."""
    from . import tables

    if not options.files:
        if options.check:
            raise ValueError("--check: expected files to check")
        print("\n\n".join(table() for table in tables.TABLES.values()))
        return 0
    stale = [path for path in options.files if not tables.refresh(path, options.check)]
    for path in stale:
        print(f"{path}: {'tables are not up to date' if options.check else 'tables filled'}")
    return DIFFERS if options.check and stale else 0


if __name__ == "__main__":
    sys.exit(main())
