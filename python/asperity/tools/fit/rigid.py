"""The law on two rigid sides in closed form: strength and dilation over the slip of the joint."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...contract import Floats
from .shear_test import ShearTest
from .thresholds import RIGID_BOND

MOST = 40
"""Steps to the share of a crushed asperity: the 30 after the secants halve its bracket to 1e-9."""

SECANTS = 10
"""First steps to the share, which are secants; later ones are halves, as secants may stay on one side."""

CLOSE = 1.0e-9
"""Error of the share at which the steps end."""

LEAST = 1.0e-9
"""Least pressure over crush, at which ln(1 + x)/x is 1 and no division by 0."""

FREE = 1.0e-3
"""Least 1 - mu t at which a side slides: at 0 it locks, and its strength has no bound."""

LOCKED = 1.0e3
"""Strength over pressure of a locked side, that of a free one at 1 - mu t = FREE where mu + t is 1."""

Profile = Callable[[Floats, float, float], tuple[Floats, Floats]]
"""Slope, as a share of the first one, and dilation at the slips of a joint of a first slope and a height."""

RISE = 0.4
"""Exponent of a bond that rises (fib Model Code 2010, 6.1.1)."""

DIP, SOONER = 0.5, 8.0
"""Slope of the closure before a joint opens, over that of its opening; and how much sooner it ends.

These are the best of nine pairs for one series of tests; another contraction is met less well.
"""


def has_closed_form(free: Sequence[str], fixed: Mapping[str, float], sides: int, direction: float) -> bool:
    """Whether a model is two sides, or a flat joint, of the slip alone.

    That is without wear, closure or a second mode of rupture.
    """
    absent = ("W0", "closure", "flat", "sigma02", "Gc2", "damage0")
    refused = "fc" in free or any(name in free or fixed.get(name) for name in absent)
    bond = "sigma0" in {*free, *fixed}
    brittle = "eta" not in free and fixed.get("eta", 0.0) >= RIGID_BOND
    return not refused and (brittle or not bond) and sides in (0, 2) and direction == 0.0


def exponential(u: Floats, slope: float, height: float) -> tuple[Floats, Floats]:
    """Slope (n,), as a share of the first one, and dilation (n,) of the profile of the law."""
    if height > 0.0 and slope > 0.0:
        remaining = np.exp(-u * slope / height)
        return remaining, height * (1.0 - remaining)
    return np.ones_like(u), u * slope if height <= 0.0 else np.zeros_like(u)


def parabola(u: Floats, slope: float, height: float) -> tuple[Floats, Floats]:
    """The same of a profile whose slope falls along a straight line, to 0 at the slip 2 height/slope."""
    remaining = np.maximum(0.0, 1.0 - 0.5 * u * slope / height)
    return remaining, height * (1.0 - remaining**2)


def cubic(u: Floats, slope: float, height: float) -> tuple[Floats, Floats]:
    """The same of a profile whose slope falls along a parabola, between a line and the law's exponential."""
    remaining = np.maximum(0.0, 1.0 - u * slope / (3.0 * height))
    return remaining**2, height * (1.0 - remaining**3)


def hyperbola(u: Floats, slope: float, height: float) -> tuple[Floats, Floats]:
    """The same of a profile whose dilation is a hyperbola, and whose slope never ends."""
    part = 1.0 / (1.0 + u * slope / height)
    return part**2, height * (1.0 - part)


def bell(u: Floats, slope: float, height: float) -> tuple[Floats, Floats]:
    """The same of a profile whose slope falls as a bell, with the slip 2 height/(sqrt(pi) slope)."""
    from scipy.special import erf

    part = 0.5 * np.sqrt(np.pi) * u * slope / height
    return np.exp(-(part**2)), height * np.asarray(erf(part))


def wave(u: Floats, slope: float, height: float) -> tuple[Floats, Floats]:
    """The same of half a wave, cos^2, whose slope is flat at first and ends at the slip 2 height/slope."""
    part = np.minimum(1.0, 0.5 * u * slope / height)
    return np.cos(0.5 * np.pi * part) ** 2, height * (part + np.sin(np.pi * part) / np.pi)


def contracting(u: Floats, slope: float, height: float) -> tuple[Floats, Floats]:
    """The same of a joint that closes before it opens; the slope is the largest one."""
    part = 1.0 - (1.0 + DIP) / SOONER
    largest = (1.0 - 1.0 / SOONER) * (SOONER * (1.0 + DIP)) ** (-1.0 / (SOONER - 1.0))
    x = u * slope * part / (height * largest)
    late, soon = np.exp(-x), (1.0 + DIP) * np.exp(-SOONER * x)
    return (late - soon) / largest, height * (1.0 - (late - soon / SOONER) / part)


def straight(way: Floats, _: float) -> Floats:
    """Traction of the bond of the law over its strength, at separations over Gc/sigma0."""
    return np.maximum(0.0, 1.0 - 0.5 * way)


def decaying(way: Floats, _: float) -> Floats:
    """The same of a bond that softens exponentially."""
    return np.exp(-way)


def risen(way: Floats, peak: float) -> Floats:
    """The same of a bond that rises to its peak with a power of the separation, as in the Model Code."""
    tail = max(1.0 - peak / (1.0 + RISE), 1e-6)
    soft = np.maximum(0.0, 1.0 - 0.5 * (way - peak) / tail)
    return np.where(way < peak, (np.maximum(way, 0.0) / max(peak, 1e-300)) ** RISE, soft)


def crushed(
    pressure: Callable[[Floats], Floats], mu: float, slope: Floats | float, crush: float, size: int
) -> Floats:
    """Share (n,) of slopes that crushing leaves: ln(1 + x)/x, by secants between bounds, then by halves.

    x is the largest pressure over crush.  pressure: on the joint, over the share (docs/extensions.md,
    section 7).
    """

    def excess(share: Floats) -> Floats:
        t = share * slope
        x = 2.0 * pressure(share) / crush * np.sqrt(1.0 + t * t) / np.maximum(1.0 - mu * t, FREE)
        x = np.maximum(x * np.maximum(1.0 - mu * (slope - t), 0.0), LEAST)
        return np.asarray(share - np.log1p(x) / x)

    high = np.ones(size)
    low, last, beyond = np.zeros_like(high), high, excess(high)
    share = high - beyond
    for step in range(MOST):
        value = excess(share)
        wrong = np.abs(value) > CLOSE
        if not wrong.any():
            break
        low, high = np.where(value > 0.0, low, share), np.where(value > 0.0, share, high)
        change = value - beyond
        secant = share - value * (share - last) / np.where(change == 0.0, 1.0, change)
        last, beyond = share, value
        # where sides lock, secants may stay on one side of the root
        inside = (secant > low) & (secant < high) & (step < SECANTS)
        share = np.where(wrong, np.where(inside, secant, 0.5 * (low + high)), share)
    return share


@dataclass(frozen=True)
class Shape:
    """Profile of the asperities, and softening of the bond over the separation and that at its peak.

    Its constants mean what those of the law mean: first slope and height, strength and energy, and the
    elastic slip at the strength.  rises: whether the bond has this slip itself, and no spring.  climbs:
    whether the slope of the dilation adds to the strength.
    """

    profile: Profile = exponential
    softening: Callable[[Floats, float], Floats] = straight
    rises: bool = False
    climbs: bool = True


LAW, LINE, PARABOLA = "", "slope along a line", "slope along a parabola"
HYPERBOLA, BELL, WAVE = "slope of a hyperbola", "slope of a bell", "slope of a wave"
CONTRACTING = "slope after a contraction"
DECAYING, RISING = "exponential softening", "bond that rises with a power"
WITHOUT = "a slope without friction"
SHAPES = {
    LAW: Shape(),
    LINE: Shape(parabola),
    PARABOLA: Shape(cubic),
    HYPERBOLA: Shape(hyperbola),
    BELL: Shape(bell),
    WAVE: Shape(wave),
    CONTRACTING: Shape(contracting),
    DECAYING: Shape(softening=decaying),
    RISING: Shape(softening=risen, rises=True),
    WITHOUT: Shape(climbs=False),
    f"{WITHOUT}, {DECAYING}": Shape(softening=decaying, climbs=False),
}
"""Shapes by name: that of the law, and others; those without friction of the slope are none for a case."""

SLOPES, SOFTENINGS = (LINE, PARABOLA, HYPERBOLA, BELL, WAVE, CONTRACTING), (DECAYING, RISING)
"""Shapes in place of the slope of the law, and of its softening."""


def climbing(mu: float, slope: Floats) -> Floats:
    """Strength over pressure (n,) of a slip that climbs a slope (n,)."""
    free = 1.0 - mu * slope
    return np.where(free > FREE, (mu + slope) / np.maximum(free, FREE), LOCKED)


def rigid_curve(
    test: ShearTest, u: Floats, values: Mapping[str, float], shape: Shape = SHAPES[LAW]
) -> tuple[Floats, Floats]:
    """Strength (n,) and dilation (n,) at the slips u (n,) >= 0 of the joint itself.

    The slope is rho z' and the dilation rho z, z = H (1 - exp(-u T/H)) or that of another shape, with the
    share rho that crushing leaves, the smallest so far (docs/extensions.md, sections 2 and 7).  A bond pulls
    along the separation d, sigma0 (1 - d/d_c) or that of another shape, and presses the sides.  The pressure
    is that of the test at the dilation.
    """
    mu, slope = values["mu"], float(np.tan(np.radians(values.get("theta", 0.0))))
    height, crush, bond = (values.get(name, 0.0) for name in ("height", "crush", "sigma0"))
    left, z = shape.profile(u, slope, height)
    steep = slope * left if shape.climbs else np.zeros_like(u)
    pressed = np.full_like(u, -test.sigma_N)
    if test.path_N is not None:
        pressed = np.append(-test.sigma_N, -test.path_N)

    def forces(share: Floats) -> tuple[Floats, Floats]:
        """Pressure on the joint without the pull of the bond, and its pull along the slip and across."""
        opening = share * z
        pressure = np.maximum(0.0, pressed + test.k_N * opening)
        if not bond > 0.0:
            return pressure, np.zeros_like(u)
        rise = opening if shape.climbs else np.zeros_like(u)
        way = np.maximum(np.hypot(u, rise), 1e-300)
        at_peak = bond**2 / (values["Gc"] * values["kT"]) if shape.rises else 0.0
        pull = bond * shape.softening(way * bond / values["Gc"], at_peak)
        along, across = np.where(u > 0.0, u / way, 1.0) * pull, rise / way * pull
        return pressure + across, along

    share = np.ones_like(u)
    if crush > 0.0 and slope > 0.0:
        share = np.minimum.accumulate(crushed(lambda share: forces(share)[0], mu, steep, crush, u.size))
    normal, along = forces(share)
    return np.where(u > 0.0, along + normal * climbing(mu, share * steep), 0.0), share * z


def law_strengths(
    pressure: Floats, values: Mapping[str, float], slip: Floats | float = np.inf
) -> tuple[Floats, Floats]:
    """Peak and residual strength of the law on two rigid sides, of which the slip climbs one, (n,) each.

    pressure (n,).  slip (n,): at which the residual strength is read.  The slope T is crushed to rho T,
    rho = log(1 + x)/x with x = (p/crush)(1 - mu (1 - rho) T) and the pressure p on the plane
    (docs/extensions.md, section 7); with a height it is rho T exp(-slip T/H) at the residual strength, and
    without one it has ended there.  A bond sigma0 pulls along the slope and presses its sides.  In tension
    (p < 0) a flat joint holds sigma02 sqrt(1 - (p/sigma0)^2), sigma02 = sigma0 where it is not given.
    """
    tension, pressure = np.minimum(pressure, 0.0), np.maximum(pressure, 0.0)
    mu, angle = values["mu"], float(np.radians(values.get("theta", 0.0)))
    slope = float(np.tan(angle))
    crush, height, share = values.get("crush", 0.0), values.get("height", 0.0), np.ones_like(pressure)
    if crush > 0.0 and slope > 0.0:
        share = crushed(lambda _: pressure, mu, slope, crush, pressure.size)
    remaining = np.exp(-np.asarray(slip) * slope / height) if height > 0.0 else 0.0
    peak, residual = (pressure * climbing(mu, share * slope * part) for part in (1.0, remaining))
    bond = values.get("sigma0", 0.0)
    if bond > 0.0:
        along = values.get("sigma02", 0.0) or bond
        pressed = np.sin(angle) * climbing(mu, share * slope)
        rest = np.sqrt(np.maximum(0.0, 1.0 - (tension / bond) ** 2))
        peak = peak + along * (np.cos(angle) + pressed) * rest
    return peak, residual


def law_peak(pressure: Floats, values: Mapping[str, float]) -> Floats:
    """Peak strength of `law_strengths`."""
    return law_strengths(pressure, values)[0]
