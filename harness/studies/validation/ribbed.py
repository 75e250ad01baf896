"""A ribbed bar in concrete: slip under constant confinement (Malvar 1992), an anchored bar with its cover."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from asperity.contract import Floats
from asperity.interface import Interface
from asperity.material import ModelWarning
from asperity.steps import Step
from asperity.tools.style import TWO, new_figure
from asperity.tools.tables import markdown
from matplotlib.figure import Figure
from scipy.optimize import brentq

from ..concepts_draw import BLACK, BLUE, GREEN, panel
from .common import Constants, Study, joint

PRESSURES = (3.45, 10.3, 17.2, 24.1, 31.0)
"""Confining stress at the bar, MPa."""

FACTOR = 3.0
"""Strength at the largest over that at the smallest pressure, as the abstract says ("almost threefold")."""

THETA = float(np.degrees(np.arctan(0.8)))
RIBS: Constants = {"mu": 0.5, "theta": THETA, "height": 1.0}
"""Friction, flank and height of the ribs, assumed."""

BOND: Constants = {"sigma0": 5.0, "Gc": 3.0}
CRUSH = 3.0
"""Bond and crushing stress, assumed; the bond of the fit replaces sigma0."""

SLIP = 4.0
DIAMETER, COVER, E_STEEL, E_CONCRETE, NU = 19.05, 76.2, 2e5, 3e4, 0.2
"""Bar and cylinder of concrete round it, diameters, mm; MPa."""

TENSION = 3.0
"""Tensile strength of the concrete, MPa."""


def model(constants: Mapping[str, float]) -> Interface:
    """Joint of two flanks; a joint without bond has the stiffness of the others."""
    values = dict(constants)
    if "sigma0" not in values:
        values |= {"kn": 5e4, "ks": 500.0}
    return joint(values)


@cache
def _curve(constants: tuple[tuple[str, float], ...], pressure: float) -> tuple[Floats, Floats, Floats]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelWarning)
        whole = model(dict(constants)).run(
            [Step(t_N=-pressure, increments=20), Step(slip=SLIP, increments=400)]
        )
    test = whole.after_step(1)
    return test.separation[:, 1], test.traction[:, 1], test.separation[:, 0]


def curve(constants: Mapping[str, float], pressure: float) -> tuple[Floats, Floats, Floats]:
    """Slip, bond stress and radial opening under a constant pressure, mm, MPa."""
    return _curve(tuple(constants.items()), pressure)


def strengths(constants: Mapping[str, float]) -> Floats:
    """Largest bond stress at each pressure."""
    return np.array([curve(constants, one)[1].max() for one in PRESSURES])


def fits() -> dict[str, Constants]:
    """Bond and crush by the one number of the abstract; the others for comparison."""

    def excess(sigma0: float) -> float:
        found = strengths(RIBS | BOND | {"crush": CRUSH, "sigma0": sigma0})
        return float(found[-1] / found[0] - FACTOR)

    sigma0 = float(f"{brentq(excess, 0.5, 30.0, xtol=1e-3):.4g}")
    return {
        "friction": RIBS,
        "crush": RIBS | {"crush": CRUSH},
        "bond": RIBS | BOND,
        "bond and crush": RIBS | BOND | {"crush": CRUSH, "sigma0": sigma0},
    }


def model_code(slip: Floats) -> Floats:
    """Bond stress over its largest, Model Code 2010, pull-out, confined, clear rib spacing 12 mm."""
    rising, falling = (slip / 1.0) ** 0.4, 1.0 - 0.6 * (slip - 2.0) / (12.0 - 2.0)
    return np.where(slip < 1.0, rising, np.where(slip < 2.0, 1.0, np.maximum(falling, 0.4)))


# --- an anchored bar ----------------------------------------------------------------------------------------


def cover_stiffness() -> float:
    """Pressure over radial displacement of a thick ring, MPa/mm."""
    inner, outer = 0.5 * DIAMETER, 0.5 * COVER
    return E_CONCRETE / (inner * ((outer**2 + inner**2) / (outer**2 - inner**2) + NU))


@dataclass
class Bar:
    """A bar of axial springs, whose joint is restrained by a ring: loaded at its end, free at the other.

    length: embedded, mm.  stiffness: of the ring, MPa/mm; most: pressure at which the ring has split and
    yields; pressure: confinement from the start, MPa.
    """

    law: Interface
    length: float
    stiffness: float
    most: float = np.inf
    pressure: float = 0.0
    parts: int = 40

    def __post_init__(self) -> None:
        """Set up lengths and state."""
        n = self.parts + 1
        self.x = np.linspace(0.0, self.length, n)
        self.share = np.full(n, self.length / self.parts)
        self.share[[0, -1]] *= 0.5
        self.around = np.pi * DIAMETER * self.share
        k = E_STEEL * np.pi * DIAMETER**2 / 4.0 * self.parts / self.length
        self.K = k * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
        self.K[[0, -1], [0, -1]] = k
        self.s, self.state, self.tau = np.zeros((n, 3)), np.zeros((n, self.law.nstatv)), np.zeros(n)

    def ring(self, w: Floats) -> tuple[Floats, Floats]:
        """Pressure of the ring at an opening, and its derivative."""
        p = self.pressure + self.stiffness * w
        return np.minimum(p, self.most), np.where(p < self.most, self.stiffness, 0.0)

    def opened(self, u: Floats) -> Floats:
        """Openings at which joint and ring balance, by bisection."""
        low, high = np.full(len(u), -1.0), np.full(len(u), 2.0)
        for _ in range(60):
            w = 0.5 * (low + high)
            traction = self.law.update(np.column_stack([w, u, 0.0 * u]), self.state, self.s).traction
            closes = traction[:, 0] + self.ring(w)[0] < 0.0
            low, high = np.where(closes, w, low), np.where(closes, high, w)
        return 0.5 * (low + high)

    def pull(self, end: float, most: int = 60) -> float:
        """Take the loaded end to a displacement, mm; the force there, N."""
        u = self.s[:, 1] + (end - self.s[-1, 1])
        base, step, last = u, 0.0 * u, np.inf
        for _ in range(most):
            s = np.column_stack([self.opened(u), u, 0.0 * u])
            new = self.law.update(s, self.state, self.s)
            left = self.K @ u + self.around * new.traction[:, 1]
            force, left[-1] = float(left[-1]), 0.0
            size = float(np.abs(left / self.around).max())
            if size < 1e-7 * max(1.0, np.abs(new.traction).max()):
                self.s, self.state, self.tau = s, new.state, new.traction[:, 1]
                return force
            if size > last * (1.0 - 1e-4):
                step = 0.5 * step
            else:
                base, last, D = u, size, new.tangent
                soft = D[:, 1, 1] - D[:, 1, 0] * D[:, 0, 1] / (D[:, 0, 0] + self.ring(s[:, 0])[1])
                A = self.K + np.diag(self.around * soft)
                A[-1] = 0.0
                A[-1, -1] = 1.0
                step = -np.linalg.solve(A, left)
            u = base + step
        raise RuntimeError(f"no equilibrium at {end:g} mm")


def elastic(length: float = 300.0) -> float:
    """Largest error of the bond stress along a long bar, over its largest: beta of a linear bond."""
    flat = joint({"kn": 2e3, "ks": 20.0, "mu": 5.0, "theta": 1.0, "flat": 1.0})
    bar = Bar(flat, length, 0.0, pressure=1e3, parts=200)
    bar.pull(1e-5)
    force = bar.pull(1e-3)
    beta = np.sqrt(4.0 * 20.0 / (DIAMETER * E_STEEL))
    closed = force * beta / (np.pi * DIAMETER) * np.cosh(beta * bar.x) / np.sinh(beta * length)
    return float(np.abs(bar.tau / closed - 1.0).max())


EMBEDDED = 95.25
"""Embedded length of the anchored bar, five diameters, mm."""


@cache
def anchored(case: str) -> tuple[Floats, float]:
    """Displacement of the loaded end and force, mm, N, and the largest pressure on the ring, MPa."""
    most = TENSION * (COVER - DIAMETER) / DIAMETER
    kinds = {
        "constant confinement 10.3 MPa": {"stiffness": 0.0, "pressure": PRESSURES[1]},
        "cover, elastic": {"stiffness": cover_stiffness()},
        "cover, splits": {"stiffness": cover_stiffness(), "most": most},
    }
    bar = Bar(model(STUDY.constants()["bond and crush"]), EMBEDDED, **kinds[case])
    rows, largest = [], 0.0
    for end in np.concatenate([np.linspace(0.0, 0.2, 81), np.linspace(0.21, 3.0, 280)]):
        rows.append([end, bar.pull(end)])
        largest = max(largest, float(bar.ring(bar.s[:, 0])[0].max()))
    return np.array(rows), largest


CASES = "constant confinement 10.3 MPa", "cover, elastic", "cover, splits"


def tables(found: Mapping[str, Constants]) -> dict[str, str]:
    """Strengths and openings of the fits, the curve beside the Model Code, the anchored bar."""
    body = []
    for fit, constants in found.items():
        strong = strengths(constants)
        opened = [curve(constants, one)[2].max() for one in (PRESSURES[0], PRESSURES[-1])]
        body.append([fit, *(f"{one:.1f}" for one in strong), f"{strong[-1] / strong[0]:.2f}",
                     *(f"**{one:.2f}**" for one in opened)])  # fmt: skip
    head = [
        "model",
        *(f"{one:g} MPa" for one in PRESSURES),
        "factor",
        "opening at 3.45 MPa, mm",
        "at 31 MPa, mm",
    ]
    slip, tau, _ = curve(found["bond and crush"], PRESSURES[2])
    rows = []
    for at in (0.1, 0.25, 0.5, 1.0, 2.0, 4.0):
        ours = float(np.interp(at, slip, tau) / tau.max())
        rows.append([f"{at:g}", f"{ours:.2f}", f"{float(model_code(np.array(at))):.2f}"])
    bars = []
    for case in CASES:
        path, pressure = anchored(case)
        k = int(path[:, 1].argmax())
        mean = path[k, 1] / (np.pi * DIAMETER * EMBEDDED)
        numbers = path[k, 1] / 1e3, mean, path[k, 0], path[-1, 1] / 1e3, pressure
        bars.append([case, *(f"{one:.{2 if i == 2 else 1}f}" for i, one in enumerate(numbers))])
    bar_head = [
        "restraint", "largest force, kN", "mean bond stress, MPa", "at the displacement, mm",
        "force at 3 mm, kN", "largest pressure, MPa",
    ]  # fmt: skip
    return {
        "strengths": markdown(head, body),
        "curve": markdown(["slip, mm", "law at 17.2 MPa", "Model Code 2010"], rows),
        "bar": markdown(bar_head, bars),
        "elastic": f"The stress along a bar of 300 mm with a linear bond differs from the closed form by "
        f"{elastic():.0e} of its value.",
    }


def draw(found: Mapping[str, Constants]) -> Figure:
    """Draw bond stress over slip at five pressures, and force over displacement of the bar."""
    figure, (left, right) = new_figure(TWO, 2.9, ncols=2)
    for pressure in PRESSURES:
        slip, tau, _ = curve(found["bond and crush"], pressure)
        left.plot(slip, tau, color=BLUE)
        left.annotate(f"{pressure:g} MPa", (slip[-1], tau[-1]), ha="right", va="bottom", fontsize=7)
    slip, tau, _ = curve(found["bond and crush"], PRESSURES[2])
    left.plot(slip, tau.max() * model_code(slip), "--", color=BLACK, label="Model Code, scaled")
    panel(left, "slip [mm]", "bond stress [MPa]")
    for case, colour in zip(CASES, (BLUE, GREEN, BLACK), strict=True):
        path, _ = anchored(case)
        right.plot(path[:, 0], path[:, 1] / 1e3, color=colour, label=case)
    panel(right, "displacement of the loaded end [mm]", "force [kN]")
    for ax in (left, right):
        ax.legend()
    return figure


STUDY = Study("ribbed", fits, tables, draw)

if __name__ == "__main__":
    sys.exit(STUDY.main())
