"""Envelope of a joint of Barton over a range of normal stresses, met by crushed asperities."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..contract import Floats
from ..interface import Interface, ModelWarning
from ..material import Material
from ..pattern import Pattern
from .joint import MOBILISED, Joint

if TYPE_CHECKING:
    from ..fit.records import ShearTest

STRESSES, PASSES, KC = 5, 8, 100.0
"""Normal stresses of an envelope, in equal ratios from the lowest to the highest; passes in which the
constants are corrected: always as many, so that the constants change smoothly; and kn/ks.
"""

PARTED = 0.03
"""Relative difference of the strengths that is reported."""

STEEPEST, STEEPER = 2.5, 8.0
"""Largest tangent of the inclination, 68 degrees, and how much steeper it may be than what roughness adds to
phi_r at the lowest stress, degrees: steeper planes, which are crushed at once, meet the closed form only.
"""

ROWS, ROWS_OF_TEST, REACH = 200, 100, 10.0
"""Rows of a curve of an envelope, half of them up to twice the slip at the peak, and of one that is fitted;
its default end, in slips at the peak.
"""


def strength(sigma_n: float, slope: float, mu: float, crush: float, weight: float = 1.0) -> float:
    """Shear strength of a joint without bond that begins to climb one plane, whose pressure crushes it.

    slope: tangent of the inclination; weight: of the plane; crush: stress, inf for none.  Closed form of
    docs/extensions.md, section 7.
    """
    from scipy.optimize import brentq

    def forces(p: float) -> Floats:
        t = slope * np.log1p(p / crush) / (p / crush) if np.isfinite(crush) else slope
        return np.asarray(weight * p / np.hypot(1.0, t) * np.array([1.0 - mu * t, t + mu]))

    p = brentq(lambda p: forces(p)[0] - sigma_n, 1e-6 * sigma_n, 1e6 * sigma_n / weight, xtol=1e-12 * sigma_n)
    return float(forces(p)[1])


@dataclass(frozen=True)
class Envelope:
    """Joint of Barton and a law beside it under several normal stresses, MPa, mm and degrees.

    interface: the law.  stresses (n,): compression > 0.  slips (T,): of the curves, from 0 on.  values: kn,
    ks, mu, theta, height and crush of a law that meets the strengths.
    """

    joint: Joint
    interface: Interface
    stresses: Floats
    slips: Floats
    values: Mapping[str, float]

    def curves(self, stresses: Floats) -> list[tuple[Floats, Floats]]:
        """Shear traction and opening of the law over `slips` for each normal stress."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ModelWarning)  # the command prints them once
            paths = [self.interface.confined_slip(0.0, self.slips, -float(one)) for one in stresses]
        return [(path.tau, path.dilation - path.dilation[0]) for path in paths]

    @cached_property
    def numbers(self) -> Floats:
        """Peak, its slip and opening at the end at each stress: those of Barton and of the law, (2, n, 3)."""
        joint, ends = self.joint, self.slips[-1:]
        barton = [
            (joint.peak_strength(one), joint.peak_slip, joint.dilation(ends, one)[0]) for one in self.stresses
        ]
        law = [(*peak(self.slips, tau), s_N[-1]) for tau, s_N in self.curves(self.stresses)]
        return np.array([barton, law])

    @property
    def parted(self) -> Floats:
        """Strength of the law over that of Barton less one at each stress, (n,)."""
        return np.asarray(self.numbers[1, :, 0] / self.numbers[0, :, 0] - 1.0)


def peak(slips: Floats, tau: Floats) -> tuple[float, float]:
    """Largest traction of a curve, and its slip by the parabola through the highest row and those beside it.

    The slip of a row would jump where a constant changes.
    """
    i = int(np.clip(np.argmax(tau), 1, tau.size - 2))
    a, b, _ = np.polyfit(slips[i - 1 : i + 2] - slips[i], tau[i - 1 : i + 2], 2)
    if not a < 0.0:
        return float(tau.max()), float(slips[np.argmax(tau)])
    return float(tau.max()), float(np.clip(slips[i] - 0.5 * b / a, slips[i - 1], slips[i + 1]))


def _check(joint: Joint, reach: float, *stresses: float) -> None:
    """Raise ValueError for stresses out of range, and for an end of curves that does not pass the peak."""
    joint.check_stresses(*stresses)
    last = MOBILISED[-1][0]
    if not 1.0 < reach <= last:
        raise ValueError(f"reach = {reach:g}: expected slips at the peak, > 1 and <= {last:g}")


def curves(joint: Joint, stresses: Sequence[float], reach: float = REACH) -> list[ShearTest]:
    """Curves of a joint as tests of a fit, one for each normal stress; reach: their end in slips at the peak.

    Raises ValueError for stresses out of range and for a reach that does not pass the peak.
    """
    from ..fit.records import ShearTest

    _check(joint, reach, *stresses)
    slip = np.linspace(0.0, reach * joint.peak_slip, ROWS_OF_TEST + 1)[1:]
    return [
        ShearTest(f"sigma_n {one:g}", slip, joint.shear(slip, one), joint.dilation(slip, one), -one)
        for one in stresses
    ]


def envelope(joint: Joint, low: float, high: float, reach: float = REACH) -> Envelope:
    """Constants of the law whose strengths come closest to those of a joint between two normal stresses.

    mu is tan(phi_r).  theta and crush give the strengths at five stresses; ks and height give the slip at the
    peak and the opening at the end of the curve at the middle one.  Each pass takes the deviation of the law
    from the closed form as known, so that the constants change smoothly with those of the joint.
    The slip climbs one of two planes: planes that share the pressure are crushed in jumps.  Stresses in MPa.

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
    from scipy.optimize import least_squares

    _check(joint, reach, low, high)
    if not low < high:
        raise ValueError(f"sigma_n = {low:g}, {high:g}: expected the lower normal stress first")
    mu, stresses = float(np.tan(np.radians(joint.phi_r))), np.geomspace(low, high, STRESSES)
    ends = np.array([0.0, min(2.0, 0.5 * (1.0 + reach)), reach]) * joint.peak_slip
    slips = np.interp(np.linspace(0.0, 2.0, ROWS + 1), [0.0, 1.0, 2.0], ends)
    peaks = np.array([joint.peak_strength(one) for one in stresses])
    steepest = min(STEEPEST, float(np.tan(np.radians(min(STEEPER + joint.roughness_angle(low), 80.0)))))
    bounds = np.log([[0.01 * steepest, 0.02 * low], [steepest, 200.0 * high]])
    middle = STRESSES // 2

    def closed(x: Floats) -> Floats:
        slope, crush = np.exp(x)
        return np.array([strength(one, slope, mu, crush, 0.5) for one in stresses])

    # theta and crush from the closed form, times the ratio of the law to it; ks and height by proportion
    x = np.log([np.tan(np.radians(min(joint.roughness_angle(low), 45.0))), 2.0 * high])
    height = float(joint.dilation(slips[-1:], stresses[middle])[0])
    ks, ratio = 2.0 * float(peaks[middle]) / joint.peak_slip, np.ones(STRESSES)
    for _ in range(PASSES):
        x = least_squares(lambda x, ratio=ratio: np.log(closed(x) * ratio / peaks), x, bounds=bounds).x
        slope, crush = np.exp(x).tolist()
        values = {"kn": KC * ks, "ks": ks, "mu": mu, "height": height, "crush": crush}
        theta = float(np.degrees(np.arctan(slope)))
        interface = Interface(Material.from_joint(**values), Pattern.regular(2, theta, flat=0.0))
        found = Envelope(joint, interface, stresses, slips, values | {"theta": theta})
        barton, law = found.numbers
        ratio = law[:, 0] / closed(x)
        factors = np.clip((law / barton)[middle, 1:], 0.5, 2.0).tolist()
        ks, height = ks * factors[0], height / factors[1]
    return found


def table(found: Envelope) -> str:
    """Both laws at the stresses, and where they part."""
    from pandas import DataFrame

    names, laws = ("peak tau [MPa]", "at slip [mm]", "s_N at end [mm]"), ("Barton", "law")
    places = [(i, k) for i in range(len(names)) for k in range(len(laws))]
    columns = {(names[i], laws[k]): found.numbers[k, :, i] for i, k in places}
    rows = DataFrame(columns, index=[f"{one:.4g}" for one in found.stresses]).rename_axis("sigma_n [MPa]")
    rows.insert(2, (names[0], "differ"), [f"{one:.1%}" for one in found.parted])
    far = ", ".join(rows.index[np.abs(found.parted) > PARTED])
    parted = f"part {'' if far else 'nowhere '}by more than {PARTED:.0%}{f' at {far} MPa' if far else ''}"
    text = rows.to_string(float_format="{:.4g}".format)
    return f"{text}\n\nThe strengths of the law and of Barton {parted}."


def draw(found: Envelope, path: Path) -> None:
    """Draw the envelopes, and the shear traction over the slip at three stresses; Barton dashed."""
    from ..style import COLOURS, TWO, label_axes, new_figure, printed, save

    with printed():
        figure, (envelopes, curves) = new_figure(TWO, 3.0, ncols=2)
        many = np.geomspace(found.stresses[0], found.stresses[-1], 25)
        strengths = {
            "Barton": [found.joint.peak_strength(one) for one in many],
            "law": [tau.max() for tau, _ in found.curves(many)],
        }
        for line, colour, (label, values) in zip(("--", "-"), COLOURS, strengths.items(), strict=False):
            envelopes.plot(many, values, line, color=colour, label=label)
        label_axes(envelopes, r"normal stress $\sigma_n$ [MPa]", "peak shear strength [MPa]")
        envelopes.legend()
        some = found.stresses[:: STRESSES // 2]
        for colour, sigma_n, (tau, _) in zip(COLOURS, some, found.curves(some), strict=False):
            curves.plot(found.slips, found.joint.shear(found.slips, sigma_n), "--", color=colour)
            curves.plot(found.slips[: tau.size], tau, color=colour, label=f"{sigma_n:.3g} MPa")
        label_axes(curves, "slip [mm]", r"traction $\tau$ [MPa]")
        curves.legend(title=r"$\sigma_n$; dashed: Barton")
        save(figure, path)
