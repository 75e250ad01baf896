"""Envelope of a joint of Barton over a range of normal stresses, met by crushed asperities."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...contract import Floats
from ...history import EquilibriumLost
from ...interface import Interface
from ...material import Material, ModelWarning
from ...pattern import Pattern
from .joint import Joint

if TYPE_CHECKING:
    from ..fit.shear_test import ShearTest

STRESSES = 5
"""Normal stresses of an envelope, in equal ratios from the lowest to the highest.

Of an odd number one is in the middle, whose slip at the peak and opening are met, too.
"""

KC = 100.0
"""Ratio kn/ks of the law: the joint of Barton has no closure under the normal stress."""

PRELOAD = 10
"""Increments in which the normal stress is applied before the slip."""

STEP = 0.03
"""Step of the differences of logarithms: wide, because the peak of a curve in rows is not smooth."""

SAME = 1.0e-4
"""Relative change of the sum of squares, and of the constants, at which the least squares end.

The root of the sum is above 1e-3, so that a finer change is not seen.
"""

STEEPEST, WIDE = 2.5, 5.0
"""Largest tangent of the inclination, 68 degrees; largest change of the logarithm of a constant."""

LEAST = 1.0e-3
"""Smallest ratio of a number of the law to that of Barton of which the logarithm is taken."""

ROWS = 200
"""Rows of a curve of an envelope, half of them up to twice the slip at the peak, where the curve bends."""

ROWS_OF_TEST = 100
"""Rows of a curve that is fitted, at equal distances."""

REACH = 10.0
"""End of both curves, in slips at the peak, where half of the roughness is mobilised in Barton's table."""


@dataclass(frozen=True)
class Envelope:
    """Joint of Barton and a law beside it under several normal stresses, MPa, mm and degrees.

    interface: the law.  stresses (n,): compression > 0.  slips (T,): of the curves, from 0 on.  values: kn,
    ks, mu, theta and what ends the asperities, of a law that meets the strengths.
    """

    joint: Joint
    interface: Interface
    stresses: Floats
    slips: Floats
    values: Mapping[str, float]

    def curves(self, stresses: Floats) -> list[tuple[Floats, Floats]]:
        """Shear traction and opening of the law over `slips` for each normal stress.

        Raises ValueError where the law has no equilibrium up to the last slip.
        """
        of_law = []
        for stress in stresses:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ModelWarning)  # the command prints them once
                try:
                    path = self.interface.confined_slip(0.0, self.slips, -float(stress), PRELOAD)
                except EquilibriumLost as lost:
                    last, end = self.slips[[max(lost.row - 1, 0), -1]]
                    raise ValueError(
                        f"sigma_n {stress:g}: the law has equilibrium up to the slip {last:.3g} mm, "
                        f"expected up to {end:.3g} mm"
                    ) from lost
            of_law.append((path.tau, path.dilation - path.dilation[0]))
        return of_law

    @cached_property
    def numbers(self) -> Floats:
        """Peak, its slip and opening at the end at each stress: those of Barton and of the law, (2, n, 3)."""
        return np.array([numbers_of(self.joint, self.stresses, self.slips), self.of_law])

    @cached_property
    def of_law(self) -> Floats:
        """Those of the law, (n, 3)."""
        return self._numbers(self.at_stresses)

    @cached_property
    def at_stresses(self) -> list[tuple[Floats, Floats]]:
        """Curves of the law at the stresses."""
        return self.curves(self.stresses)

    @property
    def closed(self) -> Floats:
        """Numbers of the law in closed form, (n, 3): rigid sides, of which one is loaded, with half of ks."""
        from ..fit.rigid import rigid_curve
        from ..fit.shear_test import ShearTest

        curves, slips = [], self.slips
        for stress in self.stresses:
            test = ShearTest("", slips, slips, None, -float(stress))
            strength, s_N = rigid_curve(test, slips, self.values)
            slope = np.gradient(s_N, slips)
            elastic = 0.5 * self.values["ks"] * slips * (1.0 + slope**2) + stress * slope
            curves.append((np.minimum(strength, elastic), s_N))
        return self._numbers(curves)

    def _numbers(self, curves: Sequence[tuple[Floats, Floats]]) -> Floats:
        """Peak, its slip and opening at the end of curves, (n, 3)."""
        return np.array([(*peak(self.slips, tau), s_N[-1]) for tau, s_N in curves])

    @property
    def parted(self) -> Floats:
        """Strength of the law over that of Barton less one at each stress, (n,)."""
        return np.asarray(self.numbers[1, :, 0] / self.numbers[0, :, 0] - 1.0)

    @property
    def is_met(self) -> bool:
        """Whether no strength of the law is so far from that of Barton that a fit would be no result."""
        from ..fit.thresholds import FAIR, UNSAFE

        return bool(np.all((self.parted >= -FAIR) & (self.parted <= UNSAFE)))


def numbers_of(joint: Joint, stresses: Floats, slips: Floats) -> Floats:
    """Peak, its slip and opening at the last slip of a joint of Barton at each stress, (n, 3)."""
    return np.array(
        [(joint.peak_strength(p), joint.peak_slip, joint.dilation(slips[-1:], p)[0]) for p in stresses]
    )


def peak(slips: Floats, tau: Floats) -> tuple[float, float]:
    """Largest traction of a curve, and its slip by the parabola through the highest row and those beside it.

    The slip of a row would jump where a constant changes.
    """
    i = int(np.clip(np.argmax(tau), 1, tau.size - 2))
    a, b, _ = np.polyfit(slips[i - 1 : i + 2] - slips[i], tau[i - 1 : i + 2], 2)
    if not a < 0.0:
        return float(tau.max()), float(slips[np.argmax(tau)])
    return float(tau.max()), float(np.clip(slips[i] - 0.5 * b / a, slips[i - 1], slips[i + 1]))


def curves(joint: Joint, sigma_n: float) -> ShearTest:
    """Curves of a joint as a test of a fit.  Raises ValueError for a stress out of range."""
    from ..fit.shear_test import ShearTest

    joint.check_stresses(sigma_n)
    slip = np.linspace(0.0, REACH * joint.peak_slip, ROWS_OF_TEST + 1)[1:]
    shear, dilation = joint.shear(slip, sigma_n), joint.dilation(slip, sigma_n)
    return ShearTest(f"sigma_n {sigma_n:g}", slip, shear, dilation, -sigma_n)


def envelope(joint: Joint, low: float, high: float) -> Envelope:
    """Constants of the law whose strengths come closest to those of a joint between two normal stresses.

    mu is tan(phi_r).  Least squares of theta, crush, ks and height on the strengths at five stresses, and on
    the slip at the peak and the opening at the end of the curve at the middle one, all relative.
    The slip climbs one of two planes.  Stresses in MPa.
    Raises ValueError for stresses out of range.

    Examples
    --------
    >>> from asperity.tools.barton.envelope import envelope
    >>> from asperity.tools.barton.joint import Joint
    >>> laws = envelope(Joint(jrc=10.0, jcs=100.0, phi_r=30.0, length=0.1), 0.5, 5.0)
    >>> bool(abs(laws.parted).max() < 0.05)
    True
    """
    from scipy.optimize import least_squares

    joint.check_stresses(low, high)
    if not low < high:
        raise ValueError(f"sigma_n = {low:g}, {high:g}: expected the lower normal stress first")
    stresses, middle = np.geomspace(low, high, STRESSES), STRESSES // 2
    slips = np.interp(np.linspace(0.0, 2.0, ROWS + 1), [0.0, 1.0, 2.0], [0.0, 2.0, REACH]) * joint.peak_slip

    barton = numbers_of(joint, stresses, slips)

    @cache
    def trial(x: tuple[float, ...]) -> Envelope:
        slope, crush, ks, height = np.exp(x).tolist()
        mu, theta = float(np.tan(np.radians(joint.phi_r))), float(np.degrees(np.arctan(slope)))
        values = {"kn": KC * ks, "ks": ks, "mu": mu, "theta": theta, "height": height, "crush": crush}
        material = Material.from_joint(**{name: value for name, value in values.items() if name != "theta"})
        interface = Interface(material, Pattern.regular(2, theta, flat=0.0))
        return Envelope(joint, interface, stresses, slips, values)

    def law(x: Floats) -> Envelope:
        return trial(tuple(x.tolist()))

    def residuals(x: Floats) -> Floats:
        # a trial without equilibrium, or whose joint has closed at the end, is far off, and no error
        try:
            misfit = np.log(np.maximum(law(x).of_law / barton, LEAST))
        except (ValueError, ArithmeticError):
            misfit = np.full((STRESSES, 3), np.log(LEAST))
        return np.append(misfit[:, 0], misfit[middle, 1:])

    def slopes(x: Floats) -> Floats:
        """Derivatives (n, p) of the residuals, by the closed form, which costs next to nothing."""
        columns = []
        for step in STEP * np.eye(x.size):
            change = np.log(law(x + step).closed / law(x - step).closed) / (2.0 * STEP)
            columns.append(np.append(change[:, 0], change[middle, 1:]))
        return np.transpose(columns)

    slope, pressure = np.tan(np.radians(min(joint.roughness_angle(low), 45.0))), float(stresses[middle])
    ks = 2.0 * joint.peak_strength(pressure) / joint.peak_slip
    start = np.log([slope, 2.0 * high, ks, joint.dilation(slips[-1:], pressure)[0]])
    bounds = start - WIDE, np.minimum(start + WIDE, [np.log(STEEPEST), *[np.inf] * 3])
    settings = {"x_scale": "jac", "ftol": SAME, "xtol": SAME}
    near = least_squares(residuals, start, slopes, bounds=bounds, x_scale="jac", ftol=1e-2).x
    # the closed form has another tangent than the law, by much the same at every trial
    there = residuals(near)
    law_slopes = [(residuals(near + step) - there) / STEP for step in STEP * np.eye(near.size)]
    other = np.transpose(law_slopes) - slopes(near)
    solution = least_squares(residuals, near, lambda x: slopes(x) + other, bounds=bounds, **settings)
    if not solution.success:
        raise ValueError("the least squares ended before they converged: expected other normal stresses")
    found = law(solution.x)
    found.numbers  # noqa: B018  # raises where the law has no equilibrium
    return found


def table(envelope: Envelope) -> str:
    """Both laws at the stresses."""
    from pandas import DataFrame, MultiIndex

    names, laws = ("peak tau [MPa]", "at slip [mm]", "s_N at end [mm]"), ("Barton", "law")
    rows = DataFrame(
        envelope.numbers.transpose(1, 2, 0).reshape(-1, 6),
        index=[f"{stress:.4g}" for stress in envelope.stresses],
        columns=MultiIndex.from_product([names, laws]),
    ).rename_axis("sigma_n [MPa]")
    rows.insert(2, (names[0], "differ"), [f"{ratio:.1%}" for ratio in envelope.parted])
    return str(rows.to_string(float_format="{:.4g}".format))


def draw(envelope: Envelope, path: Path) -> None:
    """Draw the envelopes, and the shear traction over the slip at three stresses; Barton dashed."""
    from ..style import COLOURS, TWO, label_axes, new_figure, printed, save

    with printed():
        figure, (envelopes, curves) = new_figure(TWO, 3.0, ncols=2)
        laws = zip(("--", "-"), COLOURS, ("Barton", "law"), envelope.numbers, strict=False)
        for line, colour, label, numbers in laws:
            envelopes.plot(envelope.stresses, numbers[:, 0], line, color=colour, label=label)
        label_axes(envelopes, r"normal stress $\sigma_n$ [MPa]", "peak shear strength [MPa]")
        envelopes.legend()
        some = zip(envelope.stresses, envelope.at_stresses, strict=True)
        for colour, (sigma_n, (tau, _)) in zip(COLOURS, [*some][:: STRESSES // 2], strict=False):
            curves.plot(envelope.slips, envelope.joint.shear(envelope.slips, sigma_n), "--", color=colour)
            curves.plot(envelope.slips, tau, color=colour, label=f"{sigma_n:.3g} MPa")
        label_axes(curves, "slip [mm]", r"traction $\tau$ [MPa]")
        curves.legend(title=r"$\sigma_n$; dashed: Barton")
        save(figure, path)
