"""Runs of a sweep by several drivers at once, as `asperity run --jobs` does."""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from .case_files import read_case
from .installed import driver
from .options import check_outputs, progress_bar, workers
from .parallel import map_in_order

START = 24
"""Bytes at the start of a result or of a failed increment by which a file of the driver is known."""


def run_sweep(case: Path, output: Path, passed_on: Sequence[str], options: argparse.Namespace) -> int:
    """Run every value of a sweep, write the files and the messages, and return the worst exit code.

    passed_on: options of the driver.  A line that is a message of several runs is written once.  Raises
    OSError, before any work, if the folder of the output does not exist.
    """
    if output == Path("-"):
        raise ValueError("-o -: expected the name of a file with --jobs, of which several are written")
    if not output.parent.is_dir():
        raise FileNotFoundError(f"{output}: expected a file in a folder that exists, not in {output.parent}")
    count = len(read_case(case, any_law=True).runs)
    one_run = partial(_one_run, case, output, passed_on)
    with workers(options) as executor, progress_bar(count, "run") as bar:
        done = map_in_order(one_run, range(1, count + 1), executor, bar.update)
    written = {output.parent / name: content for _, _, files in done for name, content in files.items()}
    for path, content in written.items():
        # the first entries of a file say whether a driver wrote it
        check_outputs(options.force, [case], ("-o", path, re.escape(content[:START].decode())))
    for path, content in written.items():
        path.write_bytes(content)
    lines = dict.fromkeys(line for _, messages, _ in done for line in messages.splitlines(keepends=True))
    sys.stderr.write("".join(lines))
    return max(code for code, _, _ in done)


def _one_run(
    case: Path, output: Path, options: Sequence[str], number: int
) -> tuple[int, str, dict[str, bytes]]:
    """Exit code, messages and files of one value of the sweep, which is run in a folder of its own."""
    with TemporaryDirectory() as folder:
        command = [driver(), case, "-o", Path(folder, output.name), "--only", str(number), *options]
        run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        files = {path.name: path.read_bytes() for path in sorted(Path(folder).iterdir())}
    here, there = (str(place / "_")[:-1] for place in (Path(folder), output.parent))
    return run.returncode, run.stdout.decode("utf-8", "replace").replace(here, there), files
