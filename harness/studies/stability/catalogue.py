"""The catalogue of failure modes: an entry is one method that fails on a load case, and one that does not."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

from asperity.material import Material

TABLE_2 = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5)
"""Table 2 of the paper: mm, MPa, N/mm."""

S_F, S_0, K = TABLE_2.s_f, TABLE_2.s_0, TABLE_2.K
"""Separations at complete rupture and at onset, mm, and stiffness of the bond (12), MPa/mm."""


class Trial(NamedTuple):
    """A method on a load case, whether it succeeds, and the measured values."""

    method: str
    survives: bool
    measured: str

    def __str__(self) -> str:
        """Line of the page."""
        return f"- *{'Survives' if self.survives else 'Fails'}:* {self.method} ({self.measured})."


@dataclass(frozen=True)
class FailureMode:
    """A failure mode of the law or of its solvers: description, and the two trials that show it."""

    name: str
    title: str
    happens: str
    run: Callable[[], tuple[Trial, Trial]]

    def section(self, trials: Iterable[Trial]) -> str:
        """Section of docs/results/stability.md."""
        return "\n".join([f"### {self.name}", "", f"**{self.title}.** {self.happens}", "", *map(str, trials)])


def as_expected(trials: tuple[Trial, Trial]) -> bool:
    """Whether the first method fails and the second one does not."""
    return [trial.survives for trial in trials] == [False, True]


NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.])")
"""A number in a section."""

NOISE = 1e-9
"""Numbers below this are rounding errors."""


def agree(one: str, other: str) -> bool:
    """Whether two sections have the same words, and numbers within a factor of 2 or both rounding errors.

    Compilers round differently, which changes numbers of iterations and errors.
    """
    if NUMBER.sub("#", one) != NUMBER.sub("#", other):
        return False
    pairs = zip(*(map(float, NUMBER.findall(text)) for text in (one, other)), strict=True)
    return all(
        max(abs(a), abs(b)) < NOISE or (a * b >= 0.0 and 0.5 <= abs(a) / abs(b) <= 2.0 if a * b else a == b)
        for a, b in pairs
    )
