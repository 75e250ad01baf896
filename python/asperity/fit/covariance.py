"""Values and covariance of a fit in a file, from which `asperity uncertainty` draws samples."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..contract import Floats
from .model import SCALES, transformed
from .outcome import Fit

ASYMMETRY = 1.0e-9
"""Largest difference of two opposite elements, over the largest element, that counts as a rounding error."""


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

    @property
    def values(self) -> Floats:
        """Constants at the mean, (p,)."""
        pairs = zip(self.names, self.mean, strict=True)
        return np.array([SCALES[name].back(x) for name, x in pairs]) if self.transformed else self.mean

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


def file_of(case: Path) -> Path:
    """File beside a case, where `asperity fit` writes the covariance."""
    return case.parent / f"{case.stem}.fit.json"


def covariance_text(found: Fit) -> str:
    """Content of the file; the covariance is widened as the intervals of the fit are."""
    names = found.problem.free
    content = {
        "parameters": names,
        "values": [found.values[name] for name in names],
        "transforms": [transformed(name) for name in names],
        "covariance of the transformed values": (found.covariance * found.widening**2).tolist(),
    }
    return json.dumps(content, indent=1) + "\n"


def read(path: Path) -> Distribution:
    """Read the file; raises ValueError where it is not one of `asperity fit`."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        names = tuple(content["parameters"])
        values = np.array(content["values"], dtype=float)
        covariance = np.array(content["covariance of the transformed values"], dtype=float)
        transforms = content["transforms"]
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{path}: expected a file that asperity fit -o has written ({error})") from None
    count = len(names)
    unknown = [name for name in names if name not in SCALES]
    if unknown or transforms != [transformed(name) for name in names]:
        raise ValueError(f"{path}: expected parameters and transforms of this version of asperity fit")
    if not count or values.shape != (count,) or covariance.shape != (count, count):
        raise ValueError(
            f"{path}: expected a value and a row of the covariance for each of {', '.join(names)}"
        )
    finite = np.isfinite(values).all() and np.isfinite(covariance).all()
    least = ASYMMETRY * np.abs(covariance).max()
    if not finite or np.diag(covariance).min() < 0.0 or np.abs(covariance - covariance.T).max() > least:
        raise ValueError(f"{path}: expected finite values, and a symmetric covariance with variances >= 0")
    mean = np.array([SCALES[name].to(value) for name, value in zip(names, values, strict=True)])
    return Distribution(names, mean, covariance, True)
