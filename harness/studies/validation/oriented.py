"""Surfaces made with an orientation: the strength over the direction of slip, closed form and law."""

from __future__ import annotations

import sys
from collections.abc import Mapping

import numpy as np
from asperity.contract import Floats
from asperity.interface import Interface
from asperity.material import Material
from asperity.pattern import Pattern
from asperity.steps import Step
from asperity.tools.style import TWO, new_figure
from asperity.tools.tables import markdown
from matplotlib.figure import Figure
from scipy.optimize import brentq

from ..concepts_draw import BLACK, BLUE, GREEN, panel
from .common import Constants, Study

MU, THETA = 0.5, 30.0
"""Friction, and inclination of both sides of the ridges, degrees."""

ANGLES = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0)
"""Between the slip and the steepest ascent of a side, degrees."""

STRENGTHS = {0.0: 1.10, 90.0: 0.60}
"""Strength over pressure across and along the ridges of a surface that is to be made."""

STIFF = 1e4
"""Stiffness of the contact over pressure and slip: the joint is rigid but for 1e-4."""


def confined(a: float, mu: float = MU, theta: float = THETA) -> Floats:
    """Strength, side force and dilation of a slip whose side is held, over pressure and slip.

    A plane with the normal n slides along d in itself: its stress is p (mu d - n), and w is the length of
    (tan theta cos a, cos a, sin a).
    """
    T, c = np.tan(np.radians(theta)), np.cos(np.radians(a))
    w, sine, cosine = np.sqrt(1.0 + (T * c) ** 2), np.sin(np.radians(theta)), np.cos(np.radians(theta))
    pressure = cosine - mu * T * c / w
    side = -sine * np.sin(np.radians(a)) if a < 90.0 else 0.0  # along the ridges both sides push
    return np.array([sine * c + mu / w, side, T * c * pressure]) / pressure


def free(a: float, mu: float = MU, theta: float = THETA) -> Floats:
    """Strength, side slip and dilation over pressure and slip, where the side is free.

    The slip turns to the angle b at which the stress has the angle a.  Beyond tan(a) = mu/sin(theta) it
    follows the ridges, and both sides push.
    """
    T, sine = np.tan(np.radians(theta)), np.sin(np.radians(theta))
    tangent = np.tan(np.radians(a))
    if tangent * sine >= mu * (1.0 - 1e-9):
        ridge = np.radians(90.0 - a)
        return np.array([mu / np.cos(np.radians(theta)) / np.sin(np.radians(a)), np.tan(ridge), 0.0])

    def excess(b: float) -> float:
        w = np.sqrt(1.0 + (T * np.cos(b)) ** 2)
        return float(mu * np.sin(b) / w - tangent * (sine + mu * np.cos(b) / w))

    b = float(brentq(excess, np.radians(a) * 0.999, 0.5 * np.pi, xtol=1e-14)) if a > 0.0 else 0.0
    along, across, dilation = confined(np.degrees(b), mu, theta)
    turn = b - np.radians(a)
    return np.array([np.hypot(along, across), np.tan(turn), dilation / np.cos(turn)])


def law(a: float, side_free: bool, mu: float = MU, theta: float = THETA) -> Floats:
    """The same of the law, by a load path of one point with the pattern turned against the slip."""
    joint = Interface(
        Material.from_joint(kn=STIFF, ks=STIFF, mu=mu), Pattern.regular(2, theta, flat=0.0, turn=-a)
    )
    side = {"t_Ty": 0.0} if side_free else {"s_Ty": 0.0}
    test = joint.run([Step(t_N=-1.0), Step(s_Tx=[0.5, 1.0], increments=20, **side)])
    s, t = test.separation[[-21, -1]], test.traction[-1]
    rate = (s[1] - s[0]) / (s[1, 1] - s[0, 1])
    return np.array([t[1], rate[2] if side_free else t[2], rate[0]])


def ridges_of(strengths: Mapping[float, float]) -> tuple[float, float]:
    """Friction and inclination of ridges with these strengths across (0) and along (90) them.

    Along them the strength is mu/cos(theta), across them (mu + tan theta)/(1 - mu tan theta).
    """
    across, along = strengths[0.0], strengths[90.0]

    def excess(theta: float) -> float:
        mu, T = along * np.cos(np.radians(theta)), np.tan(np.radians(theta))
        return float((mu + T) - across * (1.0 - mu * T))

    theta = float(brentq(excess, 0.0, 80.0, xtol=1e-12))
    return float(along * np.cos(np.radians(theta))), theta


def tables(_: Mapping[str, Constants]) -> dict[str, str]:
    """Closed form and law over the angle, and the surface that is made."""
    head = [
        "angle", "strength", "side force", "dilation", "strength, free", "side slip", "dilation, free",
        "largest difference",
    ]  # fmt: skip
    body = []
    for a in ANGLES:
        closed = np.concatenate([confined(a), free(a)])
        away = np.abs(np.concatenate([law(a, False), law(a, True)]) - closed).max()
        body.append([f"{a:g}°", *(f"{value + 0.0:.4f}" for value in closed), f"{away:.0e}"])
    mu, theta = ridges_of(STRENGTHS)
    rows = []
    for a in (0.0, 30.0, 45.0, 60.0, 90.0):
        closed, computed = confined(a, mu, theta)[0], law(a, False, mu, theta)[0]
        rows.append(
            [f"{a:g}°", f"{STRENGTHS[a]:.2f}" if a in STRENGTHS else "", f"{closed:.4f}", f"{computed:.4f}"]
        )
    constants = f"mu = {mu:.4f}, theta = {theta:.2f}°\n\n"
    made_head = ["angle", "strength wanted", "closed form", "law"]
    return {"angles": markdown(head, body), "made": constants + markdown(made_head, rows)}


def draw(_: Mapping[str, Constants]) -> Figure:
    """Draw strength and side force, and the direction of a free slip, over the angle."""
    figure, axes = new_figure(TWO, 2.9, ncols=2)
    angles = np.linspace(0.0, 90.0, 181)
    held, slips = np.array([confined(a) for a in angles[:-1]]), np.array([free(a) for a in angles])
    axes[0].plot(angles[:-1], held[:, 0], color=BLUE, label="strength")
    axes[0].plot(angles[:-1], -held[:, 1], color=GREEN, label="side force, held")
    axes[0].plot(angles, slips[:, 0], "--", color=BLUE, label="strength, free side")
    axes[1].plot(angles, np.degrees(np.arctan(slips[:, 1])), "--", color=BLUE, label="turn of a free slip")
    climb = np.degrees(np.arctan(held[:, 2]))
    axes[1].plot(angles[:-1], climb, color=GREEN, label="dilation angle, held")
    for a in ANGLES:
        confined_slip, free_slip = law(a, False), law(a, True)
        axes[0].plot(
            [a, a, a], [confined_slip[0], -confined_slip[1], free_slip[0]], "o", color=BLACK, markersize=3.5
        )
        turns = np.degrees(np.arctan([free_slip[1], confined_slip[2]]))
        axes[1].plot([a, a], turns, "o", color=BLACK, markersize=3.5)
    panel(axes[0], "angle between slip and ascent [°]", "over the pressure [-]")
    panel(axes[1], "angle between slip and ascent [°]", "angle [°]")
    for ax in axes:
        ax.legend()
    return figure


STUDY = Study("oriented", dict, tables, draw)

if __name__ == "__main__":
    sys.exit(STUDY.main())
