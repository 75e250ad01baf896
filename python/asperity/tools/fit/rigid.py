"""The law on two rigid sides in closed form: strength and dilation over the slip of the joint."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ...contract import Floats
from .shear_test import ShearTest

HALVINGS, FREE, LOCKED = 12, 1.0e-3, 1.0e3
"""Bisections before a secant of the share of a crushed asperity; least 1 - mu t at which a side slides; and
strength over pressure where it is locked.
"""

Profile = Callable[[Floats, float, float], tuple[Floats, Floats]]
"""Slope, as a share of the first one, and dilation at the slips of a joint of a first slope and a height."""

RIGID_BOND = 0.99
"""Shape eta of a bond from which on friction acts at the first slip."""


def has_closed_form(free: Sequence[str], fixed: Mapping[str, float], sides: int, direction: float) -> bool:
    """Whether a model is two sides, or a flat joint, without wear, closure or a second mode of rupture."""
    absent = ("W0", "closure", "flat", "sigma02", "Gc2", "damage0")
    refused = any(name in free or fixed.get(name) for name in absent)
    bond = "sigma0" in {*free, *fixed}
    brittle = "eta" not in free and fixed.get("eta", 0.0) >= RIGID_BOND
    return not refused and (brittle or not bond) and sides in (0, 2) and direction == 0.0


def exponential(u: Floats, slope: float, height: float) -> tuple[Floats, Floats]:
    """Slope (n,), as a share of the first one, and dilation (n,) of the profile of the law."""
    if height > 0.0 and slope > 0.0:
        left = np.exp(-u * slope / height)
        return left, height * (1.0 - left)
    return np.ones_like(u), u * slope if height <= 0.0 else np.zeros_like(u)


def parabola(u: Floats, slope: float, height: float) -> tuple[Floats, Floats]:
    """The same of a profile whose slope falls along a straight line, to 0 at the slip 2 height/slope."""
    left = np.maximum(0.0, 1.0 - 0.5 * u * slope / height)
    return left, height * (1.0 - left**2)


def hyperbola(u: Floats, slope: float, height: float) -> tuple[Floats, Floats]:
    """The same of a profile whose dilation is a hyperbola, and whose slope never ends."""
    part = 1.0 / (1.0 + u * slope / height)
    return part**2, height * (1.0 - part)


def rigid_curve(
    test: ShearTest, u: Floats, values: Mapping[str, float], profile: Profile = exponential
) -> tuple[Floats, Floats]:
    """Strength (n,) and dilation (n,) at the slips u (n,) >= 0 of the joint itself.

    The slope is rho z' and the dilation rho z, z = H (1 - exp(-u T/H)) or that of another profile, with the
    share rho that crushing leaves, the smallest so far (docs/extensions.md, sections 2 and 7).  A bond pulls
    along the separation, sigma0 (1 - d/d_c), and presses the sides.  The pressure is that of the test at the
    dilation.
    """
    mu, slope = values["mu"], float(np.tan(np.radians(values.get("theta", 0.0))))
    height, crush, bond = (values.get(name, 0.0) for name in ("height", "crush", "sigma0"))
    left, z = profile(u, slope, height)
    steep = slope * left
    pressed = np.full_like(u, -test.sigma_N)
    if test.path_N is not None:
        pressed = np.append(-test.sigma_N, -test.path_N)

    def forces(share: Floats) -> tuple[Floats, Floats]:
        """Pressure on the joint without the pull of the bond, and its pull along the slip and across."""
        opening = share * z
        way = np.maximum(np.hypot(u, opening), 1e-300)
        pull = np.zeros_like(u)
        if bond > 0.0:
            pull = bond * np.maximum(0.0, 1.0 - way * bond / (2.0 * values["Gc"]))
        along, across = np.where(u > 0.0, u / way, 1.0) * pull, opening / way * pull
        return np.maximum(0.0, pressed + test.k_N * opening) + across, along

    def excess(share: Floats) -> Floats:
        """Share of the largest pressure less ln(1 + x)/x, times x."""
        t = share * steep
        x = 2.0 * forces(share)[0] / crush * np.sqrt(1.0 + t * t) / np.maximum(1.0 - mu * t, FREE)
        x *= np.maximum(1.0 - mu * (steep - t), 0.0)
        return share * x - np.log1p(x)

    share = np.ones_like(u)
    if crush > 0.0 and slope > 0.0:
        low, high = np.zeros_like(u), np.ones_like(u)
        below, above = excess(low), excess(high)
        for _ in range(HALVINGS):
            share = 0.5 * (low + high)
            value = excess(share)
            low, below = np.where(value > 0.0, (low, below), (share, value))
            high, above = np.where(value > 0.0, (share, value), (high, above))
        share = low - below * (high - low) / np.maximum(above - below, 1e-300)
        share = np.minimum.accumulate(share)
    normal, along = forces(share)
    free = 1.0 - mu * share * steep
    ratio = np.where(free > FREE, (mu + share * steep) / np.maximum(free, FREE), LOCKED)
    return np.where(u > 0.0, along + normal * ratio, 0.0), share * z
