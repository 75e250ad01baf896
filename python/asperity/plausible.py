"""Values that are probably in another unit than the one that is expected."""

from __future__ import annotations

from math import atan, degrees, radians, tan

STEEPEST = 3.0
"""Largest friction coefficient of a joint; the tangent of 72 degrees."""

FLATTEST = 1.6
"""Smallest friction angle in degrees; 1.6 radians are more than a right angle."""

STRONGEST = 500.0
"""Largest strength of rock, MPa."""

LONGEST = 20.0
"""Largest length of a joint that is tested or described by JRC, m."""

OPENEST = 5.0
"""Largest separation at which a bond breaks, in m or mm."""


def doubts(**values: float) -> list[str]:
    """A sentence for each value, by its name, that is probably in another unit, which it names."""
    reasons = []
    for name, value in values.items():
        text = ""
        if name in ("mu", "tan_phi", "tan_psi") and value > STEEPEST:
            text = f"expected a tangent; that of {value:g} degrees is {tan(radians(value)):.3g}"
            text = text if value < 90.0 else f"expected a tangent below {STEEPEST:g}"
        if name in ("phi", "phi_r") and 0.0 < value < FLATTEST:
            text = f"expected degrees; {value:g} radians are {degrees(value):.3g} degrees"
            text += f", and the angle with this tangent has {degrees(atan(value)):.3g}"
        if name in ("JCS",) and value > STRONGEST:
            text = f"expected MPa; {value:g} kPa are {1e-3 * value:g} MPa"
        if name in ("length", "sample") and value > LONGEST:
            text = f"expected m; {value:g} mm are {1e-3 * value:g} m"
        if text:
            reasons.append(f"{name} = {value:g}: {text}")
    return reasons


def doubts_of_bond(**bonds: tuple[float, float]) -> list[str]:
    """A sentence for each energy that is too large for its strength; pairs of both by the energy's name."""
    reasons = []
    for name, (strength, energy) in bonds.items():
        opening = 2.0 * energy / strength
        if opening > OPENEST:
            text = f"the bond breaks at a separation of {opening:.3g}, twice the energy over the strength"
            reasons.append(f"{name} = {energy:g}: {text}; {energy:g} N/m are {1e-3 * energy:g} N/mm")
    return reasons
