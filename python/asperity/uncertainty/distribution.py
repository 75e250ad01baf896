"""Distribution of uncertain constants: the covariance of a fit, or standard deviations and correlations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .. import contract
from ..contract import Floats
from ..fit.covariance import Covariance
from ..fit.model import SCALES, TIMELESS

CONSTANTS = tuple(row.name for row in TIMELESS)
"""Constants that may be uncertain."""

LEAST_EIGENVALUE = -1.0e-9
"""Smallest eigenvalue of a matrix of correlations that counts as a rounding error of zero."""


@dataclass(frozen=True, eq=False)
class Distribution:
    """Normal distribution of constants, or of their logarithms and logits where they come from a fit.

    names (p); mean (p,) and covariance (p, p): of the constants, or of the transformed ones.
    """

    names: tuple[str, ...]
    mean: Floats
    covariance: Floats
    transformed: bool

    def draw(self, samples: int, seed: int) -> Floats:
        """Values of the constants, (samples, p); the same for the same seed."""
        deviations = np.sqrt(np.diag(self.covariance))
        scales = np.where(deviations > 0.0, deviations, 1.0)
        # The eigenvalues are those of the correlations, which have no units: beside the variance of a
        # strength in Pa that of a friction coefficient would be a rounding error.
        sizes, vectors = np.linalg.eigh(self.covariance / np.outer(scales, scales))
        if sizes[0] < LEAST_EIGENVALUE:
            raise ValueError(
                f"the correlations of {', '.join(self.names)} contradict each other: expected a covariance "
                "without negative eigenvalues"
            )
        root = vectors * np.sqrt(np.maximum(sizes, 0.0)) @ vectors.T
        normal = np.random.default_rng(seed).standard_normal((samples, len(self.names)))
        x = self.mean + scales * (normal @ root)
        if not self.transformed:
            return x
        return np.column_stack([SCALES[name].back(one) for name, one in zip(self.names, x.T, strict=True)])


def of_fit(found: Covariance) -> Distribution:
    """Distribution of the constants of a fit."""
    pairs = zip(found.names, found.values, strict=True)
    mean = np.array([SCALES[name].to(value) for name, value in pairs])
    return Distribution(found.names, mean, found.covariance, True)


def of_deviations(
    values: Mapping[str, float],
    deviations: Mapping[str, float],
    correlations: Mapping[tuple[str, str], float],
) -> Distribution:
    """Distribution of constants about `values`, with standard deviations and correlations by name."""
    for name, size in deviations.items():
        check_name(name)
        if not 0.0 < size < np.inf:
            raise ValueError(f"--sd {name}={size:g}: expected a standard deviation > 0")
    names = tuple(deviations)
    matrix = np.eye(len(names))
    for (first, second), value in correlations.items():
        if first == second or not {first, second} <= set(names):
            raise ValueError(f"--correlation {first},{second}={value:g}: expected two of {', '.join(names)}")
        if not -1.0 <= value <= 1.0:
            raise ValueError(f"--correlation {first},{second}={value:g}: expected -1 to 1")
        i, j = names.index(first), names.index(second)
        matrix[i, j] = matrix[j, i] = value
    sizes = np.array([deviations[name] for name in names])
    return Distribution(
        names, np.array([values[name] for name in names]), matrix * np.outer(sizes, sizes), False
    )


def check_name(name: str) -> None:
    """Raise ValueError for a constant that cannot be uncertain."""
    if name not in CONSTANTS:
        raise ValueError(f"{name}: expected one of {', '.join(CONSTANTS)}")


def bad_constant(props: Floats, names: Sequence[str]) -> str | None:
    """Name of the first constant of PROPS that is out of its range; None where all are admissible."""
    try:
        contract.check(props)
    except ValueError as error:
        text = str(error)
        return next((name for name in names if f"{name} = " in text), names[0])
    return None
