"""Scans in files that the tests of surfaces share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from asperity.tools.surface import slopes
from asperity.tools.surface.scan import Scan

EXACT = 1.0e-9
"""Rounding error of heights of order 1 over a spacing of order 0.01, in degrees and fractions."""


def profile(x: np.ndarray, z: np.ndarray) -> slopes.Facets:
    """Facets of a profile."""
    return slopes.facets(Scan(x, None, z[None, :]))


def grid(n: int, periods: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Axis of `periods` unit periods of n cells each, and the mesh of two such axes."""
    a = np.arange(n * periods + 1) / n
    return a, *np.meshgrid(a, a)


def write(text: str) -> Path:
    """A scan in the current folder."""
    Path("scan.csv").write_text(text, encoding="utf-8")
    return Path("scan.csv")


def rows(*columns: np.ndarray, header: str = "", mark: str = ",", form: str = ".12g") -> str:
    """Text of a CSV."""
    lines = [mark.join(format(value, form) for value in row) for row in np.column_stack(columns)]
    return "\n".join(([header] if header else []) + lines) + "\n"
