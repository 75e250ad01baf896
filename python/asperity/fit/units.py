"""Units in the headers of test data, by pint, and their conversion to one consistent set."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from ..options import imported

KINDS = {"slip": "length", "dilation": "length", "tau": "stress", "sigma_N": "stress", "k_N": "stiffness"}
KINDS |= {"peak": "stress", "residual": "stress"}
"""What each column of test data measures."""

EXAMPLES = {
    "length": "m, cm, mm, um, in or ft",
    "stress": "Pa, kPa, MPa, N/mm2, kN/m2, bar, psi or ksi",
    "stiffness": "a unit of stress/length, such as MPa/mm",
}
BASE = {"length": "m", "stress": "Pa", "stiffness": "Pa/m"}

DEFAULT = ("mm", "MPa")
"""Units of length and stress to which test data with units are converted."""

NONE = ("length", "stress")
"""Labels of test data without units."""


@cache
def _registry() -> Any:
    return imported("pint").UnitRegistry(cache_folder=None)


@cache
def size(kind: str, text: str) -> float:
    """Unit of a kind (length, stress, stiffness) in SI units; raises ValueError for anything else."""
    plain = re.sub(r"(?<=[A-Za-z])\^?([23])", r"**\1", text.replace("kp", "kgf").strip())
    plain = plain.replace("\N{SUPERSCRIPT TWO}", "**2").replace("\N{SUPERSCRIPT THREE}", "**3")
    registry = _registry()
    try:
        return float(registry.Quantity(1.0, registry.parse_units(plain)).to(BASE[kind]).magnitude)
    except Exception:  # pint raises errors of its own, of Python's tokenizer and of the arithmetic of units
        raise ValueError(f"[{text}]: expected {EXAMPLES[kind]}") from None


def check_target(units: Sequence[str]) -> tuple[str, str]:
    """Units of length and stress; raises ValueError for anything else."""
    try:
        length, stress = units
        size("length", length), size("stress", stress)
    except ValueError as error:
        text = str(error) if len(units) == len(DEFAULT) else "expected LENGTH,STRESS, such as mm,MPa"
        raise ValueError(f"--units {','.join(units)}: {text}") from None
    return length, stress


def factors(
    where: str, columns: Sequence[str], given: Mapping[str, str], target: tuple[str, str]
) -> dict[str, float]:
    """Factor of every column from its unit to that of the target; none where no column has a unit.

    Raises ValueError where only some columns have a unit, or where a unit is not one of the column's kind.
    """
    if not given:
        return {}
    wanted = {"length": target[0], "stress": target[1], "stiffness": f"({target[1]})/({target[0]})"}
    found = {}
    for column in columns:
        kind = KINDS[column]
        if column not in given:
            first, unit = next(iter(given.items()))
            raise ValueError(
                f"{where}: column {column} has no unit: expected one for every column, as {first} [{unit}] "
                "has, or none at all"
            )
        try:
            found[column] = size(kind, given[column]) / size(kind, wanted[kind])
        except ValueError as error:
            raise ValueError(f"{where}: {column} {error}") from None
    return found
