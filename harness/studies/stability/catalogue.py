"""The catalogue of failure modes: entries, runs and report."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from itertools import pairwise

from . import law_modes, solver_modes  # noqa: F401  # they add the entries, those of solver_modes first
from .modes import MODES as MODES
from .modes import FailureMode, Trial


def shown(trials: Sequence[Trial]) -> bool:
    """Whether an entry has a failure and a success, each as expected."""
    return all(trial.holds for trial in trials) and len({trial.expected for trial in trials}) == 2


def table(results: Iterable[tuple[FailureMode, Sequence[Trial]]]) -> str:
    """Body of docs/results/stability.md: description and one comparison for each failure mode."""
    return "\n\n".join(_section(mode, trials) for mode, trials in results)


def _section(mode: FailureMode, trials: Sequence[Trial]) -> str:
    pair = [pair for pair in pairwise(trials) if pair[0].survives != pair[1].survives][-1]
    lines = [f"### {mode.name}", "", f"**{mode.title}.** {mode.happens}", ""]
    lines += [f"- *{'Survives' if t.survives else 'Fails'}:* {t.method} ({t.measured})." for t in pair]
    return "\n".join(lines)


NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.])")
"""A number in a table."""

NOISE = 1e-9
"""Numbers below this are rounding errors."""


def agree(one: str, other: str) -> bool:
    """Whether two tables have the same words, and numbers within a factor of 2 or both rounding errors.

    Compilers round differently, which changes numbers of iterations and errors.
    """
    if NUMBER.sub("#", one) != NUMBER.sub("#", other):
        return False
    pairs = zip(*(map(float, NUMBER.findall(text)) for text in (one, other)), strict=True)
    return all(
        max(abs(a), abs(b)) < NOISE or (a * b >= 0.0 and 0.5 <= abs(a) / abs(b) <= 2.0 if a * b else a == b)
        for a, b in pairs
    )
