"""Envelope of a joint of Barton over a range of normal stresses, met by crushed asperities."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from ..case_writer import Word, case_text, pattern_entries, rounded
from ..contract import Floats
from ..interface import Interface, ModelWarning
from ..material import Material
from ..options import imported
from ..pattern import Pattern
from ..style import COLOURS, TWO, label_axes, new_figure, printed, save
from .joint import Joint, check_reach

STRESSES = 5
"""Normal stresses of an envelope, in equal ratios from the lowest to the highest."""

PARTED = 0.03
"""Relative difference of the strengths that is reported."""

BESIDE = 0.1
"""Weight of the slip at the peak and of the opening at the end beside the strengths of an envelope."""

ROWS = 200
"""Rows of a curve, half of them up to twice the slip at the peak."""


def strength(sigma_n: float, slope: float, mu: float, crush: float, weight: float = 1.0) -> float:
    """Shear strength of a joint without bond that begins to climb one plane, whose pressure crushes it.

    slope: tangent of the inclination; weight: of the plane; crush: stress, inf for none.  Closed form of
    docs/extensions.md, section 7.
    """
    from scipy.optimize import brentq

    def left(p: float) -> tuple[float, float]:
        slope_left = slope * np.log1p(p / crush) / (p / crush) if np.isfinite(crush) else slope
        return slope_left, 1.0 / np.hypot(1.0, slope_left)

    def excess(p: float) -> float:
        t, c = left(p)
        return weight * p * c * (1.0 - mu * t) - sigma_n

    p = brentq(excess, 1e-6 * sigma_n, 1e6 * sigma_n / weight, xtol=1e-12 * sigma_n)
    t, c = left(p)
    return float(weight * p * c * (t + mu))


@dataclass(frozen=True)
class Envelope:
    """Law that meets the envelope of a joint between two normal stresses, MPa, mm and degrees.

    values: kn, ks, mu, theta, height, crush and flat; sides: of the pattern; reach: end of the curves over
    the slip at the peak.
    """

    joint: Joint
    low: float
    high: float
    values: Mapping[str, float]
    sides: int
    reach: float

    @property
    def interface(self) -> Interface:
        """The joint."""
        values = dict(self.values)
        pattern = Pattern.regular(self.sides, values.pop("theta"), flat=values.pop("flat"))
        return Interface(Material.from_joint(**values), pattern)

    @property
    def stresses(self) -> Floats:
        """Normal stresses (5,)."""
        return np.geomspace(self.low, self.high, STRESSES)

    @cached_property
    def slips(self) -> Floats:
        """Slips of the curves from 0 on, (ROWS + 1,)."""
        ends = np.array([0.0, min(2.0, 0.5 * (1.0 + self.reach)), self.reach]) * self.joint.peak_slip
        return np.concatenate(
            [np.linspace(*ends[:2], ROWS // 2 + 1), np.linspace(*ends[1:], ROWS // 2 + 1)[1:]]
        )

    def curves(self, stresses: Floats) -> list[tuple[Floats, Floats]]:
        """Shear traction and opening of the law over `slips` for each normal stress."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ModelWarning)  # the command prints them once
            paths = [self.interface.confined_slip(0.0, self.slips, -float(one)) for one in stresses]
        return [(path.traction[:, 1], path.separation[:, 0] - path.separation[0, 0]) for path in paths]

    @cached_property
    def numbers(self) -> Floats:
        """Peak, its slip and opening at the end at each stress: those of Barton and of the law, (2, 5, 3)."""
        ends = self.slips[-1:]
        barton = [
            (self.joint.peak_strength(one), self.joint.peak_slip, self.joint.dilation(ends, one)[0])
            for one in self.stresses
        ]
        law = [
            (tau.max(), self.slips[: tau.size][tau.argmax()], s_N[-1])
            for tau, s_N in self.curves(self.stresses)
        ]
        return np.array([barton, law])

    @property
    def parted(self) -> Floats:
        """Strength of the law over that of Barton less one at each stress, (5,)."""
        barton, law = self.numbers[:, :, 0]
        found: Floats = law / barton - 1.0
        return found


def envelope(
    joint: Joint,
    low: float,
    high: float,
    sides: int = 2,
    kc: float = 100.0,
    flat: float = 0.0,
    reach: float = 10.0,
) -> Envelope:
    """Constants of the law whose strengths come closest to those of a joint between two normal stresses.

    mu is tan(phi_r).  theta and crush give the strengths at five stresses; ks and height give the slip at the
    peak and the opening at the end of the curve at the middle one.  kc: kn/ks.  The slip climbs
    one of two planes: planes that share the pressure are crushed in jumps.  Stresses in MPa.

    Raises
    ------
    ValueError
        For stresses out of range.

    Examples
    --------
    >>> from asperity.barton.envelope import envelope
    >>> from asperity.barton.joint import Joint
    >>> found = envelope(Joint(jrc=10.0, jcs=100.0, phi_r=30.0, length=0.1), 0.5, 5.0)
    >>> bool(abs(found.parted).max() < 0.05)
    True
    """
    if not low < high:
        raise ValueError(f"sigma_n = {low:g}, {high:g}: expected the lower normal stress first")
    for sigma_n in (low, high):
        joint.check_stress(sigma_n)
    check_reach(reach)
    if not 2 <= sides:
        raise ValueError(f"sides = {sides}: expected at least 2, as the strength depends on inclined planes")
    if not 0.0 <= flat < 1.0:
        raise ValueError(f"flat = {flat:g}: expected >= 0 and < 1")
    imported("scipy")
    from scipy.optimize import least_squares

    mu = float(np.tan(np.radians(joint.phi_r)))
    weight = (1.0 - flat) / sides
    stresses = np.geomspace(low, high, STRESSES)
    peaks = np.array([joint.peak_strength(one) for one in stresses])

    def closed(x: Floats) -> Floats:
        slope, crush = np.exp(x)
        return np.log([strength(one, slope, mu, crush, weight) for one in stresses] / peaks)

    def residuals(x: Floats) -> Floats:
        barton, law = found(x).numbers
        middle = STRESSES // 2
        return np.concatenate([np.log(law[:, 0] / barton[:, 0]), BESIDE * (law / barton - 1.0)[middle, 1:]])

    def found(x: Floats) -> Envelope:
        slope, crush, height, ks = np.exp(x).tolist()
        values = {"kn": kc * ks, "ks": ks, "mu": mu, "theta": float(np.degrees(np.arctan(slope)))}
        return Envelope(
            joint, low, high, values | {"height": height, "crush": crush, "flat": flat}, sides, reach
        )

    slope = np.tan(np.radians(min(joint.roughness_angle(low), 45.0)))
    start = least_squares(closed, np.log([slope, high / weight])).x
    middle = float(np.sqrt(low * high))
    rise = joint.dilation(np.array([reach * joint.peak_slip]), middle)[0]
    secant = joint.peak_strength(middle) / joint.peak_slip
    # a peak is one of the rows: the step of the differences is longer than they are apart
    results = [
        least_squares(residuals, np.append(start, np.log([rise, ks])), diff_step=2e-2)
        for ks in (secant, 4.0 * secant)
    ]
    return found(min(results, key=lambda one: one.cost).x)


def table(found: Envelope) -> str:
    """Both laws at the five stresses, and where they part."""
    lines = [
        f"{'sigma_n':>8}{'peak tau':>20}{'':>9}{'at slip':>18}{'s_N at end':>18}",
        f"{'MPa':>8}{'MPa':>20}{'':>9}{'mm':>18}{'mm':>18}",
        f"{'':8}{'Barton':>11}{'law':>9}{'differ':>9}" + 2 * f"{'Barton':>10}{'law':>8}",
    ]
    for sigma_n, barton, law, off in zip(found.stresses, *found.numbers, found.parted, strict=True):
        row = f"{sigma_n:>8.4g}{barton[0]:>11.4g}{law[0]:>9.4g}{off:>9.1%}"
        lines.append(row + "".join(f"{a:>10.4g}{b:>8.4g}" for a, b in zip(barton[1:], law[1:], strict=True)))
    far = [f"{one:.4g}" for one, off in zip(found.stresses, found.parted, strict=True) if abs(off) > PARTED]
    where = (
        f"by more than {PARTED:.0%} at {', '.join(far)} MPa" if far else f"nowhere by more than {PARTED:.0%}"
    )
    return "\n".join([*lines, "", f"The strengths of the law and of Barton part {where}."])


def case_of(found: Envelope) -> str:
    """Case file of the joint with the five stresses as a sweep."""
    material = {n: rounded(v, 6) for n, v in dict(found.values).items() if n not in ("theta", "flat")}
    stresses = [rounded(-one, 4) for one in found.stresses]
    return case_text(
        ("case", {"title": "Joint of Barton"}),
        ("material", material),
        ("pattern", pattern_entries(found.interface.pattern)),
        ("sweep", {"name": "sigma_N", "values": stresses}),
        ("step", {"t_N": Word("sigma_N"), "increments": 50}),
        ("step", {"slip": rounded(found.slips[-1], 6), "increments": ROWS}),
    )


@printed()
def draw(found: Envelope, path: Path) -> None:
    """Draw the envelopes, and the shear traction over the slip at three stresses; Barton dashed."""
    figure, (envelopes, curves) = new_figure(TWO, 3.0, ncols=2)
    many = np.geomspace(found.low, found.high, 25)
    envelopes.plot(
        many, [found.joint.peak_strength(one) for one in many], "--", color=COLOURS[0], label="Barton"
    )
    envelopes.plot(many, [tau.max() for tau, _ in found.curves(many)], color=COLOURS[1], label="law")
    label_axes(envelopes, r"normal stress $\sigma_n$ [MPa]", "peak shear strength [MPa]")
    envelopes.legend()
    some = found.stresses[:: STRESSES // 2]
    for i, (sigma_n, (tau, _)) in enumerate(zip(some, found.curves(some), strict=True)):
        curves.plot(found.slips, found.joint.shear(found.slips, sigma_n), "--", color=COLOURS[i])
        curves.plot(found.slips[: tau.size], tau, color=COLOURS[i], label=f"{sigma_n:.3g} MPa")
    label_axes(curves, "slip [mm]", r"traction $\tau$ [MPa]")
    curves.legend(title=r"$\sigma_n$; dashed: Barton")
    save(figure, path)
