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


@dataclass(frozen=True, eq=False)
class Covariance:
    """Identified parameters: names, values (p,), and covariance (p, p) of the transformed values."""

    names: tuple[str, ...]
    values: Floats
    covariance: Floats


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


def read(path: Path) -> Covariance:
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
    return Covariance(names, values, covariance)
