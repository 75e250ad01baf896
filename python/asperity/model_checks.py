"""Warnings about a joint, from the library, and checks of the solid beside it: snap-back and mesh."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from . import _core, calls, contract
from .material import Material, ModelWarning
from .options import report_warning
from .pattern import ACROSS, Pattern

FEWEST_ELEMENTS = 3
"""Smallest number of elements in the cohesive zone that resolves the softening (Turon et al. 2007)."""


@dataclass(frozen=True)
class Check:
    """Sentence with its numbers, and whether the model passes the check."""

    text: str
    good: bool


def model_warnings(material: Material, pattern: Pattern, *tractions: float, slip: float = 0.0) -> list[str]:
    """Warnings about a joint under these normal tractions and up to this slip."""
    return _sentences(material, pattern, tractions, slip)[0]


def warn_of_physics(material: Material, pattern: Pattern, *tractions: float, slip: float = 0.0) -> None:
    """Issue each of these warnings as a ModelWarning."""
    for text in model_warnings(material, pattern, *tractions, slip=slip):
        warnings.warn(text, ModelWarning, stacklevel=3)


@contextmanager
def shown_warnings() -> Iterator[list[str]]:
    """Print each warning of a command once on standard error, in one line; the list has them afterwards."""
    shown: list[str] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield shown
    for message in dict.fromkeys(str(warning.message) for warning in caught):
        shown.append(message)
        report_warning(message)


def check_model(
    material: Material,
    pattern: Pattern,
    stress: float | None = None,
    modulus: float | None = None,
    size: float | None = None,
    direction: float | None = None,
    implex: float = 0.0,
) -> list[Check]:
    """Checks of an interface in a model.

    stress: largest compression of the interface, sigma_N < 0.  modulus: Young's modulus E of the solid beside
    it, stress; size: length L of the elements of the solid.  modulus and size must be given together.
    direction: of the slip in 3D, degrees from Tx towards Ty.  implex: PROPS 25.  Raises ValueError for values
    out of range.
    """
    if stress is not None and not (np.isfinite(stress) and stress < 0.0):
        raise ValueError(f"stress = {stress:g}: expected the normal traction in compression, < 0")
    if (modulus is None) != (size is None):
        raise ValueError("modulus and size: expected both or none")
    for name, value in (("modulus", modulus), ("size", size)):
        if value is not None and not (np.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} = {value:g}: expected > 0")
    texts, increment = _sentences(material, pattern, [stress or 0.0])
    checks = [Check(text, good=False) for text in texts]
    if increment:
        checks.append(Check(increment, good=True))
    if modulus is not None and size is not None:
        checks += _mesh(material, modulus, size)
    if direction is not None:
        checks += _facing(pattern, direction)
    if implex > 0.0 and material.damage0 >= 1.0:
        checks.append(_error_of_traction(material, stress))
    return checks


def _error_of_traction(material: Material, stress: float | None) -> Check:
    """Stress over which IMPL-EX takes its error, where there is no bond whose strength sigma0 is."""
    text = f"IMPL-EX: e_t is over the larger of sigma0 = {material.sigma0:g} and mu p, and there is no bond"
    if stress is None:
        return Check(f"{text}: expected sigma0 of at most mu p: give the largest compression", good=False)
    strength = material.mu * abs(stress)
    if material.sigma0 <= strength:
        return Check(f"{text}: mu p is up to {strength:g}", good=True)
    expected = (
        f"sigma0 of at most mu p = {strength:g}, in a smaller unit of length: it is ks times 0.001 of it"
    )
    return Check(f"{text}: expected {expected}", good=False)


def _sentences(
    material: Material, pattern: Pattern, tractions: Sequence[float], slip: float = 0.0
) -> tuple[list[str], str]:
    """Warnings of the library, and its sentence on the increments of slip of an FE code."""
    props = contract.pack(material.values() | pattern.values(), pattern.constants())
    lowest, highest = min(tractions, default=0.0), max(tractions, default=0.0)
    pressure, texts, increment = max(-lowest, 0.0), calls.message_room(), calls.message_room()
    _core.asperity_warn(props, pressure, max(highest, 0.0), slip, texts)
    _core.asperity_slip_increment(props, pressure, slip, increment)
    return calls.text_of(texts).splitlines(), calls.text_of(increment)


def _facing(pattern: Pattern, direction: float) -> list[Check]:
    """Planes that face across the slip, where the separation across is about zero."""
    if not np.isfinite(direction):
        raise ValueError(f"direction = {direction:g}: expected a finite angle")
    planes = pattern.across(direction)
    if not planes:
        return [Check(f"no plane faces across the slip along {direction:g} degrees", good=True)]
    text = (
        "Newton's method may stop in three dimensions, because planes of the pattern face within "
        f"{ACROSS:g} degree across the slip along {direction:g} degrees from Tx: "
        f"{', '.join(map(str, planes))}; expected another turn"
    )
    if pattern.m > 0:
        text += f", best {pattern.turned_from(direction).turn:.4g} degrees"
    return [Check(text, good=False)]


def _mesh(material: Material, modulus: float, size: float) -> list[Check]:
    """Snap-back, elements in the cohesive zone E Gc/sigma0^2 (Hillerborg et al. 1976), and compliance."""
    zone = modulus * material.Gc / material.sigma0**2
    limit = 2.0 * material.eta * zone
    snap_back = f"element size {size:g}, limit 2 eta E Gc/sigma0^2 = {limit:.4g} in mode I: "
    elements = f"cohesive zone E Gc/sigma0^2 = {zone:.4g}, {zone / size:.3g} elements long"
    elastic = modulus / (material.K * size)
    opens = f"the undamaged joint opens by {elastic:.3g} times the elongation of an element: E/(K L)"
    if size < limit:
        snap_back += "the joint does not snap back in front of one element"
    else:
        snap_back += (
            "expected a smaller size, because beyond the limit the joint snaps back: it softens by "
            "sigma0/(s_f - s0), faster than the element beside it unloads by E/L"
        )
    if zone < FEWEST_ELEMENTS * size:
        elements += f": expected at least {FEWEST_ELEMENTS} elements, better 5"
    return [
        Check(snap_back, size < limit),
        Check(elements, zone >= FEWEST_ELEMENTS * size),
        Check(opens, good=True),
    ]
