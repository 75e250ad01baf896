"""Constants that a fit may identify: their scales and plausible ranges, and which are free by default."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from .. import contract
from ..contract import Floats
from ..material import Material
from .shear_test import ShearTest

TIMELESS = tuple(
    row
    for row in contract.owned("law", "pattern")
    if row.scale != "whole" and row.lower >= 0.0 and row.name != "tau_v"
)
"""Constants that can be identified: numbers >= 0 that matter in tests without a time."""

MATERIAL = tuple(row.name for row in TIMELESS if row.owner == "law")
"""Constants of the material; the others are those of the pattern."""

KS = "ks"
"""Shear stiffness of a joint without bond, a constant in place of those of the bond."""

BOND = ("sigma0", "Gc", "eta", "sigma02", "Gc2", "damage0")
"""Constants of the material that a joint without bond does not have."""

INCLINED = ("theta", "flat", "height", "W0", "crush")
"""Constants of inclined planes."""

ROCK, MORTAR, AUTO = "rock", "mortar", "auto"
"""Forms of a joint: without bond, with bond, and that of the two which the tests support."""

SCALES = {row.name: row.scale for row in TIMELESS} | {KS: "log"}
UNITS = {row.name: row.unit for row in TIMELESS} | {KS: "stress/length", "K": "stress/length"}
UNITS |= {"s_f": "length", "s0": "length", "ratio": "-"}
PLAUSIBLE = {row.name: row.plausible for row in TIMELESS} | {KS: (1e-2, 1e5), "kn": (1e-2, 1e8)}
"""Scale, unit and plausible range of a constant; the range is in multiples of the size of its unit."""

STARTS = {"sigma0": (0.05, 2.0), "s_f": (0.02, 1.5), "eta": (0.4, 0.97), "mu": (0.15, 1.0), KS: (1.0, 1e3)}
STARTS |= {"theta": (5.0, 45.0), "flat": (0.1, 0.6), "kc": (0.5, 50.0)}
STARTS |= {"height": (0.03, 3.0), "W0": (0.05, 5.0)}
"""Ranges of the starts, of s_f in place of Gc, because the tests show its size; of others the middle."""

DEFAULTS = {"eta": 0.9} | {
    row.name: row.default for row in TIMELESS if row.default is not None and row.name != "theta"
}
"""Values of constants that are neither free nor set."""


def defaults(form: str) -> dict[str, float]:
    """Values of constants that are neither free nor set; the contact of a joint without bond is stiff."""
    return DEFAULTS | ({"kc": 20.0} if form == ROCK else {})


def to_scale(name: str, value: ArrayLike) -> Floats:
    """Value on the scale of the constant, on which a fit works: its logarithm, logit or itself."""
    value = np.asarray(value, dtype=float)
    scale = SCALES.get(name, "log")
    return value if scale == "linear" else np.log(value / (1.0 - value) if scale == "logit" else value)


def from_scale(name: str, x: ArrayLike) -> Floats:
    """Value of a constant from that on its scale, within the range of doubles."""
    x = np.clip(np.asarray(x, dtype=float), -700.0, 700.0)
    scale = SCALES.get(name, "log")
    found: Floats = x if scale == "linear" else 1.0 / (1.0 + np.exp(-x)) if scale == "logit" else np.exp(x)
    return found


def material_of(values: Mapping[str, float]) -> Material:
    """Material of constants by name, or their defaults; with ks that of a joint without bond."""
    given = {name: values[name] for name in MATERIAL if name in values}
    if KS not in values:
        return Material(**given)
    return Material.from_joint(kn=given.pop("kc") * values[KS], ks=values[KS], **given)


def sizes(tests: Sequence[ShearTest]) -> tuple[float, float]:
    """Largest stress and length of tests, with which the ranges of the constants are multiplied."""
    stress = max(float(np.abs(test.tau).max()) for test in tests)
    return stress, max(float(np.abs(test.slip).max()) for test in tests)


def plausible(name: str, stress: float, length: float) -> tuple[float, float]:
    """Ends of what joints have in tests of this size."""
    size = _unit_size(name, stress, length)
    low, high = PLAUSIBLE[name]
    return low * size, high * size


def start_range(name: str, stress: float, length: float) -> tuple[float, float]:
    """Ends, on the scale of the constant, of the range of the starts."""
    if name in STARTS:
        low, high = to_scale(name, np.array(STARTS[name]) * _unit_size(name, stress, length)).tolist()
        return low, high
    low, high = to_scale(name, plausible(name, stress, length)).tolist()
    return low + (high - low) / 3.0, high - (high - low) / 3.0


def _unit_size(name: str, stress: float, length: float) -> float:
    """Size of the unit of a constant from those of stress and length."""
    sizes = {"stress": stress, "length": length, "stress*length": stress * length}
    return (sizes | {"stress/length": stress / length}).get(UNITS.get(name, "stress/length"), 1.0)


def joints(names: Collection[str], joint: str) -> list[str]:
    """Forms of a joint that are possible with these constants free or set; raises ValueError."""
    if joint not in (ROCK, MORTAR, AUTO):
        raise ValueError(f"joint = {joint!r}: expected {ROCK}, {MORTAR} or {AUTO}")
    of_bond = [name for name in BOND if name in names]
    if of_bond and (KS in names or joint == ROCK):
        wrong = f"{', '.join(of_bond)}: expected without {KS}"
        raise ValueError(f"{wrong}, which is that of a joint without bond")
    if KS in names and joint == MORTAR:
        raise ValueError(f"{KS}: expected without a bond, --joint {ROCK}")
    return [joint] if joint != AUTO else [MORTAR] if of_bond else [ROCK] if KS in names else [MORTAR, ROCK]


def default_free(tests: Sequence[ShearTest], joint: str, sides: int, fixed: Mapping[str, float]) -> list[str]:
    """Constants that are free unless they are set: those which shear-box tests of this form can show.

    theta needs a measured dilation, flat and kc this or theta, and height a dilation that ends.
    """
    free = [KS, "mu"] if joint == ROCK else ["sigma0", "Gc", "eta", "mu"]
    dilates = any(test.s_N is not None and np.ptp(test.s_N) > 0.0 for test in tests)
    if any(test.envelope for test in tests):
        return free[-1:] if joint == ROCK else ["sigma0", "mu"]
    if sides == 0 or not (dilates or fixed.get("theta")):
        return free
    free += ["theta"] * dilates + ["flat", "kc"]
    return free + ["height"] * any(test.saturates for test in tests)
