"""Entries of the catalogue of failure modes, and functions that run their load paths."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from asperity.contract import Floats
from asperity.installed import driver, named_case
from asperity.material import Material

from ..newton import NewtonStudy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TABLE_2 = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5)
"""Table 2 of the paper: mm, MPa, N/mm."""

S_F = TABLE_2.s_f
"""Separation at complete rupture, mm."""

S_0 = TABLE_2.s_0
"""Separation at onset, mm."""

K = TABLE_2.K
"""Stiffness of the bond (12), MPa/mm."""


@dataclass(frozen=True)
class Trial:
    """A method on a load case: whether it should succeed, whether it did, and the measured values."""

    method: str
    expected: bool
    survives: bool
    measured: str

    @property
    def holds(self) -> bool:
        """Whether the result is the expected one."""
        return self.survives == self.expected


@dataclass(frozen=True)
class FailureMode:
    """A failure mode of the law or of its solvers: description, and the trials that show it.

    draw: picture of the entry, None if it has none.
    """

    name: str
    title: str
    happens: str
    run: Callable[[], Sequence[Trial]]
    draw: Callable[[], Figure] | None = None


MODES: list[FailureMode] = []
"""Entries in the order of the page."""


def mode(
    name: str, title: str, happens: str, draw: Callable[[], Figure] | None = None
) -> Callable[[Callable[[], Iterator[Trial]]], Callable[[], Iterator[Trial]]]:
    """Add the entry whose trials a function yields."""

    def add(trials: Callable[[], Iterator[Trial]]) -> Callable[[], Iterator[Trial]]:
        MODES.append(FailureMode(name, title, happens, lambda: list(trials()), draw))
        return trials

    return add


@dataclass(frozen=True, eq=False)
class Driven:
    """Driver run of a case: exit code, columns by name, (T,) each, and the events by row."""

    code: int
    columns: dict[str, Floats]
    events: list[str]

    def last(self, name: str) -> float:
        """Value of a column in the last row."""
        return float(self.columns[name][-1])

    def rows_with(self, event: str) -> list[int]:
        """Rows with a given event."""
        return [row for row, text in enumerate(self.events) if event in text.split("+")]


def drive(case: str | Path) -> Driven:
    """Run a case of the catalogue, or a case file, by the driver."""
    path = case if isinstance(case, Path) else named_case(f"stability/{case}")
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder, "out.csv")
        command = [driver(), path, "-o", output, "--quiet"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if not output.is_file():
            raise ValueError(done.stderr.strip())
        header, *lines = output.read_text(encoding="utf-8").splitlines()
    names = header.split(",")
    cells = [line.split(",") for line in lines]
    event = names.index("event")
    columns = {
        name: np.array([row[i] for row in cells], dtype=float)
        for i, name in enumerate(names)
        if name != "event"
    }
    return Driven(done.returncode, columns, [row[event] for row in cells])


def plain(label: str, study: NewtonStudy, expected: bool, what: str = "") -> Trial:
    """Trial of Newton's method without safeguards."""
    if study.converged:
        mean = sum(study.iterations) / len(study.iterations)
        found = f"{mean:.1f} iterations per increment, at most {max(study.iterations)}"
    else:
        found = f"increment {len(study.iterations)}: {study.end}"
    return Trial(label, expected, study.converged, f"{found}{what and f'; {what}'}")
