"""Distribution of uncertain constants: the covariance of a fit, or standard deviations and correlations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from .. import contract
from ..case_files import Case
from ..contract import Floats
from ..fit.covariance import Distribution, file_of, read
from ..fit.model import TIMELESS

CONSTANTS = tuple(row.name for row in TIMELESS)
"""Constants that may be uncertain."""

DIGITS = 1.0e-4
"""Largest relative difference between a constant of a case and of its fit, which has more digits."""


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
        for name in known.names:
            if name not in CONSTANTS:
                raise ValueError(
                    f"{path}: {name} is no constant of PROPS: expected --sd with {', '.join(CONSTANTS)}"
                )
        for name, value in zip(known.names, known.values, strict=True):
            of_case = props[contract.index(name)]
            if abs(of_case - value) > DIGITS * abs(value):
                raise ValueError(
                    f"{path} is stale: {name} = {value:g}, but {case.path} has {of_case:g}: expected a case "
                    "with the constants of the fit"
                )
        found, source = known, str(path)
    _check_runs(case, found.names)
    return found, source


def _check_runs(case: Case, names: Sequence[str]) -> None:
    """Raise ValueError for constants that a case does not have, or that its sweep changes."""
    path, first = case.path, np.array(case.runs[0].props)
    inclined = [name for name in names if name in ("theta", "flat", "height", "W0")]
    if inclined and case.runs[0].pattern.m == 0:
        raise ValueError(f"{path}: {inclined[0]}: expected inclined planes, which sides = 0 does not have")
    listed = [name for name in names if name in ("theta", "flat")]
    if listed and case.runs[0].pattern.m < 0:
        raise ValueError(f"{path}: {listed[0]}: expected a regular pattern, not listed planes")
    for run in case.runs:
        for name in names:
            if run.props[contract.index(name)] != first[contract.index(name)]:
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
