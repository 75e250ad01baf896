"""Checks of a model with an interface: locking, soft contact, asperity height, snap-back, mesh."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from . import contract
from .material import Material, ModelWarning
from .pattern import Pattern

SMALL_CLOSURE = 0.1
"""Closure of a plane that carries the normal traction alone, over s_f, above which a warning is given."""

SMALL_ENERGY = 0.01
"""Elastic energy of the friction on a facing plane over W0, above which a facet may wear off in a jump."""

SMALL_SHARE = 0.1
"""Closure of the facing planes over the asperity height H, above which a warning is given."""

LARGEST_RADIAN = 1.6
"""Inclinations (degrees) below this may have been meant in radians: a right angle is 1.57."""

FEWEST_ELEMENTS = 3
"""Smallest number of elements in the cohesive zone that resolves the softening (Turon et al. 2007)."""


@dataclass(frozen=True)
class Remark:
    """Sentence with its numbers, and whether the model passes the check."""

    text: str
    good: bool


def closure(material: Material, pattern: Pattern, sigma_N: float) -> tuple[float, float]:
    """Closure over s_f of a plane that carries sigma_N (< 0, stress) alone, and weight gamma of the plane.

    The plane is the inclined one of the smallest weight; the flat one if there is no other.
    """
    inclined = _slopes(pattern) > 0.0
    gamma = float(pattern.weights[inclined].min() if inclined.any() else pattern.weights.min())
    kc = material.kc or contract.default("kc")
    return -sigma_N * (1.0 - material.eta) / (gamma * material.sigma0 * kc), gamma


def warn_of_physics(material: Material, pattern: Pattern, sigma_N: float) -> None:
    """Issue a ModelWarning for each doubt about a joint under a normal traction."""
    for text in doubts(material, pattern, sigma_N):
        warnings.warn(text, ModelWarning, stacklevel=3)


def doubts(material: Material, pattern: Pattern, sigma_N: float) -> list[str]:
    """Sentences on what a joint under sigma_N does and one may not expect; none where all is well."""
    slopes = _slopes(pattern)
    found = []
    if sigma_N < 0.0 and slopes.any():
        share, gamma = closure(material, pattern, sigma_N)
        if share > SMALL_CLOSURE:
            found.append(
                f"sigma_N = {sigma_N:g} closes an inclined plane that carries it by {share:.2g} s_f "
                f"(|sigma_N| (1 - eta)/(gamma sigma0 kc), gamma = {gamma:.3g}): the contact is as soft as "
                "the bond, raise kc where closure matters"
            )
    asperities = of_height(material, pattern, sigma_N) + of_wear(material, pattern, sigma_N)
    checked = [_radians(pattern), _locking(material, pattern), *asperities]
    found += [one.text for one in checked if one is not None and not one.good]
    if sigma_N >= material.sigma0:
        found.append(
            f"sigma_N = {sigma_N:g} is not below the strength sigma0 = {material.sigma0:g}: expected less, "
            "beyond it there is no equilibrium"
        )
    return found


@contextmanager
def shown_warnings() -> Iterator[None]:
    """Print each warning of a command once on standard error, in one line."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield
    for message in dict.fromkeys(str(warning.message) for warning in caught):
        print(f"asperity: warning: {message}", file=sys.stderr)


def remarks(
    material: Material,
    pattern: Pattern,
    stress: float | None = None,
    modulus: float | None = None,
    size: float | None = None,
) -> list[Remark]:
    """Remarks on an interface in a model.

    stress: largest compression of the interface, sigma_N < 0.  modulus: Young's modulus E of the solid beside
    it, stress; size: length L of the elements of the solid.  modulus and size must be given together.  Raises
    ValueError for values out of range.
    """
    if stress is not None and not (np.isfinite(stress) and stress < 0.0):
        raise ValueError(f"stress = {stress:g}: expected the normal traction in compression, < 0")
    if (modulus is None) != (size is None):
        raise ValueError("modulus and size: expected both or none")
    for name, value in (("modulus", modulus), ("size", size)):
        if value is not None and not (np.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} = {value:g}: expected > 0")
    found = [_locking(material, pattern), _radians(pattern), *of_height(material, pattern, stress)]
    if stress is not None:
        found += [*of_wear(material, pattern, stress), _contact(material, pattern, stress)]
    if modulus is not None and size is not None:
        found += [_snap_back(material, modulus, size), _zone(material, modulus, size)]
        found.append(_compliance(material, modulus, size))
    return [remark for remark in found if remark is not None]


def _slopes(pattern: Pattern) -> contract.Floats:
    """Tangent of the inclination of every plane."""
    normals = pattern.normals
    return np.hypot(normals[:, 1], normals[:, 2]) / normals[:, 0]


def _locking(material: Material, pattern: Pattern) -> Remark | None:
    """Residual strength (mu + tan theta)/(1 - mu tan theta) up the steepest plane, or locking."""
    steepest = float(_slopes(pattern).max())
    if steepest == 0.0:
        return None
    product = material.mu * steepest
    if product >= 1.0 and material.height > 0.0:
        slip = material.height / steepest * np.log(product)
        text = (
            f"mu tan(theta) = {product:.3g} >= 1: where the interface slides up the steepest plane it locks, "
            f"but only up to the slip (height/tan(theta)) log(mu tan(theta)) = {slip:.3g}"
        )
        return Remark(text, good=True)
    if product >= 1.0:
        text = (
            f"mu tan(theta) = {product:.3g}: expected < 1 for the steepest plane, because from 1 on the "
            "interface locks where it slides up this plane"
        )
        return Remark(text, good=False)
    strength = material.residual_strength(np.degrees(np.arctan(steepest)))
    text = f"mu tan(theta) = {product:.3g} < 1: the residual strength up the steepest plane is {strength:.3g}"
    text += " times the normal traction"
    if material.height > 0.0:
        text += f" at the foot of the asperities and falls to mu = {material.mu:g} at their top"
    return Remark(text, good=True)


def of_height(material: Material, pattern: Pattern, sigma_N: float | None = None) -> list[Remark]:
    """Remarks on the asperity height: H against s_f, and against the closure under sigma_N (< 0, stress)."""
    H = material.height
    if H == 0.0 or not _slopes(pattern).any():
        return []
    s_f = material.s_f
    text = f"height = {H:g}, s_f = 2 Gc/sigma0 = {s_f:.4g}"
    if H < s_f:
        text += ": expected height >= s_f, because the bond of the straight plane breaks within s_f"
    found = [Remark(text, good=H >= s_f)]
    if sigma_N is not None and sigma_N < 0.0:
        share, gamma = closure(material, pattern, sigma_N)
        share *= s_f / H
        text = (
            f"height = {H:g}: sigma_N = {sigma_N:g} closes a plane that carries it alone by {share:.2g} "
            f"height (|sigma_N|/(gamma kc Kn height), gamma = {gamma:.3g})"
        )
        if share > SMALL_SHARE:
            text += f": expected at most {SMALL_SHARE:g}, raise kc or height"
        found.append(Remark(text, good=share <= SMALL_SHARE))
    return found


def of_wear(material: Material, pattern: Pattern, sigma_N: float) -> list[Remark]:
    """Remark on the wear under sigma_N (< 0, stress): W0 against the elastic energy of the friction."""
    if material.W0 == 0.0 or not (sigma_N < 0.0 and _slopes(pattern).any()):
        return []
    _, gamma = closure(material, pattern, sigma_N)
    strength, energy = material.sigma02 or material.sigma0, material.Gc2 or material.Gc
    Kt = strength**2 / (2.0 * energy * (1.0 - material.eta))
    stress = material.mu * sigma_N / gamma
    share = stress / (2.0 * Kt) * (stress / material.W0)
    text = (
        f"W0 = {material.W0:g}: under sigma_N = {sigma_N:g} the friction on a plane that carries it alone "
        f"stores {share:.2g} W0 ((mu sigma_N/gamma)^2/(2 Kt), gamma = {gamma:.3g})"
    )
    if share > SMALL_ENERGY:
        text += f": expected at most {SMALL_ENERGY:g}, beyond it a facet may wear off in a jump"
    return [Remark(text, good=share <= SMALL_ENERGY)]


def _radians(pattern: Pattern) -> Remark | None:
    """Doubt about the unit of a small inclination."""
    if pattern.m > 0 and 0.0 < pattern.theta < LARGEST_RADIAN:
        text = f"theta = {pattern.theta:g} degrees is nearly flat: expected degrees, not radians"
        return Remark(text, good=False)
    return None


def _contact(material: Material, pattern: Pattern, stress: float) -> Remark:
    """Closure under the pressure: with kc = 1 the contact is as soft as the bond."""
    share, gamma = closure(material, pattern, stress)
    text = (
        f"sigma_N = {stress:g} closes a plane that carries it alone by {share:.2g} s_f "
        f"(|sigma_N| (1 - eta)/(gamma sigma0 kc), gamma = {gamma:.3g})"
    )
    if share > SMALL_CLOSURE:
        return Remark(f"{text}: expected at most {SMALL_CLOSURE:g} s_f; raise kc", good=False)
    return Remark(text, good=True)


def _snap_back(material: Material, modulus: float, size: float) -> Remark:
    """Snap-back: the joint must not soften by sigma0/(s_f - s0) faster than the element unloads by E/L."""
    limit = 2.0 * material.eta * _zone_length(material, modulus)
    text = f"element size {size:g}, limit 2 eta E Gc/sigma0^2 = {limit:.4g} in mode I"
    if size >= limit:
        return Remark(
            f"{text}: expected a smaller size, because beyond the limit the joint snaps back: it softens by "
            "sigma0/(s_f - s0), faster than the element beside it unloads by E/L",
            good=False,
        )
    return Remark(f"{text}: the joint does not snap back in front of one element", good=True)


def _zone(material: Material, modulus: float, size: float) -> Remark:
    """Number of elements in the cohesive zone, with the length of Hillerborg et al. (1976)."""
    length = _zone_length(material, modulus)
    text = f"cohesive zone E Gc/sigma0^2 = {length:.4g}, {length / size:.3g} elements long"
    if length < FEWEST_ELEMENTS * size:
        return Remark(f"{text}: expected at least {FEWEST_ELEMENTS} elements, better 5", good=False)
    return Remark(text, good=True)


def _compliance(material: Material, modulus: float, size: float) -> Remark:
    """Elastic opening of the undamaged joint, compared with that of an element."""
    share = modulus / (material.K * size)
    return Remark(
        f"the undamaged joint opens by {share:.3g} times the elongation of an element: E/(K L)", good=True
    )


def _zone_length(material: Material, modulus: float) -> float:
    """Length E Gc/sigma0^2."""
    return modulus * material.Gc / material.sigma0**2
