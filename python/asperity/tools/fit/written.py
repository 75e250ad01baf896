"""The file of a fit beside its case, for those who use the case: units, grade, and what the tests covered."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ... import contract
from ...case_files import Run
from ...contract import Floats
from .columns import NONE
from .model import KS, KT, SCALES, from_scale, to_scale
from .thresholds import BEYOND

DIGITS = 1.0e-4
"""Largest relative difference between a constant of a case and of its fit, which has more digits."""

ASYMMETRY = 1.0e-9
"""Largest difference of two opposite elements, over the largest element, that counts as a rounding error."""

GRADES = ("good", "fair", "poor")
"""Grades of a fit."""

LARGEST = 1.0e30
"""Largest number in the file of a fit."""


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
        if not isinstance(content, dict):
            raise ValueError(f"{contract.shown(content)}: expected an object")
        names, count = _words(content, "parameters"), len(content["parameters"])
        values, p = _numbers(content, "values", (count,)), _numbers(content, "pressures", (2,))
        covariance, error = (
            _numbers(content, "covariance on the scales", (count, count)),
            _numbers(content, "model error of tau and s_N", (2,), 0.0),
        )
        slip = float(_numbers(content, "slip", (), 0.0))
        units, grade, reasons = _words(content, "units"), content["grade"], _words(content, "no result")
        loose, scales = _words(content, "not determined"), _words(content, "scales")
        with np.errstate(divide="ignore", invalid="ignore"):
            places = [float(to_scale(name, value)) for name, value in zip(names, values, strict=True)]
        least = ASYMMETRY * np.abs(covariance).max(initial=0.0)
        expected: list[tuple[str, bool, str]] = [
            (
                "parameters",
                len(set(names)) == count and set(names) <= {*SCALES, "kn"} - {KT},
                "constants of a joint, each once",
            ),
            ("scales", scales == tuple(SCALES.get(name, "log") for name in names), "those of the parameters"),
            ("units", len(units) == 2, "two words"),
            ("values", not np.isnan(places).any(), "a value on the scale of each parameter"),
            ("pressures", p[0] <= p[1], "the smallest and the largest one"),
            ("grade", grade in GRADES, f"one of {', '.join(GRADES)}"),
            (
                "covariance on the scales",
                bool(
                    np.allclose(covariance, covariance.T, rtol=0.0, atol=least)
                    and np.all(np.diag(covariance) >= 0.0)
                ),
                "a symmetric matrix without a negative variance",
            ),
        ]
        for key, holds, text in expected:
            if not holds:
                raise ValueError(f"{key} = {contract.shown(content[key])}: expected {text}")
    except (OSError, KeyError, TypeError, ValueError, RecursionError) as problem:
        text = "expected a file that this version of asperity fit -o has written"
        raise ValueError(f"{path}: {text} ({problem})") from None
    said = "; no result: ".join([grade, *reasons[:1]])
    ends, errors = (float(p[0]), float(p[1])), (float(error[0]), float(error[1]))
    return Written(
        (units[0], units[1]), names, tuple(values.tolist()), said, ends, slip, covariance, errors, loose
    )


def _numbers(content: dict[str, Any], key: str, shape: tuple[int, ...], least: float = -LARGEST) -> Floats:
    """Numbers of this shape; raises ValueError with the name and the value of what is none."""
    listed = [content[key]]
    for size in shape:
        for value in listed:
            if not isinstance(value, list) or len(value) != size:
                raise ValueError(f"{key} = {contract.shown(value)}: expected a list of {size}")
        listed = [number for value in listed for number in value]
    for number in listed:
        sound = isinstance(number, int | float) and not isinstance(number, bool)
        if not sound or not least <= number <= LARGEST:
            raise ValueError(f"{key} = {contract.shown(number)}: expected a number, {least:g} to {LARGEST:g}")
    return np.array(listed, dtype=float).reshape(shape)


def _words(content: dict[str, Any], key: str) -> tuple[str, ...]:
    """Words of a list; raises ValueError with the name and the value of what is none."""
    values = content[key]
    if not isinstance(values, list):
        raise ValueError(f"{key} = {contract.shown(values)}: expected a list of words")
    for value in values:
        if not isinstance(value, str):
            raise ValueError(f"{key} = {contract.shown(value)}: expected a word")
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
