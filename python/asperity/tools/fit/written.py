"""The file of a fit beside its case, for those who use the case: units, grade, and what the tests covered."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ... import contract
from ...case_files import Run
from ...contract import Floats
from .columns import NONE
from .model import KS, KT, SCALES, from_scale, to_scale

DIGITS = 1.0e-4
"""Largest relative difference between a constant of a case and of its fit, which has more digits."""

ASYMMETRY = 1.0e-9
"""Largest difference of two opposite elements, over the largest element, that counts as a rounding error."""

BEYOND = 1.01
"""Ratio of a pressure or slip to those of the tests of a fit above which it lies beyond them."""


def other_constant(
    run: Run, names: Sequence[str], values: Sequence[float]
) -> tuple[str, float, float] | None:
    """First constant of a fit whose value the case does not have: name, value of the fit and of the case."""
    for name, value in zip(names, values, strict=True):
        if name == "kn":
            of_case = run.props[contract.index("kc")] * run.material.K
        else:
            of_case = run.material.K if name == KS else run.props[contract.index(name)]
        if abs(of_case - value) > DIGITS * abs(value):
            return name, value, of_case
    return None


@dataclass(frozen=True)
class Written:
    """What the file of a fit says: units, names and values of constants, grade with the reason of no result.

    pressures: smallest and largest of the tests of the fit, stress.  slip: largest of their curves, length; 0
    without curves.  covariance (p, p): of the constants on their scales.  error: relative model errors of tau
    and of s_N.  loose: constants that are not determined.
    """

    units: tuple[str, str]
    names: tuple[str, ...]
    values: tuple[float, ...]
    grade: str
    pressures: tuple[float, float]
    slip: float
    covariance: Floats
    error: tuple[float, float]
    loose: tuple[str, ...]

    @property
    def mean(self) -> Floats:
        """Values on their scales, (p,); that of a logarithm of zero is not finite."""
        with np.errstate(divide="ignore"):
            return np.array(
                [float(to_scale(name, value)) for name, value in zip(self.names, self.values, strict=True)]
            )

    def moved(self, props: Floats, step: float) -> list[tuple[float, Floats, Floats]]:
        """Axes of the covariance, whose effects are independent: PROPS at both ends of a step, and a factor.

        step: over the standard deviation.  factor: of the difference, for one standard deviation.
        """
        sizes, axes = np.linalg.eigh(self.covariance)
        at, pairs = self.mean, []
        for size, axis in zip(np.sqrt(np.maximum(sizes, 0.0)), axes.T, strict=True):
            pair = []
            for side in (-1.0, 1.0):
                x = at + side * step * size * axis
                sample = [float(from_scale(name, value)) for name, value in zip(self.names, x, strict=True)]
                pair.append(with_constants(props.tolist(), self.names, sample))
            pairs.append((1.0 / (2.0 * step), pair[0], pair[1]))
        return pairs

    def remarks(self, run: Run, covered: tuple[float, float, float]) -> Iterator[str]:
        """Lines about a case with this file, for tests with these pressures and largest slip."""
        other = other_constant(run, self.names, self.values)
        if other:
            yield f"fit         {other[0]} = {other[1]:g}, but the case has {other[2]:g}: another joint"
            return
        yield f"fit         grade {self.grade}"
        (low, high), (least, most, slip) = self.pressures, covered
        ends = f"{low:.4g} to {high:.4g}{self._unit(1)}"
        if most > BEYOND * high or BEYOND * least < low:
            beyond = most if most > BEYOND * high else least
            yield f"note        a pressure of {beyond:.4g}: the tests of the fit had {ends}"
        if 0.0 < BEYOND * self.slip < slip:
            end = f"{self.slip:.4g}{self._unit(0)}"
            yield f"note        a slip of {slip:.4g}: the tests of the fit ended at {end}"

    def _unit(self, place: int) -> str:
        return "" if self.units == NONE else f" {self.units[place]}"


def written_beside(path: Path) -> Written | None:
    """Content of the file of a fit; None where there is no such file.  Raises ValueError as `read`."""
    return read(path) if path.exists() else None


def read(path: Path) -> Written:
    """Content of the file of a fit; raises ValueError where it is not one of `asperity fit`."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        length, stress = _words(content["units"])
        low, high, slip = _numbers([*content["pressures"], content["slip"]])
        error, of_dilation = _numbers(content["model error of tau and s_N"])
        names = _words(content["parameters"])
        rows = [_numbers(row) for row in content["covariance on the scales"]]
        fit = Written(
            (length, stress),
            names,
            _numbers(content["values"]),
            "; no result: ".join(_words([content["grade"], *_words(content["no result"])[:1]])),
            (low, high),
            slip,
            np.array(rows) if rows else np.zeros((0, 0)),
            (error, of_dilation),
            _words(content["not determined"]),
        )
        if _words(content["scales"]) != tuple(SCALES.get(name, "log") for name in names):
            raise ValueError("the scales of its constants")
        if len(set(names)) < len(names) or not set(names) <= {*SCALES, "kn"} - {KT}:
            raise ValueError("constants of a joint, each once")
        with np.errstate(invalid="ignore"):
            sound = np.isfinite([*fit.values, low, high, slip]).all() and not np.isnan(fit.mean).any()
        matrix = fit.covariance
        sound = sound and matrix.shape == (len(names), len(names))
        # the intervals of a fit end at plausible values, so that none is without bound
        for key, numbers in (("covariance on the scales", matrix), ("model error of tau and s_N", fit.error)):
            for number in np.ravel(numbers).tolist():
                if not np.isfinite(number):
                    raise ValueError(f"{key} has {number:g}: expected finite numbers")
        least = ASYMMETRY * np.abs(matrix).max(initial=0.0)
        sound = sound and np.allclose(matrix, matrix.T, rtol=0.0, atol=least)
        if not sound or np.any(np.diag(matrix) < 0.0) or min(fit.error) < 0.0:
            raise ValueError(
                "finite values, pressures and slip, a symmetric covariance, no negative variance or error"
            )
    except (OSError, KeyError, TypeError, ValueError, OverflowError, RecursionError) as problem:
        text = "expected a file that this version of asperity fit -o has written"
        raise ValueError(f"{path}: {text} ({problem})") from None
    return fit


def _numbers(values: Iterable[Any]) -> tuple[float, ...]:
    """Numbers of a list; raises TypeError for what is none."""
    listed = tuple(values)
    for value in listed:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise TypeError(f"{value!r}: expected a number")
    return tuple(map(float, listed))


def _words(values: Iterable[Any]) -> tuple[str, ...]:
    """Words of a list; raises TypeError for what is none."""
    if isinstance(values, str) or not all(isinstance(value, str) for value in values):
        raise TypeError(f"{values!r}: expected a list of words")
    return tuple(values)


def with_constants(props: Sequence[float], names: Sequence[str], sample: Sequence[float]) -> Floats:
    """PROPS with other values of constants; ks is the stiffness of a joint without bond."""
    sampled, values = np.array(props), dict(zip(names, sample, strict=True))
    ks = values.pop(KS, None)
    for name, value in values.items():
        sampled[contract.index(name)] = value
    if ks is not None:
        for name, value in contract.joint_constants(sampled[contract.index("kc")] * ks, ks).items():
            sampled[contract.index(name)] = value
    return sampled
