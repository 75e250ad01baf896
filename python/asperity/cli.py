"""Command `asperity`. Only the module of the chosen subcommand is imported."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path

from .driver_process import ENDING, end_program, handled, run_driver
from .installed import named_case
from .options import (
    NO_EQUILIBRIUM,
    Parser,
    add_options,
    add_output,
    add_workers,
    check_outputs,
    report,
    results_of,
    units_of,
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return the exit code, 0 for success."""
    arguments = sys.argv[1:] if arguments is None else arguments
    if list(arguments[:1]) == ["help"]:  # as asperity help fit
        arguments = [*arguments[1:2], "--help"]
    chosen = next((text for text in arguments if text in COMMANDS), "")
    try:
        parser = _parser(chosen)
    except KeyboardInterrupt:  # modules are imported
        return 130
    except ModuleNotFoundError as error:
        print(f"asperity {chosen}: {error}", file=sys.stderr)
        return 1
    word = next((text for text in arguments if not text.startswith("-")), None)
    if word is not None and word not in COMMANDS:
        near = get_close_matches(word, COMMANDS, 1)
        parser.error(
            f"{word}: did you mean {near[0]}?" if near else f"{word}: expected one of {', '.join(COMMANDS)}"
        )
    return execute(parser, arguments)


def execute(parser: argparse.ArgumentParser, arguments: Sequence[str]) -> int:
    """Parse arguments, run the action that the parser sets, and return the exit code; errors are one line."""
    # The matrices are small, so further threads of BLAS would only wait, which costs a fit 6 % of its time.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # pictures are written to files, on machines without a display, too
    os.environ.setdefault("MPLBACKEND", "Agg")
    options = parser.parse_args(arguments)
    try:
        with handled(ENDING, end_program):
            code = int(options.action(options))
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        # the reader, such as head, has all it wants; the flush at the exit of Python must not fail either
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (ModuleNotFoundError, OSError, ValueError) as error:
        text = str(error)
        if isinstance(error, OSError) and error.filename is not None:
            text = f"{error.filename}: {error.strerror}"
        report(text)
        return 1
    except KeyboardInterrupt:
        return 130


class _Version(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from . import __version__

        print(f"asperity {__version__}")
        parser.exit()


def _parser(chosen: str) -> argparse.ArgumentParser:
    """Parser of all subcommands, with the arguments of the chosen one."""
    parser = Parser(
        prog="asperity",
        description="Interface law for rough quasi-brittle interfaces: damage, friction, interlocking.",
    )
    parser.epilog = "asperity COMMAND --help explains a command."
    version = "show program's version number and exit"
    parser.add_argument("-V", "--version", action=_Version, nargs=0, help=version)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, (summary, add_arguments) in COMMANDS.items():
        command = commands.add_parser(name, help=summary)
        if name == chosen:
            add_arguments(command)
    return parser


def _imported(module: str, name: str = "add_arguments") -> Callable[[argparse.ArgumentParser], None]:
    """Function that imports a module and adds the arguments of its subcommand."""
    return lambda parser: getattr(import_module(f".{module}", __package__), name)(parser)


def _run_arguments(run: argparse.ArgumentParser) -> None:
    drawn = "draw traction, dilation and damage (default: the result's name, .png)"
    add_options(
        run,
        ("case CASE.nml", "case file of rie_driver, or a name of `asperity cases`", str),
        ("--plot FILE.png", drawn, Path, {"nargs": "?", "const": Path()}),
        ("--planes", "columns of the state of every plane"),
        ("--quiet", "no progress and no summary"),
        ("--label-units LENGTH,STRESS", "units for the labels of the plot (default: none)", str),
    )
    add_output(run, "OUT.csv", "result (default: the case's name, .csv, here)")
    add_workers(run, "that run the values of a sweep (default: one driver runs all)")
    run.set_defaults(action=_run)


def _check_arguments(check: argparse.ArgumentParser) -> None:
    check.description = (
        "Check the UMAT of a case, or that of asperity for its material, and print a table; exit code 1: "
        "a check failed."
    )
    add_options(check, ("case CASE.nml", "case file of rie_driver, or a name of `asperity cases`", str))
    check.set_defaults(action=lambda options: run_driver(_case(options), "--check")[0])


COMMANDS: dict[str, tuple[str, Callable[[argparse.ArgumentParser], None]]] = {
    "new": ("write a case file to start from", _imported("starters", "new_arguments")),
    "cases": ("list or copy the cases of the package", _imported("starters", "cases_arguments")),
    "run": ("run a case by the driver and draw it", _run_arguments),
    "check-umat": ("check a UMAT along the load path of a case", _check_arguments),
    "fit": ("identify parameters from shear-box tests", _imported("tools.fit.command")),
    "predict": ("predict shear-box tests with a joint, and compare", _imported("tools.fit.predict")),
    "joint": ("find the constants of a joint with a bond: mortar, dam, rock", _imported("tools.joint")),
    "barton": ("find the constants closest to JRC, JCS and phi_r", _imported("tools.barton.command")),
    "surface": ("find the planes of a scanned profile or height map", _imported("tools.surface.command")),
    "select": ("find the cheapest pattern that a load case needs", _imported("tools.selection.command")),
    "uncertainty": (
        "find the scatter of a load case whose constants are uncertain",
        _imported("tools.uncertainty.command"),
    ),
    "mesh": ("put joints into a mesh, for a host program", _imported("mesh.command")),
    "card": ("print the material block for the input of a host program", _imported("card_command")),
    "export": ("write a model of one element for a host program", _imported("export.command")),
    "explore": ("open a page with sliders for constants and load path", _imported("tools.explore.command")),
    "doctor": ("check the installation and look for host programs", _imported("doctor")),
}
"""Summary of each subcommand, and the function that adds its arguments."""


def _case(options: argparse.Namespace) -> Path:
    path = Path(options.case)
    return path if path.is_file() or path.suffix else named_case(options.case)


def _run(options: argparse.Namespace) -> int:
    """Run the driver, draw its result, return its exit code; after code 2 the converged rows are drawn."""
    labels = options.label_units
    if labels is not None and options.plot is None:
        raise ValueError(f"--label-units {labels}: expected with --plot, whose labels have units")
    units = units_of(labels or "length,stress")
    path = _case(options)
    output = options.output or Path(path.stem + ".csv")
    png = output.with_suffix(".png") if options.plot == Path() else options.plot
    check_outputs(options.force, [path], ("--plot", png))
    before = {path: path.stat().st_mtime_ns for path in results_of(output).values()}
    passed_on = [f"--{name}" for name in ("planes", "quiet", "force") if getattr(options, name)]
    if options.jobs is None:
        code, _ = run_driver(path, "-o", output, *passed_on)
    else:
        from .sweeps import run_sweep

        code = run_sweep(path, output, passed_on, options)
    written = {v: p for v, p in results_of(output).items() if before.get(p) != p.stat().st_mtime_ns}
    if options.plot is not None and written and code in (0, NO_EQUILIBRIUM):
        from .case_files import read_case
        from .history import History
        from .tools.plots import figure_of
        from .tools.style import save

        results = {value: History.from_csv(path) for value, path in written.items()}
        case = read_case(path, any_law=True)
        joints = {(run.material, run.pattern): run.interface for run in case.runs}
        joint = next(iter(joints.values())) if len(joints) == 1 else None
        save(figure_of(results, case.title, case.sweep, *units, joint), png)
        print(png)
    return code


if __name__ == "__main__":
    sys.exit(main())
