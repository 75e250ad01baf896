"""Units in the headers of test data: their spellings and their conversion to one consistent set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "in": 0.0254, "ft": 0.3048}
"""Metres of each unit of length."""

STRESSES = {
    "Pa": 1.0,
    "kPa": 1e3,
    "MPa": 1e6,
    "GPa": 1e9,
    "bar": 1e5,
    "psi": 6894.757293168361,
    "ksi": 6894757.293168361,
}
"""Pascals of each unit of stress."""

ALIASES = {
    "N/m2": "Pa",
    "kN/m2": "kPa",
    "MN/m2": "MPa",
    "N/mm2": "MPa",
    "N/m3": "Pa/m",
    "kN/m3": "kPa/m",
    "MN/m3": "MPa/m",
    "N/mm3": "MPa/mm",
}
"""Other accepted spellings."""

KINDS = {"slip": "length", "dilation": "length", "tau": "stress", "sigma_N": "stress", "k_N": "stiffness"}
KINDS |= {"peak": "stress", "residual": "stress"}
"""What each column of test data measures."""

DEFAULT = ("mm", "MPa")
"""Units of length and stress to which test data with units are converted."""


NONE = ("length", "stress")
"""Labels of test data without units."""


def standard(text: str) -> str:
    """Standard spelling of a unit: MPa for N/mm^2."""
    plain = text.replace("\N{SUPERSCRIPT TWO}", "2").replace("\N{SUPERSCRIPT THREE}", "3").replace("^", "")
    plain = plain.replace("\N{MICRO SIGN}", "u").replace("\N{GREEK SMALL LETTER MU}", "u").replace(" ", "")
    return ALIASES.get(plain, plain)


def check_target(units: Sequence[str]) -> tuple[str, str]:
    """Standard spelling of a unit of length and one of stress; raises ValueError for anything else."""
    names = [standard(text) for text in units]
    if len(names) != len(DEFAULT) or names[0] not in LENGTHS or names[1] not in STRESSES:
        raise ValueError(
            f"--units {','.join(units)}: expected LENGTH,STRESS, of {', '.join(LENGTHS)} and "
            f"{', '.join(STRESSES)}"
        )
    return names[0], names[1]


def size(kind: str, unit: str) -> float:
    """Unit of a kind (length, stress, stiffness) in SI units; raises KeyError for a unit of another."""
    if kind == "stiffness":
        stress, _, length = unit.partition("/")
        return STRESSES[stress] / LENGTHS[length]
    return (LENGTHS if kind == "length" else STRESSES)[unit]


def factors(
    where: str, columns: Sequence[str], given: Mapping[str, str], target: tuple[str, str]
) -> dict[str, float]:
    """Factor of every column from its unit to that of the target; none where no column has a unit.

    Raises ValueError where only some columns have a unit, or where a unit is not one of the column's kind.
    """
    if not given:
        return {}
    wanted = {"length": target[0], "stress": target[1], "stiffness": f"{target[1]}/{target[0]}"}
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
            found[column] = size(kind, standard(given[column])) / size(kind, wanted[kind])
        except KeyError:
            known = {"length": ", ".join(LENGTHS), "stress": ", ".join([*STRESSES, "N/mm2"])}
            expected = known.get(kind, "a unit of stress/length, such as MPa/mm")
            raise ValueError(f"{where}: {column} [{given[column]}]: expected {expected}") from None
    return found
