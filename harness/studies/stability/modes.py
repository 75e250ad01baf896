"""Entries of the catalogue of failure modes, and functions that run their load paths."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from asperity import case_files
from asperity.installed import named_case
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


MODES: dict[str, FailureMode] = {}
"""Entries by name, in the order of the page."""


def mode(
    name: str, title: str, happens: str, draw: Callable[[], Figure] | None = None
) -> Callable[[Callable[[], Iterator[Trial]]], Callable[[], Iterator[Trial]]]:
    """Add the entry whose trials a function yields."""

    def add(trials: Callable[[], Iterator[Trial]]) -> Callable[[], Iterator[Trial]]:
        MODES[name] = FailureMode(name, title, happens, lambda: list(trials()), draw)
        return trials

    return add


def drive(case: str) -> dict[str, Any]:
    """Columns of the results of a case of the catalogue, by the names of the driver."""
    return case_files.drive(named_case(f"stability/{case}"))[None].columns()


def rows_with(columns: dict[str, Any], event: str) -> list[int]:
    """Rows of results with a given event."""
    return [row for row, text in enumerate(columns["event"]) if event in text.split("+")]


def plain(label: str, study: NewtonStudy, expected: bool, what: str = "") -> Trial:
    """Trial of Newton's method without safeguards."""
    if study.converged:
        mean = sum(study.iterations) / len(study.iterations)
        found = f"{mean:.1f} iterations per increment, at most {max(study.iterations)}"
    else:
        found = f"increment {len(study.iterations)}: {study.end}"
    return Trial(label, expected, study.converged, f"{found}{what and f'; {what}'}")
