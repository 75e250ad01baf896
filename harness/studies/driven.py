"""Runs of cases by the driver, and work along their rows."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from asperity.contract import Floats
from asperity.installed import driver
from asperity.results import Rows, read_rows, results_of


@contextmanager
def driven(case: Path) -> Iterator[tuple[subprocess.CompletedProcess[str], Path]]:
    """Run of a case by the driver; its output exists as long as the context is open."""
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder, "out.csv")
        command = [driver(), case, "-o", output, "--quiet"]
        yield subprocess.run(command, capture_output=True, text=True, check=False), output


def drive(case: Path) -> dict[float | None, Rows]:
    """Rows by the value of the sweep, None without one; raises ValueError with the message of the driver."""
    with driven(case) as (run, output):
        if run.returncode != 0:
            raise ValueError(run.stderr.strip())
        return {value: read_rows(path) for value, path in results_of(output).items()}


def work_along(separation: Floats, traction: Floats) -> Floats:
    """Work (T,) of a traction (T, 3) along separations (T, 3) that start at zero, by the trapezoidal rule."""
    before = np.concatenate([np.zeros((1, 3)), traction])[:-1]
    change = np.diff(separation, axis=0, prepend=0.0)
    return np.cumsum(0.5 * np.sum((before + traction) * change, axis=1))
