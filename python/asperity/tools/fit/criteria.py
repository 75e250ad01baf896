"""Criteria of the peak strength of joints: c + phi, Patton, Barton, Ladanyi and Archambault."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np

from ...contract import Floats

K1, K2, FAIRHURST = 1.5, 4.0, 10.0
"""Exponents of Ladanyi and Archambault (1970), and ratio of compressive to tensile strength of the rock."""

STEEPEST = 75.0
"""Largest angle of a strength, degrees."""

GRID, STARTS = (0.01, 0.03, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9), 4
"""Places of the ranges at which the errors are compared, and number of the best that start least squares."""


@dataclass(frozen=True)
class Criterion:
    """Peak strength over the pressure with constants by name, in degrees and stress.

    angles: the constants that are angles; the others are stresses, but for JRC.
    """

    label: str
    names: tuple[str, ...]
    strength: Callable[[Floats, Mapping[str, float]], Floats]
    ranges: Mapping[str, tuple[float, float]]

    def fit(
        self,
        pressure: Floats,
        peak: Floats,
        start: Mapping[str, float] | None = None,
        line: Mapping[str, float] | None = None,
    ) -> dict[str, float]:
        """Constants of the smallest relative errors; ranges of stresses are multiples of the largest.

        start: where the search begins.  line: constants of c + phi, from which it begins, too.
        """
        from scipy.optimize import least_squares

        size = float(max(pressure.max(), peak.max()))
        stresses = [name for name in self.names if name in STRESSES]
        factor = {name: size if name in stresses else 1.0 for name in self.names}
        low, high = (np.array([self.ranges[name][k] * factor[name] for name in self.names]) for k in (0, 1))

        def errors(x: Floats) -> Floats:
            values = dict(zip(self.names, x, strict=True))
            return np.clip(self.strength(pressure, values) / peak - 1.0, -10.0, 10.0)

        if start is None:
            # a criterion with a kink has several minima
            grid = [low + np.array(parts) * (high - low) for parts in product(GRID, repeat=len(low))]
            points = sorted(grid, key=lambda x: float(np.sum(errors(x) ** 2)))[:STARTS]
            if line is not None and {*line} < {*self.names}:
                points.append(
                    np.array([line.get(name, top) for name, top in zip(self.names, high, strict=True)])
                )
        else:
            points = [np.array([start[name] for name in self.names])]
        margin = 1e-6 * (high - low)
        tries = (
            least_squares(
                errors,
                np.clip(x, low + margin, high - margin),
                bounds=(low, high),
                x_scale=high - low,
                ftol=1e-6,
                max_nfev=60,
            )
            for x in points
        )
        best = min(tries, key=lambda solution: float(solution.cost))
        return dict(zip(self.names, best.x.tolist(), strict=True))


STRESSES = ("c", "sigma_c")
"""Constants that are stresses."""

BARTON = "phi_r + JRC log10(JCS)"
"""Sum of Barton's constants that peaks show beside JRC, the angle at a pressure of 1; peaks do not show phi_r
and JCS apart.
"""


def _tan(degrees: Floats | float) -> Floats:
    return np.asarray(np.tan(np.radians(np.minimum(degrees, STEEPEST))))


def _coulomb(pressure: Floats, v: Mapping[str, float]) -> Floats:
    return np.asarray(v["c"] + pressure * _tan(v["phi"]))


def _patton(pressure: Floats, v: Mapping[str, float]) -> Floats:
    return np.minimum(pressure * _tan(v["phi"] + v["i"]), v["c"] + pressure * _tan(v["phi"]))


def _barton(pressure: Floats, v: Mapping[str, float]) -> Floats:
    return np.asarray(pressure * _tan(v[BARTON] - v["JRC"] * np.log10(pressure)))


def _ladanyi(pressure: Floats, v: Mapping[str, float]) -> Floats:
    share = np.clip(pressure / v["sigma_c"], 0.0, 1.0)
    sheared = 1.0 - (1.0 - share) ** K1
    slope, mu = (1.0 - share) ** K2 * _tan(v["i"]), _tan(v["phi"])
    rock = v["sigma_c"] * (np.sqrt(1.0 + FAIRHURST) - 1.0) / FAIRHURST
    rock = rock * np.sqrt(1.0 + FAIRHURST * pressure / v["sigma_c"])
    climbed = 1.0 - (1.0 - sheared) * slope * mu
    return np.asarray(
        (pressure * (1.0 - sheared) * (slope + mu) + sheared * rock) / np.maximum(climbed, 0.05)
    )


ANGLES = {"phi": (5.0, 60.0), "i": (0.0, 50.0)}
CRITERIA = (
    Criterion("c + phi", ("c", "phi"), _coulomb, {"c": (0.0, 2.0), "phi": (1.0, STEEPEST)}),
    Criterion("Patton", ("phi", "i", "c"), _patton, ANGLES | {"c": (0.0, 2.0)}),
    Criterion(
        "Barton",
        ("JRC", BARTON),
        _barton,
        # of pressures in any unit
        {"JRC": (0.0, 20.0), BARTON: (-100.0, 300.0)},
    ),
    Criterion(
        "Ladanyi-Archambault",
        ("phi", "i", "sigma_c"),
        _ladanyi,
        ANGLES | {"phi": (5.0, 45.0), "sigma_c": (1.0, 200.0)},
    ),
)
"""Patton (1966); Barton and Choubey (1977); Ladanyi and Archambault (1970), rock of Fairhurst (1964)."""
