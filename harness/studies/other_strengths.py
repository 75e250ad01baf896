"""Strengths of tests by criteria of others, with noise, and strengths that no joint has."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

Floats = np.ndarray


class Strengths(NamedTuple):
    """Pressures, peaks and residual strengths (n,), or none; and what is true of them.

    truth: constants with the same meaning in the law of asperity.  exact: peaks without noise.  between: a
    pressure between those of the tests, and the peak there.
    """

    pressure: Floats
    peak: Floats
    residual: Floats | None
    truth: dict[str, tuple[float, float]]
    exact: Floats
    between: tuple[float, float]


Curve = Callable[[Floats], Floats]


def _drawn(rng: np.random.Generator, peak: Curve, mu: float | None, truth: dict[str, float]) -> Strengths:
    """Noisy strengths of a curve; with residual strengths mu times the pressure in half of the sets."""
    noise, count = rng.uniform(0.01, 0.05), int(rng.integers(4, 11))
    pressure = np.sort(np.exp(rng.uniform(np.log(0.3), np.log(5.0), count)))
    exact, residual = peak(pressure), None
    if mu is not None and rng.random() < 0.5:
        residual = mu * pressure * (1.0 + rng.normal(0.0, noise, count))
        truth = truth | {"mu": mu}
    measured = exact * (1.0 + rng.normal(0.0, noise, count))
    if residual is not None:
        residual = np.minimum(residual, 0.999 * measured)
    middle = float(np.sqrt(pressure[0] * pressure[-1]))
    ends = {name: (value, value) for name, value in truth.items()}
    return Strengths(pressure, measured, residual, ends, exact, (middle, float(peak(np.array([middle]))[0])))


def coulomb(rng: np.random.Generator) -> Strengths:
    """Peaks c + p tan(phi); sigma0 is c, and mu tan(phi), where the law has a bond."""
    c, mu = rng.uniform(0.1, 1.0), float(np.tan(np.radians(rng.uniform(25.0, 40.0))))
    return _drawn(rng, lambda p: c + mu * p, mu, {"sigma0": c})


def patton(rng: np.random.Generator) -> Strengths:
    """Peaks on teeth of the angle i, which are cut off beyond a pressure; the residual strength without i."""
    phi, i, knee = rng.uniform(26.0, 35.0), rng.uniform(5.0, 20.0), rng.uniform(0.5, 4.0)
    steep, mu = np.tan(np.radians([phi + i, phi]))
    return _drawn(rng, lambda p: np.minimum(steep * p, (steep - mu) * knee + mu * p), float(mu), {})


def ladanyi(rng: np.random.Generator) -> Strengths:
    """Peaks of Ladanyi and Archambault (1970): teeth of the angle i that are sheared off up to sigma_c."""
    phi, i, strong = rng.uniform(26.0, 35.0), rng.uniform(5.0, 20.0), rng.uniform(15.0, 100.0)
    mu, slope = np.tan(np.radians([phi, i]))

    def peak(p: Floats) -> Floats:
        share = np.clip(p / strong, 0.0, 1.0)
        sheared, now = 1.0 - (1.0 - share) ** 1.5, (1.0 - share) ** 4 * slope
        rock = strong * (np.sqrt(11.0) - 1.0) / 10.0 * np.sqrt(1.0 + 10.0 * p / strong)
        return np.asarray(
            (p * (1.0 - sheared) * (now + mu) + sheared * rock) / (1.0 - (1.0 - sheared) * now * mu)
        )

    return _drawn(rng, peak, float(mu), {})


def barton(rng: np.random.Generator) -> Strengths:
    """Peaks of Barton and Choubey (1977); the residual strength by phi_r."""
    jrc, jcs, phi_r = rng.uniform(3.0, 15.0), rng.uniform(30.0, 120.0), rng.uniform(26.0, 33.0)

    def peak(p: Floats) -> Floats:
        return np.asarray(p * np.tan(np.radians(np.minimum(70.0, phi_r + jrc * np.log10(jcs / p)))))

    return _drawn(rng, peak, float(np.tan(np.radians(phi_r))), {})


def nonsense(rng: np.random.Generator) -> Strengths:
    """Strengths that no joint has: noise, one for all pressures, those that fall with the pressure."""
    count, kind = int(rng.integers(4, 11)), int(rng.integers(4))
    pressure = np.sort(np.exp(rng.uniform(np.log(0.3), np.log(5.0), count)))
    if kind == 0:
        peak = np.exp(rng.normal(0.0, 0.6, count))
    elif kind == 1:
        peak = 1.0 + rng.normal(0.0, 0.01, count)
    elif kind == 2:
        peak = 2.0 / pressure**0.5 * (1.0 + rng.normal(0.0, 0.02, count))
    else:
        peak = rng.permutation(0.7 * pressure)
    return Strengths(pressure, peak, None, {}, peak, (float(pressure[0]), float(peak[0])))


STRENGTHS: dict[str, Callable[[np.random.Generator], Strengths]] = {
    "strengths: c + phi": coulomb,
    "strengths: Patton": patton,
    "strengths: Ladanyi-Archambault": ladanyi,
    "strengths: Barton": barton,
    "strengths: nonsense": nonsense,
}
"""Criteria by name."""
