"""Distribution of uncertain constants: the covariance of a fit, or standard deviations and correlations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ... import contract
from ...case_files import Case
from ...contract import Floats
from ..fit import written
from ..fit.model import INCLINED, KS, TIMELESS, from_scale
from ..fit.report import file_of
from ..fit.written import other_constant

CONSTANTS = tuple(row.name for row in TIMELESS)  # constants that may be uncertain
LEAST_EIGENVALUE = -1.0e-9
"""Smallest eigenvalue of a matrix of correlations that counts as a rounding error of zero."""


@dataclass(frozen=True, eq=False)
class Distribution:
    """Normal distribution of constants, or of their values on their scales where they come from a fit.

    names (p); mean (p,) and covariance (p, p): of the constants, or on their scales.  model_error: relative
    standard deviations of tau and of s_N, by which the law itself misses the tests.  source: file, or option.
    grade: of the fit, and why it is no result; empty without a fit.
    """

    names: tuple[str, ...]
    mean: Floats
    covariance: Floats
    transformed: bool
    source: str
    model_error: tuple[float, float] = (0.0, 0.0)
    grade: str = ""

    @property
    def values(self) -> Floats:
        """Constants at the mean, (p,)."""
        return self._back(self.mean[None])[0] if self.transformed else self.mean

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
        return self._back(x) if self.transformed else x

    def factors(self, samples: int, seed: int) -> Floats:
        """Factors on tau and s_N, (samples, 2), by which the law misses the tests."""
        normal = np.random.default_rng([seed, 1]).standard_normal((samples, 2))
        return 1.0 + np.array(self.model_error) * normal

    def _back(self, x: Floats) -> Floats:
        return np.column_stack(
            [from_scale(name, column) for name, column in zip(self.names, x.T, strict=True)]
        )


def distribution_of(
    case: Case,
    fit: Path | None = None,
    deviations: Mapping[str, float] | None = None,
    correlations: Mapping[tuple[str, str], float] | None = None,
) -> Distribution:
    """Distribution of the constants of a case; arguments of `uncertainty`."""
    path, props = case.path, case.runs[0].props
    if deviations:
        if fit is not None:
            raise ValueError(f"--fit {fit}: expected without --sd")
        distribution = of_deviations(props, deviations, correlations or {})
    else:
        if correlations:
            raise ValueError("--correlation: expected with --sd; a fit has its own")
        file = fit or file_of(path)
        if not file.is_file():
            raise ValueError(
                f"{file}: expected the file that asperity fit -o {path} writes, --fit with its name, or --sd "
                "NAME=VALUE"
            )
        distribution = read(file)
        other = other_constant(case.runs[0], distribution.names, distribution.values.tolist())
        if other:
            raise ValueError(
                f"{file} is stale: {other[0]} = {other[1]:g}, but {path} has {other[2]:g}: expected a case "
                "with the constants of the fit"
            )
    m = case.runs[0].pattern.m
    for name in distribution.names:
        if m == 0 and name in INCLINED:
            raise ValueError(f"{path}: {name}: expected inclined planes, which sides = 0 does not have")
        if m < 0 and name in ("theta", "flat"):
            raise ValueError(f"{path}: {name}: expected a regular pattern, not listed planes")
        if name != KS and len({run.props[contract.index(name)] for run in case.runs}) > 1:
            raise ValueError(f"{path}: &sweep: expected one that leaves {name} alone, which is uncertain")
    return distribution


def read(path: Path) -> Distribution:
    """Distribution of a fit; raises ValueError where the file is not one of `asperity fit`, or has none."""
    fit = written.read(path)
    if "kn" in fit.names:
        raise ValueError(f"{path}: a fit of closure tests: expected one of shear tests, for a slip")
    if not fit.names:
        raise ValueError(f"{path}: a fit without constants: expected one or more")
    for name, value, place in zip(fit.names, fit.values, fit.mean, strict=True):
        if not np.isfinite(place):
            raise ValueError(f"{path}: {name} = {value:g}: expected a value within the range of its scale")
    grade = fit.grade + (f"; not determined: {', '.join(fit.loose)}" if fit.loose else "")
    return Distribution(fit.names, fit.mean, fit.covariance, True, str(path), fit.error, grade)


def of_deviations(
    props: Sequence[float],
    deviations: Mapping[str, float],
    correlations: Mapping[tuple[str, str], float],
) -> Distribution:
    """Distribution of constants about those of PROPS, with standard deviations and correlations by name."""
    for name, size in deviations.items():
        if name not in CONSTANTS:
            raise ValueError(f"{name}: expected one of {', '.join(CONSTANTS)}")
        if not 0.0 < contract.number(f"--sd {name}", size) < np.inf:
            raise ValueError(f"--sd {name}={size:g}: expected a standard deviation > 0")
    names = tuple(deviations)
    matrix = np.eye(len(names))
    for (first, second), value in correlations.items():
        option = f"--correlation {first},{second}={value:g}: "
        if first == second or not {first, second} <= set(names):
            raise ValueError(f"{option}expected two of {', '.join(names)}")
        if not -1.0 <= value <= 1.0:
            raise ValueError(f"{option}expected -1 to 1")
        if (second, first) in correlations:
            raise ValueError(f"{option}given twice: expected one value")
        i, j = names.index(first), names.index(second)
        matrix[i, j] = matrix[j, i] = value
    sizes = np.array([*deviations.values()], dtype=float)
    mean = np.array([props[contract.index(name)] for name in names])
    return Distribution(names, mean, matrix * np.outer(sizes, sizes), False, "--sd")


def bad_constant(props: Floats, names: Sequence[str]) -> str | None:
    """Name of the first constant of PROPS that is out of its range; None where all are admissible."""
    try:
        contract.check(props)
    except ValueError:
        rows = (row for row in contract.props_table() if row.name in names)
        bad = {row.name for row in rows if not row.lower <= props[row.index - 1] <= row.upper}
        return next((name for name in names if name in bad), names[0])
    return None
