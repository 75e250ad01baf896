"""Runs of a sweep by several drivers at once, as `asperity run --jobs` does."""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from .case_files import read_case
from .driver_process import run_driver
from .options import check_outputs, progress_bar, results_of, workers
from .parallel import map_in_order


def run_sweep(case: Path, output: Path, passed_on: Sequence[str], options: argparse.Namespace) -> int:
    """Run every value of a sweep by a driver of its own, and return the worst exit code.

    passed_on: options of the driver.  A line that is a message of several runs is written once.  Raises
    ValueError or OSError, before any run, for results that cannot be written.
    """
    if output == Path("-"):
        raise ValueError("-o -: expected the name of a file with --jobs, of which several are written")
    if not output.parent.is_dir():
        raise FileNotFoundError(f"{output}: expected a file in a folder that exists, not in {output.parent}")
    for path in results_of(output).values():
        check_outputs(options.force, [case], ("-o", path, "step,increment,"))
    count = read_case(case, any_law=True).count
    one_run = partial(_one_run, case, output, passed_on)
    with workers(options) as executor, progress_bar(count, "run") as bar:
        if options.jobs == 1:  # in this thread, with which the driver ends
            done = [(one_run(number), bar.update())[0] for number in range(1, count + 1)]
        else:
            done = map_in_order(one_run, range(1, count + 1), executor, bar.update)
    sys.stderr.write("".join(dict.fromkeys(line for _, lines in done for line in lines)))
    return max(code for code, _ in done)


def _one_run(case: Path, output: Path, options: Sequence[str], number: int) -> tuple[int, list[str]]:
    """Exit code and messages of one value of the sweep."""
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    code, text = run_driver(case, "-o", output, "--only", str(number), *options, **streams)
    return code, text.splitlines(keepends=True)
