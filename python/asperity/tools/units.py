"""Units of lengths, stresses, stiffnesses, forces and areas, as laboratories write them, by pint."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from typing import Any

from ..contract import Floats, plain

EXAMPLES = {
    "length": ("m", "m, cm, mm, um, in or ft"),
    "stress": ("Pa", "Pa, kPa, MPa, N/mm2, kN/m2, kg/cm2, bar, psi or ksi"),
    "stiffness": ("Pa/m", "a unit of stress/length, such as MPa/mm"),
    "force": ("N", "N, kN, MN, kgf, t or lbf"),
    "area": ("m**2", "m2, cm2, mm2 or in2"),
}
"""SI unit and usual units of each kind."""

NAMES = {
    **{name.lower(): name for name in ("Pa", "hPa", "kPa", "MPa", "GPa", "N", "kN", "MN", "GN")},
    **{name: name for name in ("m", "cm", "mm", "um", "nm", "in", "ft", "psi", "ksi", "psf", "bar", "mbar")},
    **{name: name for name in ("lbf", "kip")},
    **dict.fromkeys(("\u00b5m", "\u03bcm", "micron", "microns", "micrometer", "micrometre"), "um"),
    **dict.fromkeys(("inch", "inches"), "in"),
    **dict.fromkeys(("kg", "kgf", "kp"), "kgf"),
    **dict.fromkeys(("t", "tf", "ton", "tons", "tonf"), "(1000 * kgf)"),
    **dict.fromkeys(("lb", "lbs"), "lbf"),
    **dict.fromkeys(("kips", "klbf"), "kip"),
    "ksf": "(kip / ft**2)",
    "tsf": "(2 * kip / ft**2)",
}
"""Names of units for pint by their lower-case forms.  Masses are the forces that they weigh."""

TONS = [name for name, unit in NAMES.items() if unit == "(1000 * kgf)"]
"""Names of tons, which are those of the United States in units with inches or feet."""

DOUBTFUL = {"mPa": "MPa", "mN": "MN or N", "Mm": "mm", "Mbar": "bar"}
"""Units that mean something else than who writes them usually means, and what may be meant."""

POWER = r"(?:\s*(?:\^|\*\*)?\s*[-\u2212]?[23\u00b2\u00b3])?"
LENGTHS = r"(?:[cmn\u00b5\u03bcu]?m|in(?:ch(?:es)?)?|ft|microns?)"
FORCES = r"(?:[kMG]?N|kgf?|kp|kips?|t(?:f|onf?|ons)?|lb[fs]?)"
STRESSES = r"(?:[hkMG]?Pa|psi|[kpt]sf|ksi|m?bar)"
UNIT = (
    rf"(?:(?:{STRESSES}|{FORCES}|{LENGTHS}|s|min|deg|[-%\u00b0])"
    rf"(?:\s*/\s*{LENGTHS}{POWER}(?:\s*/\s*{LENGTHS})?)?)"
)
SUFFIX = (
    rf"(?:(?:{STRESSES}|[kMG]N|kgf|(?:{FORCES}\s*[/_]\s*){LENGTHS}\s*\^?[23\u00b2\u00b3])(?:\s*/\s*{LENGTHS})?"
    rf"|(?:{LENGTHS})(?<![^_]ft)(?<![^_]in))"
)
HEADER = re.compile(
    rf"\s*(.*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])]|(?:(?:\sin|,)\s+|/\s*)((?i:{UNIT}))|(?<=[\w:,-])[\s_]+((?i:{SUFFIX})))?\s*"
)
"""Name of a column with its unit: in brackets, after `in`, a slash or a comma, or at the end of the name."""

UNITS = re.compile(rf"[\[(]?\s*((?i:{UNIT}))?\s*[\])]?")
"""A cell of a row of units."""


def header(text: str) -> tuple[str, str]:
    """Name and unit of the header of a column; the unit is empty where it has none."""
    part = HEADER.fullmatch(text.replace("\n", " "))
    if part is None or not part[1]:
        return text.strip(), ""
    unit = part[2] or part[3] or re.sub(r"(?<=[a-zA-Z])_(?=[a-zA-Z])", "/", part[4] or "")
    return part[1].rstrip(" -:,/") or part[1], re.sub(r"^in\s+", "", unit.strip())


MENTIONED = re.compile(
    rf"(?:\bunits?\b|[\[(:=,]\s*(?:{STRESSES}|{LENGTHS})\s*(?:[\])]|,|;|$))", re.IGNORECASE
)
"""Text of a comment that may say units of columns."""


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(cache_folder=None)


@cache
def size(kind: str, text: str, where: str = "") -> float:
    """Unit of a kind (a key of EXAMPLES) in SI units; upper and lower case do not matter.

    where: begins the message.  Raises ValueError for anything else, and for mPa and other units that are
    probably misspelt.
    """
    plain = text.strip().replace("\N{MINUS SIGN}", "-").replace("\u00b7", "*")
    plain = plain.translate({0xB2: "2", 0xB3: "3"})
    doubtful = [word for word in re.findall(r"[A-Za-z]+", plain) if word in DOUBTFUL]
    if doubtful:
        raise ValueError(f"{where}[{text}]: expected {DOUBTFUL[doubtful[0]]}, which is probably meant")
    plain = re.sub(r"\s+per\s+", "/", plain)
    plain = re.sub(r"\bsq(?:uare)?\.?\s*([A-Za-z]+)", r"\1^2", plain)
    plain = re.sub(r"(?<=[A-Za-z\u00b5\u03bc])\s*(?:\^|\*\*)?\s*(-?[1-3])(?!\d)", r"**(\1)", plain)
    plain = re.sub(r"(?<=[A-Za-z)])\s+(?=[A-Za-z])", "*", plain)
    feet = {"in", "ft"} & {NAMES.get(word.lower()) for word in re.findall(r"[A-Za-z]+", plain)}
    names = NAMES | dict.fromkeys(TONS, "(2 * kip)") if feet else NAMES
    plain = re.sub(r"[A-Za-z\u00b5\u03bc]+", lambda word: names.get(word[0].lower(), word[0]), plain)
    unit, examples = EXAMPLES[kind]
    if re.search(r"(?<![A-Za-z\u00b5\u03bc^*(-])\d", re.sub(r"(?<=[a-z])\s+(?=-?[1-3])", "", text)):
        raise ValueError(f"{where}[{text}]: expected {examples}")  # a number, as in 0mm, is no unit
    try:
        return float(_registry().parse_expression(plain).to(unit).magnitude)
    except Exception:  # pint raises errors of its own, of Python's tokenizer and of the arithmetic of units
        raise ValueError(f"{where}[{text}]: expected {examples}") from None


def area_of(text: str, option: str = "--area") -> Callable[[Floats], Floats]:
    """Contact area of a shear box over the slip: constant for "A", (L - |slip|) B for "L,B".

    The numbers are in the unit of the slip, L lies along it, and in the square of this unit.  The function
    raises ValueError for a slip of L and more; this one for a text that is no such area.
    """
    import numpy as np

    try:
        sides = [float(plain(part)) for part in text.split(",")]
    except ValueError:
        sides = []
    if len(sides) not in (1, 2) or not all(0.0 < side < np.inf for side in sides):
        wanted = "expected A, an area > 0, or L,B, the sides along and across the slip"
        raise ValueError(f"{option} {text}: {wanted}")
    if len(sides) == 1:
        return lambda slip: np.full(np.shape(slip), sides[0])

    def shrinking(slip: Floats) -> Floats:
        most = float(np.max(np.abs(slip), initial=0.0))
        if most >= sides[0]:
            wanted = f"expected less than L = {sides[0]:g}"
            raise ValueError(f"{option} {text}: the slip reaches {most:g}: {wanted}")
        area: Floats = (sides[0] - np.abs(slip)) * sides[1]
        return area

    return shrinking
