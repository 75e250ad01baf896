"""Strength of a joint whose asperities are crushed, in closed form."""

from __future__ import annotations

import numpy as np
from asperity.contract import Floats
from scipy.optimize import brentq


def strength(sigma_n: float, slope: float, mu: float, crush: float, weight: float = 1.0) -> float:
    """Shear strength of a joint without bond that begins to climb one plane, whose pressure crushes it.

    slope: tangent of the inclination; weight: of the plane; crush: stress, inf for none.  Closed form of
    docs/extensions.md, section 7.
    """

    def forces(p: float) -> Floats:
        t = slope * np.log1p(p / crush) / (p / crush) if np.isfinite(crush) else slope
        return np.asarray(weight * p / np.hypot(1.0, t) * np.array([1.0 - mu * t, t + mu]))

    p = brentq(lambda p: forces(p)[0] - sigma_n, 1e-6 * sigma_n, 1e6 * sigma_n / weight, xtol=1e-12 * sigma_n)
    return float(forces(p)[1])
