"""Rock joint of Barton: peak strength, peak dilation angle, and both mobilised over the slip.

Sources: Barton and Choubey (1977), Rock Mechanics 10, 1-54, doi 10.1007/BF01261801 (strength, dilation);
Barton (1982), ONWI-308, and Barton, Bandis and Bakhtar (1985), Int. J. Rock Mech. Min. Sci. 22, 121-140
(mobilised JRC, peak slip); Barton and Bandis (1982), Proc. 23rd US Symp. Rock Mech., 739-760 (scale).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...contract import Floats
from ..tables import raise_all

SAMPLE, LARGEST_JRC, STEEPEST = 0.1, 20.0, 70.0
"""Length of the laboratory samples that JRC and JCS usually belong to, m; largest JRC of the scale; and
largest peak angle arctan(tau/sigma_n) for which the criterion is meant, degrees.
"""

MOBILISED = (
    (0.3, 0.0), (0.6, 0.75), (1.0, 1.0), (2.0, 0.85), (4.0, 0.7), (10.0, 0.5), (25.0, 0.4), (100.0, 0.0),
)  # fmt: skip
"""Slip over the slip at the peak, and mobilised JRC over that at the peak (Barton 1982).

At zero slip the mobilised angle is -phi_r, so that the shear traction begins at zero.
"""

FINE = 4000
"""Intervals over which the dilation is integrated, besides those between the kinks of the table."""


@dataclass(frozen=True)
class Joint:
    """Joint of roughness JRC, wall strength JCS (MPa) and residual friction angle phi_r (degrees).

    length: of the joint; sample: of the samples that JRC and JCS were measured on; m.  Normal stresses
    sigma_n are positive in compression, in MPa.  Raises ValueError that names a value out of range.
    """

    jrc: float
    jcs: float
    phi_r: float
    length: float
    sample: float = SAMPLE

    def __post_init__(self) -> None:
        """Check the ranges."""
        rules = (
            ("JRC", self.jrc, LARGEST_JRC, f"> 0 and <= {LARGEST_JRC:g}"),
            ("JCS", self.jcs, np.inf, "a strength in MPa, > 0"),
            ("phi_r", self.phi_r, STEEPEST, f"degrees, > 0 and <= {STEEPEST:g}"),
            ("sample", self.sample, self.length, f"m, > 0 and <= length = {self.length:g}"),
        )
        bad = [(name, value, wanted) for name, value, most, wanted in rules if not 0.0 < value <= most]
        raise_all([f"{name} = {value:g}: expected {wanted}" for name, value, wanted in bad])

    @property
    def jrc_n(self) -> float:
        """JRC of the whole length, JRC (L/L_0)^(-0.02 JRC)."""
        return float(self.jrc * (self.length / self.sample) ** (-0.02 * self.jrc))

    @property
    def jcs_n(self) -> float:
        """JCS of the whole length, JCS (L/L_0)^(-0.03 JRC), MPa."""
        return float(self.jcs * (self.length / self.sample) ** (-0.03 * self.jrc))

    @property
    def peak_slip(self) -> float:
        """Slip at the peak strength, L/500 (JRC/L)^0.33 with L in m; the result is in mm."""
        return float(1e3 * self.length / 500.0 * (self.jrc_n / self.length) ** 0.33)

    def check_stresses(self, *stresses: float) -> None:
        """Raise ValueError for a normal stress that the criterion is not meant for."""
        for sigma_n in stresses:
            wanted = f"sigma_n = {sigma_n:g}: expected"
            if not 0.0 < sigma_n < self.jcs_n:
                raise ValueError(f"{wanted} compression > 0 and < {self.jcs_n:.4g} MPa, JCS of the length")
            angle = self.phi_r + self.roughness_angle(sigma_n)
            if angle > STEEPEST:
                text = f"at most {STEEPEST:g} degrees of phi_r + JRC log10(JCS/sigma_n)"
                raise ValueError(f"{wanted} {text}, not {angle:.4g}: a larger stress")

    def roughness_angle(self, sigma_n: float) -> float:
        """JRC log10(JCS/sigma_n), degrees: what roughness adds to phi_r at the peak."""
        return float(self.jrc_n * np.log10(self.jcs_n / sigma_n))

    def peak_strength(self, sigma_n: float) -> float:
        """Peak shear strength sigma_n tan(phi_r + JRC log10(JCS/sigma_n)), MPa."""
        return float(sigma_n * np.tan(np.radians(self.phi_r + self.roughness_angle(sigma_n))))

    def damage_coefficient(self, sigma_n: float) -> float:
        """M = JRC/(12 log10(JCS/sigma_n)) + 0.70, which lowers the dilation angle."""
        return float(self.jrc_n / (12.0 * np.log10(self.jcs_n / sigma_n)) + 0.7)

    def shear(self, slip: Floats, sigma_n: float) -> Floats:
        """Shear traction over the slip (T,), mm, from 0 on; MPa."""
        tau: Floats = sigma_n * np.tan(np.radians(self.phi_r + self._mobilised(slip, sigma_n)))
        return tau

    def dilation(self, slip: Floats, sigma_n: float) -> Floats:
        """Opening over the slip (T,), mm: the integral of the tangent of the mobilised dilation angle.

        Dilation begins at 0.3 of the peak slip, where the mobilised JRC becomes positive.
        """
        from scipy.integrate import cumulative_trapezoid

        kinks = np.array(MOBILISED)[:, 0] * self.peak_slip
        fine = np.union1d(np.linspace(0.0, float(np.max(slip)), FINE + 1), kinks)
        angle = np.maximum(self._mobilised(fine, sigma_n), 0.0) / self.damage_coefficient(sigma_n)
        opening = cumulative_trapezoid(np.tan(np.radians(angle)), fine, initial=0.0)
        dilation: Floats = np.interp(slip, fine, opening)
        return dilation

    def _mobilised(self, slip: Floats, sigma_n: float) -> Floats:
        """Mobilised roughness angle, degrees: linear in the slip up to the peak, in its logarithm beyond."""
        ratio, share = np.array(MOBILISED).T
        angle = self.roughness_angle(sigma_n) * share
        x = np.asarray(slip) / self.peak_slip
        peak = int(np.argmax(share))
        rising = np.interp(x, np.append(0.0, ratio[: peak + 1]), np.append(-self.phi_r, angle[: peak + 1]))
        falling = np.interp(np.log10(np.maximum(x, 1.0)), np.log10(ratio[peak:]), angle[peak:])
        mobilised: Floats = np.where(x <= 1.0, rising, falling)
        return mobilised
