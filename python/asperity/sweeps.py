"""Runs of a sweep by several drivers at once, as `asperity run --jobs` and `--scheduler` do."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from .case_files import read_case
from .installed import driver
from .parallel import map_in_order


@dataclass(frozen=True)
class Job:
    """Case file (its name and content), output as messages name it, and options of the driver."""

    name: str
    content: bytes
    output: Path
    options: tuple[str, ...]


@dataclass(frozen=True)
class Outcome:
    """Exit code, messages and written files of a driver."""

    code: int
    messages: str
    files: dict[str, bytes]


def number_of_runs(case: Path) -> int:
    """Runs of a case that workers can do; raises ValueError for a case that reads another file."""
    found = read_case(case)
    if not found.runs[0].steps:
        raise ValueError(f"{case}: &replay: expected without --jobs and --scheduler, it reads a file here")
    return len(found.runs)


def run_sweep(
    case: Path,
    output: Path,
    options: Sequence[str],
    executor: Executor | None,
    tick: Callable[[], object],
) -> tuple[int, str]:
    """Run every value of a sweep, write the files, and return the worst exit code and the messages.

    A line that is a message of several runs is returned once.  Raises OSError, before any work, if the folder
    of the output does not exist.
    """
    if not output.parent.is_dir():
        raise FileNotFoundError(f"{output}: expected a file in a folder that exists, not in {output.parent}")
    job = Job(case.name, case.read_bytes(), output, tuple(options))
    done = map_in_order(partial(_one_run, job), range(1, number_of_runs(case) + 1), executor, tick)
    for one in done:
        for name, content in one.files.items():
            path = output.parent / name
            if path.exists() and path.samefile(case):
                raise ValueError(
                    f"{case}: the output {path} would replace the case file: expected another -o"
                )
            path.write_bytes(content)
    lines = dict.fromkeys(line for one in done for line in one.messages.splitlines(keepends=True))
    return max(one.code for one in done), "".join(lines)


def _one_run(job: Job, number: int) -> Outcome:
    """Run one value of the sweep in a folder of its own."""
    with TemporaryDirectory() as folder:
        case, results = Path(folder, "case", job.name), Path(folder, "results")
        case.parent.mkdir()
        results.mkdir()
        case.write_bytes(job.content)
        command = [driver(), job.name, "-o", results / job.output.name, "--only", str(number), *job.options]
        run = subprocess.run(
            command, cwd=case.parent, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
        )
        files = {path.name: path.read_bytes() for path in sorted(results.iterdir())}
    here, there = (str(place / "_")[:-1] for place in (results, job.output.parent))
    messages = run.stdout.decode("utf-8", "replace").replace(here, there)
    return Outcome(run.returncode, messages, files)
