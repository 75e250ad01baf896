"""Criteria of the peak strength of joints beside the law: c + phi, and Barton."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ...contract import Floats

STRESSES = ("c",)
"""Constants that are stresses."""

BARTON = "phi_r + JRC log10(JCS)"
"""Sum of Barton's constants that peaks show beside JRC, the angle at a pressure of 1; peaks do not show phi_r
and JCS apart.
"""


@dataclass(frozen=True)
class Criterion:
    """Peak strength (n,) over the pressure (n,) with two constants by name, in degrees and stress.

    fit: constants of the smallest relative errors of peaks, a linear problem.
    """

    label: str
    strength: Callable[[Floats, Mapping[str, float]], Floats]
    fit: Callable[[Floats, Floats], dict[str, float]]


def _line(pressure: Floats, peak: Floats) -> dict[str, float]:
    """Constants of c + p tan(phi); no cohesion is negative."""
    columns = np.column_stack([1.0 / peak, pressure / peak])
    c, slope = np.linalg.lstsq(columns, np.ones_like(peak), rcond=None)[0].tolist()
    if c < 0.0:
        c, slope = 0.0, float(np.sum(columns[:, 1]) / np.sum(columns[:, 1] ** 2))
    return {"c": c, "phi": float(np.degrees(np.arctan(slope)))}


def _angles(pressure: Floats, peak: Floats) -> dict[str, float]:
    """Constants of Barton: the angle falls along a line over the logarithm of the pressure."""
    angle, place = np.arctan2(peak, pressure), np.log10(pressure)
    # relative errors of the strength, by its derivative over the angle
    weights = 2.0 / np.sin(2.0 * angle)
    columns = np.column_stack([np.ones_like(place), -place]) * weights[:, None]
    top, roughness = np.degrees(np.linalg.lstsq(columns, angle * weights, rcond=None)[0]).tolist()
    return {"JRC": roughness, BARTON: top}


def _coulomb(pressure: Floats, v: Mapping[str, float]) -> Floats:
    return np.asarray(v["c"] + pressure * np.tan(np.radians(v["phi"])))


def _barton(pressure: Floats, v: Mapping[str, float]) -> Floats:
    return np.asarray(pressure * np.tan(np.radians(v[BARTON] - v["JRC"] * np.log10(pressure))))


CRITERIA = (Criterion("c + phi", _coulomb, _line), Criterion("Barton", _barton, _angles))
"""Mohr-Coulomb, and Barton and Choubey (1977)."""
