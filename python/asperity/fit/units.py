"""Units in the headers of test data, by pint, and their conversion to one consistent set."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

KINDS = {"slip": "length", "dilation": "length", "tau": "stress", "sigma_N": "stress", "k_N": "stiffness"}
KINDS |= {"peak": "stress", "residual": "stress"}
"""What each column of test data measures."""

EXAMPLES = {
    "length": ("m", "m, cm, mm, um, in or ft"),
    "stress": ("Pa", "Pa, kPa, MPa, N/mm2, kN/m2, bar, psi or ksi"),
    "stiffness": ("Pa/m", "a unit of stress/length, such as MPa/mm"),
}
"""SI unit and usual units of each kind."""

DEFAULT = ("mm", "MPa")
"""Units of length and stress to which test data with units are converted."""

NONE = ("length", "stress")
"""Labels of test data without units."""


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(cache_folder=None)


@cache
def size(kind: str, text: str) -> float:
    """Unit of a kind (length, stress, stiffness) in SI units; raises ValueError for anything else."""
    plain = re.sub(r"(?<=[A-Za-z])\^?([23])", r"**\1", text.replace("kp", "kgf").strip())
    plain = plain.replace("\N{SUPERSCRIPT TWO}", "**2").replace("\N{SUPERSCRIPT THREE}", "**3")
    unit, examples = EXAMPLES[kind]
    registry = _registry()
    try:
        return float(registry.Quantity(1.0, registry.parse_units(plain)).to(unit).magnitude)
    except Exception:  # pint raises errors of its own, of Python's tokenizer and of the arithmetic of units
        raise ValueError(f"[{text}]: expected {examples}") from None


def check_target(units: Sequence[str]) -> tuple[str, str]:
    """Units of length and stress; raises ValueError for anything else."""
    try:
        length, stress = units
        size("length", length), size("stress", stress)
    except ValueError as error:
        text = str(error) if len(units) == len(DEFAULT) else "expected LENGTH,STRESS, such as mm,MPa"
        raise ValueError(f"--units {','.join(units)}: {text}") from None
    return length, stress


def factors(given: Mapping[str, str], target: tuple[str, str]) -> list[float]:
    """Factor of every column from its unit to that of the target, 1 where no column has a unit.

    Raises ValueError where only some columns have a unit, or where a unit is not one of the column's kind.
    """
    wanted = {"length": target[0], "stress": target[1], "stiffness": f"({target[1]})/({target[0]})"}
    first = next((f"{name} [{unit}]" for name, unit in given.items() if unit), "")
    found = []
    for name, unit in given.items() if first else ():
        if not unit:
            raise ValueError(
                f"column {name} has no unit: expected one for every column, as {first} has, or none at all"
            )
        try:
            found.append(size(KINDS[name], unit) / size(KINDS[name], wanted[KINDS[name]]))
        except ValueError as error:
            raise ValueError(f"{name} {error}") from None
    return found or [1.0] * len(given)
