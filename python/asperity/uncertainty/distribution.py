"""Distribution of uncertain constants: the covariance of a fit, or standard deviations and correlations."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import contract
from ..case_files import Case
from ..contract import Floats
from ..fit.model import INCLINED, KS, SCALES, TIMELESS, from_scale, to_scale
from ..fit.report import file_of
from ..material import Material

CONSTANTS = tuple(row.name for row in TIMELESS)
"""Constants that may be uncertain."""

DIGITS = 1.0e-4
"""Largest relative difference between a constant of a case and of its fit, which has more digits."""


ASYMMETRY = 1.0e-9
"""Largest difference of two opposite elements, over the largest element, that counts as a rounding error."""

LEAST_EIGENVALUE = -1.0e-9
"""Smallest eigenvalue of a matrix of correlations that counts as a rounding error of zero."""


@dataclass(frozen=True, eq=False)
class Distribution:
    """Normal distribution of constants, or of their values on their scales where they come from a fit.

    names (p); mean (p,) and covariance (p, p): of the constants, or on their scales.  model_error: relative
    standard deviations of tau and of s_N, by which the law itself misses the tests.
    """

    names: tuple[str, ...]
    mean: Floats
    covariance: Floats
    transformed: bool
    model_error: tuple[float, float] = (0.0, 0.0)

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
        return np.column_stack([from_scale(name, one) for name, one in zip(self.names, x.T, strict=True)])


def distribution_of(
    case: Case,
    fit: Path | None = None,
    deviations: Mapping[str, float] | None = None,
    correlations: Mapping[tuple[str, str], float] | None = None,
) -> tuple[Distribution, str]:
    """Distribution of the constants of a case, and where it comes from; arguments of `uncertainty`."""
    props = np.array(case.runs[0].props)
    if deviations:
        if fit is not None:
            raise ValueError(f"--fit {fit}: expected without --sd")
        for name in deviations:
            check_name(name)
        values = {name: float(props[contract.index(name)]) for name in deviations}
        found, source = of_deviations(values, deviations, correlations or {}), "--sd"
    else:
        if correlations:
            raise ValueError("--correlation: expected with --sd; a fit has its own")
        path = fit or file_of(case.path)
        if not path.is_file():
            raise ValueError(
                f"{path}: expected the file that asperity fit -o {case.path} writes, --fit with its name, "
                "or --sd NAME=VALUE"
            )
        known = read(path)
        for name, value in zip(known.names, known.values, strict=True):
            of_case = case.runs[0].interface.material.K if name == KS else props[contract.index(name)]
            if abs(of_case - value) > DIGITS * abs(value):
                raise ValueError(
                    f"{path} is stale: {name} = {value:g}, but {case.path} has {of_case:g}: expected a case "
                    "with the constants of the fit"
                )
        found, source = known, str(path)
    _check_runs(case, found.names)
    return found, source


def read(path: Path) -> Distribution:
    """Read the file; raises ValueError where it is not one of `asperity fit`."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        names = tuple(content["parameters"])
        values = np.array(content["values"], dtype=float)
        covariance = np.array(content["covariance on the scales"], dtype=float)
        scales = content["scales"]
        error, of_dilation = map(float, content["model error of tau and s_N"])
    except (KeyError, TypeError, ValueError) as problem:
        raise ValueError(f"{path}: expected a file that asperity fit -o has written ({problem})") from None
    count = len(names)
    if any(name not in SCALES for name in names) or scales != [SCALES[name] for name in names]:
        raise ValueError(f"{path}: expected constants and scales of this version of asperity fit")
    if not count or values.shape != (count,) or covariance.shape != (count, count):
        raise ValueError(
            f"{path}: expected a value and a row of the covariance for each of {', '.join(names)}"
        )
    finite = np.isfinite([*values, *covariance.ravel(), error, of_dilation]).all()
    least = ASYMMETRY * np.abs(covariance).max()
    if not finite or np.diag(covariance).min() < 0.0 or np.abs(covariance - covariance.T).max() > least:
        raise ValueError(f"{path}: expected finite values, and a symmetric covariance with variances >= 0")
    mean = np.array([float(to_scale(name, value)) for name, value in zip(names, values, strict=True)])
    return Distribution(names, mean, covariance, True, (error, of_dilation))


def _check_runs(case: Case, names: Sequence[str]) -> None:
    """Raise ValueError for constants that a case does not have, or that its sweep changes."""
    path, first = case.path, np.array(case.runs[0].props)
    inclined = [name for name in names if name in INCLINED]
    if inclined and case.runs[0].pattern.m == 0:
        raise ValueError(f"{path}: {inclined[0]}: expected inclined planes, which sides = 0 does not have")
    listed = [name for name in names if name in ("theta", "flat")]
    if listed and case.runs[0].pattern.m < 0:
        raise ValueError(f"{path}: {listed[0]}: expected a regular pattern, not listed planes")
    for run in case.runs:
        for name in names:
            if name != KS and run.props[contract.index(name)] != first[contract.index(name)]:
                raise ValueError(f"{path}: &sweep: expected one that leaves {name} alone, which is uncertain")


def of_deviations(
    values: Mapping[str, float],
    deviations: Mapping[str, float],
    correlations: Mapping[tuple[str, str], float],
) -> Distribution:
    """Distribution of constants about `values`, with standard deviations and correlations by name."""
    for name, size in deviations.items():
        check_name(name)
        if not 0.0 < contract.number(f"--sd {name}", size) < np.inf:
            raise ValueError(f"--sd {name}={size:g}: expected a standard deviation > 0")
    names = tuple(deviations)
    matrix = np.eye(len(names))
    for k, ((first, second), value) in enumerate(correlations.items()):
        if first == second or not {first, second} <= set(names):
            raise ValueError(f"--correlation {first},{second}={value:g}: expected two of {', '.join(names)}")
        if not -1.0 <= value <= 1.0:
            raise ValueError(f"--correlation {first},{second}={value:g}: expected -1 to 1")
        if (second, first) in list(correlations)[:k]:
            raise ValueError(f"--correlation {first},{second}={value:g}: given twice: expected one value")
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


def with_constants(props: Floats, names: Sequence[str], sample: Floats) -> Floats:
    """PROPS with other values of constants; ks is the stiffness of a joint without bond."""
    found = props.copy()
    for name, value in zip(names, sample.tolist(), strict=True):
        if name != KS:
            found[contract.index(name)] = value
    if KS in names:
        ks = float(sample[list(names).index(KS)])
        bond = Material.from_joint(kn=found[contract.index("kc")] * ks, ks=ks, mu=0.5)
        for name in ("sigma0", "Gc", "eta", "kc"):
            found[contract.index(name)] = getattr(bond, name)
    return found
